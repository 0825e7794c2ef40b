"""How a verb ends: 0 done, 1 unusable input, 2 wrong usage, 3 part of the input refused, 130 interrupted."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from calibore.errors import CaliboreError

PARTLY_REFUSED = 3
INTERRUPTED = 130


@contextmanager
def telling_failures() -> Iterator[None]:
    """A CaliboreError becomes its sentence on standard error and its exit status; nothing else is caught."""
    try:
        yield
    except CaliboreError as error:
        print(f"calibore: {error}", file=sys.stderr)
        sys.exit(error.exit_status)
    except KeyboardInterrupt:
        print("calibore: interrupted; no result was written under its final name.", file=sys.stderr)
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(1)
