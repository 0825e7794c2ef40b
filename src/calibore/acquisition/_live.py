"""The run as a whole: a result folder out of what a source brings, and a journal that outlives a kill."""

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from calibore.acquisition._book import Book
from calibore.acquisition._job import Limits, LiveJob
from calibore.acquisition._journal import Journal, journal_folder
from calibore.acquisition._run import Run, Watch
from calibore.acquisition._source import LiveSource
from calibore.errors import InputError, OutputError
from calibore.profiling import Finisher, Sealed
from calibore.scans import ResultWriter, ScanSpec


def live_scan(
    live: LiveJob,
    source: Callable[[Book], LiveSource],
    out: Path | str,
    *,
    limits: Limits,
    watch: Watch,
    resume: bool = False,
    finish_only: bool = False,
    finisher: Finisher | None = None,
) -> dict[str, Any]:
    """Measure what `source` brings until it or one of `limits` ends the run; write the result folder `out`.

    `source` is called when it is known what was measured before. `resume`: go on with the journal of a run that was
    killed; `finish_only`: write out what it had measured. Raises InputError where nothing can be measured, OutputError
    where the result cannot be written or a journal is in the way; the journal then stays.
    """
    _check_new(Path(out), live.spec)
    with ResultWriter(out, live.spec) as writer, _journal(Path(out), live, resume=resume or finish_only) as journal:
        book = Book(writer, journal)
        try:
            run = Run(live, book, source, limits, watch)
            ended = run.all(finish_only=finish_only)
        finally:
            book.close_table()
        summary = run.summary(ended)
        folder = writer.seal()
        if finisher:
            finisher(Sealed(folder, live.spec, live.job.rig, summary, run.example))
        writer.finish(summary)
        journal.remove()
    return summary


def _check_new(out: Path, spec: ScanSpec) -> None:
    """What a stream has sent cannot be measured again: its result is never written over."""
    if spec.stream is not None and (out / "summary.json").exists():
        raise OutputError(f"{out} holds the result of an earlier run, which no camera can repeat; give another folder.")


@contextmanager
def _journal(out: Path, live: LiveJob, *, resume: bool) -> Iterator[Journal]:
    journal, about = Journal(journal_folder(out)), _about(live)
    earlier = journal.about()
    if journal.empty:
        journal.remove()
    elif not resume:
        raise OutputError(
            f"{journal.folder} holds {journal.rings} rings that a run into {out} had measured when it was killed; go "
            "on with them by --resume, write them out by --finish, or remove that folder to begin anew."
        )
    elif earlier is None or any(earlier.get(key) != value for key, value in about.items()):
        raise InputError(
            f"{journal.folder} was measured with another rig file, estimator or scan; use the same, or remove that "
            "folder to begin anew."
        )
    try:
        journal.begin(about)
        yield journal
    finally:
        journal.close()
        if journal.empty:
            journal.remove()


def _about(live: LiveJob) -> dict[str, Any]:
    """What a run that goes on with the journal of another must have in common with it."""
    spec = live.spec
    rig = spec.rig_path.read_bytes() if spec.rig_path else b""
    settings = repr((spec.nominal_radius, spec.search_inner, spec.search_outer)).encode()
    digest = hashlib.sha256(rig + settings).hexdigest()[:16]
    return {"identity": spec.identity, "estimator": live.job.estimator, "rig": digest}


def default_workers() -> int:
    """Threads where nobody says how many."""
    return os.cpu_count() or 1
