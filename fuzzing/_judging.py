"""What a reader may do with a useless file: refuse it in a sentence, soon, with little memory, without a warning."""

import resource
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from calibore.errors import CaliboreError

LONGEST = 5.0
"""s of the processor for one call."""
HANGING = 30.0
"""s of the processor after which it is ended."""
MEMORY = 1 << 30
"""bytes of address space beyond those at the start."""
LONGEST_SENTENCE = 1200


class HangingError(BaseException):
    """No reader catches this one."""


def fault_of(work: Callable[[], object]) -> str | None:
    """What is wrong with how `work` went, the place first; None where nothing is."""
    start, fault = time.process_time(), None
    with warnings.catch_warnings(record=True) as said, _ended_after(HANGING):
        warnings.simplefilter("always")
        try:
            work()
        except CaliboreError as error:
            fault = _fault_of_sentence(error)
        except HangingError as error:
            fault = f"hangs\n{_places(error)}"
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # a panic in Rust is no Exception
            fault = f"{type(error).__name__} at {_place(error)}: {str(error)[:300]}\n{_places(error)}"
    took = time.process_time() - start
    if fault is None and said:
        fault = f"warning at {said[0].filename.rsplit('/', 2)[-1]}:{said[0].lineno}: {str(said[0].message)[:300]}"
    if fault is None and took > LONGEST:
        fault = f"slow: {took:.1f} s of the processor"
    return fault


def limit_memory() -> None:
    """Let the process have `MEMORY` more address space than it has now; more is a MemoryError, and that a fault."""
    with open("/proc/self/statm", encoding="ascii") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))


def _fault_of_sentence(error: CaliboreError) -> str | None:
    sentence = str(error)
    mistakes = {
        "empty": not sentence.strip(),
        "more than one line": any(not letter.isprintable() for letter in sentence),
        "too long": len(sentence) > LONGEST_SENTENCE,
        "no full stop": not sentence.rstrip(")").endswith((".", "?")),
    }
    wrong = [name for name, there in mistakes.items() if there]
    if not wrong:
        return None
    return f"sentence at {_place(error)}: {', '.join(wrong)}: {sentence[:400]!a}\n{_places(error)}"


def _place(error: BaseException) -> str:
    """Innermost file and line, for telling faults apart."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "/calibore/" in frame.filename] or frames
    return f"{ours[-1].filename.rsplit('/', 2)[-2]}/{ours[-1].filename.rsplit('/', 1)[-1]}:{ours[-1].lineno}"


def _places(error: BaseException) -> str:
    return "".join(traceback.format_list(traceback.extract_tb(error.__traceback__)[-12:]))


@contextmanager
def _ended_after(seconds: float) -> Iterator[None]:
    def end(*_: object) -> None:
        raise HangingError

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
