"""What happens between the lens and the scene: the entrance pupil walks along the axis, a flat port refracts.

Both keep a ray in its plane through the axis. So all they do is move the place where its line crosses the axis, and
bend its zenith.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.optics._port import FlatPort

STEPS = 100
SETTLED = 1e-10  # [rad]; Newton squares it, so the zenith then stands to rounding


class Departure(NamedTuple):
    """Rays on their way to the scene, (n,) each: where [m] they cross the axis; sine and cosine of their zenith."""

    crossing: NDArray[Any]
    sine: NDArray[Any]
    cosine: NDArray[Any]


class DepartureSlopes(NamedTuple):
    """Derivatives of the crossing and of the departing zenith, by the lens's zenith and by each `parameter_names`."""

    crossing_by_zenith: NDArray[Any]
    zenith_by_zenith: NDArray[Any]
    crossing_by_parameters: list[NDArray[Any]]
    zenith_by_parameters: list[NDArray[Any]]


@dataclass(frozen=True)
class Pupil:
    """`walk` (d2, d4, ...) [m]: the entrance pupil lies at d2 zenith^2 + d4 zenith^4 + ...; then comes the `port`."""

    walk: tuple[float, ...]
    port: FlatPort | None

    @property
    def parameter_names(self) -> tuple[str, ...]:
        walk = (f"pupil_walk_{2 * i + 2}" for i in range(len(self.walk)))
        return (*walk, *(f"port_{name}" for name in (self.port.parameter_names if self.port else ())))

    def place(self, zenith: NDArray[Any]) -> NDArray[Any]:
        """Where on the axis [m] the pupil of rays at `zenith` lies."""
        square = zenith * zenith
        total = np.zeros_like(square)
        for coefficient in reversed(self.walk):
            total = (total + coefficient) * square
        return total

    def place_by_zenith(self, zenith: NDArray[Any]) -> NDArray[Any]:
        total = np.zeros_like(zenith)
        for i, coefficient in enumerate(self.walk):
            total = total + (2 * i + 2) * coefficient * zenith ** (2 * i + 1)
        return total

    def depart(self, zenith: NDArray[Any]) -> Departure:
        """The rays that the lens takes in at `zenith` (n,); NaN where a port does not let them pass."""
        place = self.place(zenith)
        if self.port is None:
            return Departure(place, np.sin(zenith), np.cos(zenith))
        passage, index = self.port.passage(zenith), self.port.medium_index
        return Departure(self.port.crossing(passage, place), passage.sine / index, passage.medium / index)

    def slopes(self, zenith: NDArray[Any]) -> DepartureSlopes:
        """What moves the rays of `depart`."""
        place_slope = self.place_by_zenith(zenith)
        powers = [zenith ** (2 * i + 2) for i in range(len(self.walk))]
        still = np.zeros_like(zenith)
        if self.port is None:
            return DepartureSlopes(place_slope, np.ones_like(zenith), powers, [still for _ in powers])
        place, passage = self.place(zenith), self.port.passage(zenith)
        deeper = passage.medium / passage.cosine
        return DepartureSlopes(
            deeper * place_slope + self.port.crossing_by_zenith(passage, place),
            1 / deeper,
            [deeper * power for power in powers] + self.port.crossing_by_parameters(passage, place),
            [still for _ in powers] + [still] * 3 + [-passage.sine / (self.port.medium_index * passage.medium)],
        )

    def zenith(self, off_axis: NDArray[Any], ahead: NDArray[Any], *, max_zenith: float) -> NDArray[Any]:
        """The zenith [rad] at which the lens takes in points `off_axis` and `ahead` [m], (n,) each.

        NaN where no ray below `max_zenith` comes from: behind, in the port, outside Snell's window. A point nearer to
        the pupil than the pupil walks may be seen twice; one of the two is given.
        """
        if self.port is None:
            seen, high = (off_axis > 0) | (ahead > 0), max_zenith
        else:
            seen, high = ahead > self.port.outer_face, min(max_zenith, self.port.max_zenith)
        zenith = np.full(off_axis.shape, np.nan)
        seen &= np.isfinite(off_axis) & np.isfinite(ahead)
        zenith[seen] = self._solved(off_axis[seen], ahead[seen], high)
        return zenith

    def _solved(self, off_axis: NDArray[Any], ahead: NDArray[Any], most: float) -> NDArray[Any]:
        """The root of `_miss` in [0, most] by Newton, halving the bracket wherever Newton leaves it or dawdles."""
        answer, left = np.full(off_axis.shape, np.nan), np.arange(off_axis.size)
        zenith = np.minimum(np.arctan2(off_axis, ahead), most)
        low, high, last = np.zeros_like(zenith), np.full_like(zenith, most), np.full_like(zenith, most)
        for _ in range(STEPS):
            miss, slope = self._miss(zenith, off_axis[left], ahead[left])
            low, high = np.where(miss > 0, zenith, low), np.where(miss > 0, high, zenith)
            with np.errstate(all="ignore"):  # a flat place gives no step; the bracket is halved instead
                newton = zenith - miss / slope
                trusted = (newton >= low) & (newton <= high) & (2 * np.abs(newton - zenith) <= last)
            step = np.where(trusted, newton, (low + high) / 2) - zenith
            zenith, last = zenith + step, np.abs(step)
            settled = trusted & (last <= SETTLED)
            answer[left[settled]] = zenith[settled]
            going = ~settled & (high > low)
            if not going.any():
                break
            left, zenith, low, high, last = (part[going] for part in (left, zenith, low, high, last))
        return answer

    def _miss(
        self, zenith: NDArray[Any], off_axis: NDArray[Any], ahead: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """A length that falls through 0 where the ray at `zenith` meets the point, and its derivative."""
        place, place_slope = self.place(zenith), self.place_by_zenith(zenith)
        sine, cosine = np.sin(zenith), np.cos(zenith)
        if self.port is None:
            miss, slope = off_axis * cosine - (ahead - place) * sine, -off_axis * sine - (ahead - place) * cosine
        else:
            miss, slope = self.port.miss(zenith, start=place, off_axis=off_axis, ahead=ahead)
        return miss, slope + place_slope * sine
