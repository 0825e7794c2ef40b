"""One run from its first picture to its last: pictures come, rings go into the result folder and the journal."""

import time
from collections.abc import Callable, Mapping
from contextlib import closing
from threading import Event, Thread
from typing import Any, Protocol

from calibore.acquisition._backlog import Backlog, LeftOut, now
from calibore.acquisition._book import Book
from calibore.acquisition._job import Limits, LiveJob
from calibore.acquisition._measuring import Outcome, measured, prepared
from calibore.acquisition._ring import KeptRing
from calibore.acquisition._source import LiveSource
from calibore.acquisition._stream import LiveStream
from calibore.acquisition._summary import live_summary
from calibore.acquisition._vitals import Vitals
from calibore.errors import InputError
from calibore.profiling import Example, StationRefusedError, StationResult


class Watch(Protocol):
    """Whoever watches a run; called from the thread that measures."""

    def ring(self, vitals: Vitals, /) -> None:
        """A ring is measured and stored; `vitals.row` is it."""
        ...

    def beat(self, vitals: Vitals, /) -> None:
        """Several times a second."""
        ...

    def say(self, sentence: str, /) -> None: ...


class Run:
    """One run from its first picture to its last."""

    def __init__(
        self,
        live: LiveJob,
        book: Book,
        source: Callable[[Book], LiveSource],
        limits: Limits,
        watch: Watch,
    ) -> None:
        self._live, self._book, self._limits, self._watch = live, book, limits, watch
        self._replayed = book.replay()
        self._source = source(book)
        self._backlog = Backlog(live.size, keep=live.keep)
        self._vitals = Vitals(self._source.name)
        self._stop = Event()
        self._ended = "idle"
        self._last_reason = ""
        self.example: Example | None = None

    def all(self, *, finish_only: bool) -> str:
        """Measure until the end; returns why it came."""
        if finish_only:
            self._ended = "finished"
        else:
            with prepared():
                Thread(target=self._fetch, name="calibore source", daemon=True).start()
                self._measure()
        self._book.close(sorted(self._live.place.expected))
        if self._book.tally.stations == 0:
            self._nothing()
        return self._ended

    def _fetch(self) -> None:
        try:
            for arrival in self._source.arrivals(self._backlog, self._stop):
                if not self._backlog.put(arrival, self._stop):
                    break
        except Exception as error:
            self._backlog.close(error)
        else:
            self._backlog.close()

    def _measure(self) -> None:
        live = self._live
        outcomes = measured(self._backlog, live.job, live.place, workers=live.workers, beat=self._beat)
        with closing(outcomes):
            for outcome in outcomes:
                self._take(outcome)
                if self._limits.count is not None and self._vitals.rings >= self._limits.count:
                    self._end("count")
                    break
        self._stop.set()
        self._tell()
        error = self._backlog.error
        if isinstance(error, InputError) and self._book.tally.stations:
            self._watch.say(str(error))
        elif error is not None:
            raise error

    def _beat(self) -> None:
        vitals, backlog = self._vitals, self._backlog
        self._tell()
        vitals.arrived, vitals.backlog = backlog.arrived, len(backlog) + self._source.waiting
        vitals.connected = self._source.connected
        vitals.arriving.sample(backlog.arrived)
        vitals.measuring.sample(vitals.rings)
        self._watch.beat(vitals)
        if self._limits.stop.is_set():
            self._end("stopped")
        elif self._limits.duration is not None and vitals.seconds >= self._limits.duration:
            self._end("duration")

    def _end(self, why: str) -> None:
        """No picture is fetched any more; those that wait are measured."""
        if not self._stop.is_set():
            self._ended = why
            self._stop.set()
            self._backlog.close()

    def _tell(self) -> None:
        for event in self._backlog.events():
            if isinstance(event, LeftOut):
                self._book.leave_out(event)
            else:
                self._vitals.sentence = event
                self._watch.say(event)
        self._vitals.dropped, self._vitals.refused = self._book.dropped, self._book.refused

    def _take(self, outcome: Outcome) -> None:
        images, result, book = outcome.arrival.images, outcome.result, self._book
        if book.began is None:
            book.begin((self._source.began if isinstance(self._source, LiveStream) else None) or time.time())
        if result is None:
            book.add_unplaced(images)
        elif isinstance(result, StationRefusedError):
            book.add_refused(images, result.images)
            self._refusal(str(result), result.images[0].reason)
        else:
            book.add_ring(KeptRing.of(result, images.takes, timed=images.time_s is not None))
            self._ring(result, outcome.arrival.at)

    def _refusal(self, sentence: str, reason: str) -> None:
        """Say why pictures are refused, once for each reason in a row."""
        if reason != self._last_reason:
            self._last_reason = self._vitals.sentence = reason
            self._watch.say(f"{sentence}.")

    def _ring(self, result: StationResult, at: float) -> None:
        self._last_reason = ""
        if self.example is None:
            self.example = result.first_image(), result.lines[0].stripe
        profile = result.profile
        where: Mapping[str, Any] = {"station": profile.station, "axial_m": profile.axial, "time_s": profile.time_s}
        self._vitals.ring({**where, **result.row}, now() - at)
        self._vitals.measuring.sample(self._vitals.rings)
        self._watch.ring(self._vitals)

    def _nothing(self) -> None:
        self._book.journal.remove()
        if self._book.tally.refused_images:
            raise InputError(self._book.tally.nothing_left(self._live.spec.folder))
        raise InputError(
            f"{self._vitals.source} sent no picture in {self._vitals.seconds:.0f} s, so there is nothing to write; "
            "check the camera, or the pattern of the pictures' names."
        )

    def summary(self, ended: str) -> dict[str, Any]:
        """What is written into summary.json."""
        return live_summary(
            self._live, self._book, self._vitals, source=self._source, ended=ended, replayed=self._replayed
        )
