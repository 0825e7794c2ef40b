"""One writer per destination: a lock that the operating system drops when its process dies, however it dies."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from calibore.errors import OutputError

_held: set[Path] = set()


@contextmanager
def locked(destination: Path) -> Iterator[None]:
    """Hold `.NAME.lock` beside `destination`; raises OutputError when another run holds it.

    A record lock, not flock: worker processes forked by a run that was killed would go on holding an flock. A record
    lock belongs to the process, so a second writer in this process is found through `_held`.
    """
    path = destination.with_name(f".{destination.name}.lock")
    if path in _held:
        raise _busy(destination)
    descriptor = _acquire(path, destination)
    _held.add(path)
    try:
        yield
    finally:
        _held.discard(path)
        with suppress(OSError):
            path.unlink()
        os.close(descriptor)
        if sys.platform == "win32":
            with suppress(OSError):
                path.unlink()


def _acquire(path: Path, destination: Path) -> int:
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            _lock(descriptor)
            # The run before us may have removed the file between our opening and locking it.
            if os.path.samestat(os.fstat(descriptor), os.stat(path)):
                return descriptor
        except FileNotFoundError:
            pass
        except OSError as error:
            if error.errno in (errno.EACCES, errno.EAGAIN, errno.EDEADLK):
                os.close(descriptor)
                raise _busy(destination) from error
            # A file system without locks (some network shares): go on, trusting the user not to run twice at once.
            return descriptor
        os.close(descriptor)


def _lock(descriptor: int) -> None:
    if sys.platform == "win32":
        import msvcrt

        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.lockf(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _busy(destination: Path) -> OutputError:
    return OutputError(f"{destination} is being written by another run; wait for it to end or choose another name.")
