"""Errors a user can act on: one sentence that says what is wrong, where, and what to do.

Everything raised on purpose is a `CaliboreError`; the command line prints its sentence and leaves with `exit_status`.
One bad point is never an error: it is NaN with a `calibore.status.Status`.
"""


class CaliboreError(Exception):
    """Base of all errors raised on purpose."""

    exit_status = 1


class InputError(CaliboreError):
    """What was given (a file, a value, a folder) cannot be used."""


class ImageError(InputError):
    """One image cannot be read or used; a survey goes on without it."""


class OutputError(CaliboreError):
    """The result cannot be written where it was asked for."""


class UsageError(CaliboreError):
    """The command line itself is wrong (an unknown option value, say)."""

    exit_status = 2
