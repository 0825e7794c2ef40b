"""What a live run adds to the summary that every profile has."""

import datetime
from typing import Any

from calibore.acquisition._book import LEFT_OUT, Book
from calibore.acquisition._stream import LiveStream
from calibore.acquisition._vitals import Vitals
from calibore.profiling import Job, summarise
from calibore.scans import ScanSpec

ENDED = {
    "count": "as many rings as asked for",
    "duration": "the time asked for is over",
    "idle": "no more pictures came",
    "stopped": "stopped by hand",
    "finished": "what a killed run had measured was written out",
}


def live_summary(
    spec: ScanSpec, job: Job, book: Book, vitals: Vitals, *, source: object, ended: str, replayed: int, by_step: bool
) -> dict[str, Any]:
    """The summary of `calibore profile`, with what only a live run has under "live"; its warnings are told too."""
    found = summarise(spec, job, book.tally)
    counts = found["counts"] | {"dropped_images": book.dropped}
    live = {
        "source": vitals.source,
        "began": None if book.began is None else _moment(book.began),
        "ended": ENDED[ended],
        "rings_of_a_killed_run": replayed,
        "latency_s": {
            "median": vitals.latencies.quantile(0.5),
            "percentile_95": vitals.latencies.quantile(0.95),
            "largest": vitals.latencies.largest,
        },
    }
    warnings = [*found["warnings"], *_warnings(book, source, replayed=replayed, by_step=by_step)]
    if isinstance(source, LiveStream):
        live["absences"] = source.absences
    return found | {"command": "live", "counts": counts, "live": live, "warnings": warnings}


def _warnings(book: Book, source: object, *, replayed: int, by_step: bool) -> list[str]:
    found = []
    if book.dropped and book.dropped_between:
        pictures = "1 picture was" if book.dropped == 1 else f"{book.dropped} pictures were"
        first, last = book.dropped_between
        found.append(
            f"{pictures} dropped between {first:.1f} s and {last:.1f} s, because they came faster than they could be "
            f"measured; {LEFT_OUT} lists every one."
        )
    away = source.absences if isinstance(source, LiveStream) else 0
    if away:
        found.append(f"The source was away {'once' if away == 1 else f'{away} times'} and came back or was given up.")
    if by_step and isinstance(source, LiveStream) and (away or replayed):
        found.append(
            "Positions count pictures, and nobody counted them while the source or this program was away: what was "
            "travelled meanwhile is missing in every later position. Use a speed or an odometry table."
        )
    return found


def _moment(unix: float) -> str:
    return datetime.datetime.fromtimestamp(unix, datetime.UTC).isoformat(timespec="milliseconds")
