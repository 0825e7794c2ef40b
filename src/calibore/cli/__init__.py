"""The command line: one file per verb; every verb imports what it needs only when it runs."""

from calibore.cli._app import app, main

__all__ = ["app", "main"]
