"""`--help` without the check of options, which costs more than everything else a help text needs."""

import sys
from collections.abc import Sequence
from typing import Any

import typer

HELP = "--help"


def help_text(app: typer.Typer, arguments: Sequence[str]) -> str | None:
    """The help that `arguments` ask for; None where they ask for none, or name no verb that exists.

    Typer reads even a lone `--help` with a validation library whose import takes half of the 0.3 s a help may take.
    """
    if HELP not in arguments:
        return None
    command: Any = typer.main.get_command(app)
    context = typer.Context(command, info_name=app.info.name)
    for word in arguments[: arguments.index(HELP)]:
        if not hasattr(command, "commands"):
            break
        if word not in command.commands:
            return None
        command = command.commands[word]
        context = typer.Context(command, info_name=word, parent=context)
    return command.get_help(context)


def show_help(app: typer.Typer) -> bool:
    """Print the help that the command line asks for; whether it did."""
    text = help_text(app, sys.argv[1:])
    if text is not None:
        typer.echo(text)
    return text is not None
