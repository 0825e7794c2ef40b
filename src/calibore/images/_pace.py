"""Whether whoever reads a stream keeps up with it, told from when its packets come and what time they bear."""

from dataclasses import dataclass

LIMIT = 1.0
"""Seconds behind the source from which packets are skipped."""
WINDOW, GROWING = 0.5, 3
"""Seconds of a window, and windows in a row in which the delay must have grown: a source that pauses delays once."""
GROWTH = 0.05
"""Share of a window by which the delay must grow to count as growing."""
DRIFT = 1e-3
"""How fast the source's clock may run against ours."""
CAUGHT_UP = 0.1
"""Seconds of delay, or less, at which nothing more is waiting."""
GAIN = 0.1
"""Share of a window by which skipping must lessen the delay, else nothing was waiting: the source itself is late."""


@dataclass
class Pace:
    """Fed with every packet; says which ones to skip, so that a reader that is too slow for its stream stays fresh.

    Delay is the time since a packet's own time, over the least such difference so far. Where it has grown for a while,
    packets are skipped undecoded until they come at the source's pace again, and then up to the next key frame.
    """

    _least: float | None = None
    _last: float = 0.0
    _window: tuple[float, float] | None = None
    _grown: int = 0
    _skipping: bool = False
    _drained: bool = False

    def skips(self, time: float, moment: float, *, key: bool) -> bool:
        """Whether to skip the packet of this `time` [s] of the source's clock that came at `moment` [s] of ours."""
        delay = self._delay(time, moment)
        self._last = moment
        if self._skipping:
            self._drained |= delay < CAUGHT_UP or self._is_the_sources_own(delay, time, moment)
            self._skipping = not (self._drained and key)
            if not self._skipping:
                self._window, self._grown, self._drained = None, 0, False
            return self._skipping
        self._watch(delay, moment)
        if delay > LIMIT and self._grown >= GROWING:
            self._skipping, self._window = True, (moment, delay)
        return self._skipping

    def _delay(self, time: float, moment: float) -> float:
        since = moment - time
        if self._least is None:
            self._least = since
        else:
            self._least = min(since, self._least + DRIFT * (moment - self._last))
        return since - self._least

    def _is_the_sources_own(self, delay: float, time: float, moment: float) -> bool:
        begun, before = self._window or (moment, delay)
        if moment - begun < WINDOW:
            return False
        if before - delay < GAIN * (moment - begun):
            self._least = moment - time
            return True
        self._window = moment, delay
        return False

    def _watch(self, delay: float, moment: float) -> None:
        if self._window is None:
            self._window = moment, delay
        elif moment - self._window[0] >= WINDOW:
            grown = delay - self._window[1] > GROWTH * (moment - self._window[0])
            self._grown = self._grown + 1 if grown else 0
            self._window = moment, delay
