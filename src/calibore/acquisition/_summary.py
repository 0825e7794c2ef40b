"""What a live run adds to the summary that every profile has."""

import datetime
from typing import Any

from calibore.acquisition._book import LEFT_OUT, Book
from calibore.acquisition._job import LiveJob
from calibore.acquisition._stream import LiveStream
from calibore.acquisition._vitals import Vitals
from calibore.profiling import summarise

ENDED = {
    "count": "as many rings as asked for",
    "duration": "the time asked for is over",
    "idle": "no more pictures came",
    "stopped": "stopped by hand",
    "finished": "what a killed run had measured was written out",
}


def live_summary(
    live: LiveJob, book: Book, vitals: Vitals, *, source: object, ended: str, replayed: int
) -> dict[str, Any]:
    """The summary of `calibore profile`, with what only a live run has under "live"; its warnings are told too."""
    found = summarise(live.spec, live.job, book.tally)
    counts = found["counts"] | {"dropped_images": book.dropped}
    said: dict[str, Any] = {
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
    warnings = [*found["warnings"], *_warnings(live, book, source, replayed=replayed)]
    if isinstance(source, LiveStream):
        said["absences"] = source.absences
    return found | {"command": "live", "counts": counts, "live": said, "warnings": warnings}


def _warnings(live: LiveJob, book: Book, source: object, *, replayed: int) -> list[str]:
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
    if live.by_step and isinstance(source, LiveStream) and (away or replayed):
        found.append(
            "Positions count pictures, and nobody counted them while the source or this program was away: what was "
            "travelled meanwhile is missing in every later position. Use a speed or an odometry table."
        )
    if live.standing:
        found.append(
            "Nobody said that the rig moves: every ring lies at axial position 0, and time_s in profile.zarr tells "
            "when it was taken. Give --speed, --step or --odometry where it does."
        )
    return found


def _moment(unix: float) -> str:
    return datetime.datetime.fromtimestamp(unix, datetime.UTC).isoformat(timespec="milliseconds")
