"""How a verb ends: 0 done, 1 unusable input, 2 wrong usage, 3 part of the input refused, 130 interrupted.

Wrong usage is what the command line alone shows to be wrong: an unknown verb, option, estimator, unit or format.
Results go to standard output, everything about them to standard error.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from calibore.errors import CaliboreError, InputError, UsageError

PARTLY_REFUSED = 3
INTERRUPTED = 130
LEFT_AS_IT_WAS = "interrupted; the result folder is as it was before."


@contextmanager
def telling_failures() -> Iterator[None]:
    """What can go wrong without a fault of this program becomes one sentence on standard error and an exit status."""
    try:
        yield
    except CaliboreError as error:
        _leave(str(error), error.exit_status)
    except KeyboardInterrupt:
        _leave(LEFT_AS_IT_WAS, INTERRUPTED)
    except SystemExit as leaving:  # Typer makes one of an interrupt, without a word
        if leaving.code == INTERRUPTED:
            print(f"calibore: {LEFT_AS_IT_WAS}", file=sys.stderr)
        raise
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _leave(f"{where}{error.strerror or error}; check that path and its permissions.", CaliboreError.exit_status)


@contextmanager
def wrong_usage() -> Iterator[None]:
    """What is checked in this block before any file is opened is a mistake in the command line."""
    try:
        yield
    except InputError as error:
        raise UsageError(str(error)) from error


def _leave(sentence: str, status: int) -> NoReturn:
    print(f"calibore: {sentence}", file=sys.stderr)
    sys.exit(status)
