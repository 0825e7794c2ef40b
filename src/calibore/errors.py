"""Errors a user can act on: one sentence that says what is wrong, where, and what to do.

Everything raised on purpose is a `CaliboreError`; the command line prints its sentence and leaves with `exit_status`.
One bad point is never an error: it is NaN with a `calibore.status.Status`.
"""

import unicodedata

LONGEST = 1000
"""Characters of a sentence: what it repeats of a file may be of any length."""
END = 250
"""Of these stand at its end, which says what to do."""
UNPRINTED = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")


class CaliboreError(Exception):
    """Base of all errors raised on purpose. What no terminal should be sent, which files may hold, is written out."""

    exit_status = 1

    def __init__(self, sentence: str = "", *more: object) -> None:
        super().__init__(_printable(str(sentence)), *more)


class InputError(CaliboreError):
    """What was given (a file, a value, a folder) cannot be used."""


class ImageError(InputError):
    """One image cannot be read or used; a survey goes on without it."""


class OutputError(CaliboreError):
    """The result cannot be written where it was asked for."""


class UsageError(CaliboreError):
    """The command line itself is wrong (an unknown option value, say)."""

    exit_status = 2


def _printable(sentence: str) -> str:
    if not sentence.isprintable():
        sentence = "".join(map(_written_out, sentence))
    if len(sentence) > LONGEST:
        sentence = f"{sentence[: LONGEST - END]} ... {sentence[-END:]}"
    return sentence


def _written_out(letter: str) -> str:
    if letter.isprintable() or unicodedata.category(letter) not in UNPRINTED:
        return letter
    return " " if letter == "\n" else ascii(letter)[1:-1]
