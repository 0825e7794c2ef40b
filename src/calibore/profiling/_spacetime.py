"""Spacetime analysis of a scan whose steps are smaller than its line is thick (Swanbom 2007, 2.3.5).

Every place of the wall that one picture shows in the line is followed through the pictures before and after it, while
the light sweeps over it: when it is brightest, the middle of the light is there, whatever lies beside it
(`calibore.stripe.passages`). Its place in the picture at that moment is what is triangulated.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.images import ImageSource, Pixels, StationImages
from calibore.profiling._job import Job
from calibore.profiling._placement import Placement, Placer
from calibore.profiling._station import Line, StationLines, find_lines
from calibore.profiling._take import place_on_wall
from calibore.stripe import Passage, brightness_at, passages, replaced

Array = NDArray[np.float64]
REACH = 3.0
"""Standard deviations of a passage before and after its middle that are looked at."""
MOST_PICTURES = 25
"""Of a passage, evenly chosen where there are more."""
COARSEST = 1.25
"""Standard deviations of a passage from one picture to the next, at most: then five of them fall into its reach."""
ROUNDS = 2
"""The first places come from one picture, the second from the passages over the first."""
DEGREE = 3
"""Of the polynomials by which places move in the picture while the light passes."""


@dataclass(frozen=True)
class Window:
    """The stops whose pictures show places that the station at `own` shows in its line."""

    own: Placement
    stops: tuple[tuple[StationImages, Placement], ...]


class _Kept:
    """Reads a picture once, for all the stations that need it."""

    def __init__(self, read: Callable[[int], Pixels]) -> None:
        self._read, self._pictures, self._lock = read, dict[int, Pixels](), Lock()

    def __call__(self, take: int) -> Pixels:
        with self._lock:
            if take not in self._pictures:
                self._pictures[take] = self._read(take)
            return self._pictures[take]

    def __reduce__(self) -> tuple[type["_Kept"], tuple[Callable[[int], Pixels]]]:
        return _Kept, (self._read,)


def windows(
    stops: Iterable[tuple[StationImages, Placement]], reach: float
) -> Iterator[tuple[StationImages, Placement, Window]]:
    """Every stop with those within `reach` [m] along the pipe; no more than these are kept in memory."""
    before, after = deque[tuple[StationImages, Placement]](), deque[tuple[StationImages, Placement]]()
    rest = ((replace(images, read=_Kept(images.read)), placement) for images, placement in stops)
    while after or (first := next(rest, None)):
        if not after:
            after.append(first)  # pyright: ignore[reportPossiblyUnboundVariable]
        images, own = after[0]

        def near(stop: tuple[StationImages, Placement], own: Placement = own) -> bool:
            return abs(stop[1].axial - own.axial) <= reach

        while near(after[-1]) and (following := next(rest, None)):
            after.append(following)
        while before and not near(before[0]):
            before.popleft()
        yield images, own, Window(own, tuple(_thinned([stop for stop in (*before, *after) if near(stop)], own)))
        before.append(after.popleft())


def _thinned(stops: list[tuple[StationImages, Placement]], own: Placement) -> list[tuple[StationImages, Placement]]:
    """At most `MOST_PICTURES` of `stops`, evenly spaced, the own one among them."""
    pace = -(-len(stops) // MOST_PICTURES)
    middle = next(number for number, stop in enumerate(stops) if stop[1] is own)
    return stops[middle % pace :: pace]


def _width(line: Line, placement: Placement, job: Job) -> float:
    """Standard deviation [m] of the passage of `line` over a place, as the rig moves along the pipe; the median."""
    take = place_on_wall(line.stripe, job.rig, laser=line.laser, prior_radius=job.nominal_radius)
    little = job.nominal_radius * 1e-4
    ahead = replace(placement, axial=placement.axial + little).pipe_from_rig.inverse() @ placement.pipe_from_rig
    u, v = job.rig.project(ahead.apply(take.points.points))
    speed = np.hypot(u - line.stripe.u, v - line.stripe.v) / little
    return float(np.nanmedian(line.stripe.noise.width / speed))


def spacetime_reach(source: ImageSource, place: Placer, job: Job, *, where: str) -> float:
    """How far [m] along the pipe the light of a scan is followed over a place: from its first usable picture. Raises
    InputError where that is less than a few of its steps.
    """
    stops = ((images, placement) for images in source.stations() if (placement := place(images)))
    first = next(((lines, stop) for images, stop in stops if (lines := find_lines(images, job)).lines), None)
    if first is None:
        return 0.0
    lines, own = first
    following = next((stop for _, stop in stops), None)
    width = _width(lines.lines[0], own, job)
    step = abs(following.axial - own.axial) if following else np.inf
    if not step <= COARSEST * width:
        raise InputError(
            f"{where}: spacetime analysis needs steps smaller than the line is thick, at most "
            f"{1e3 * COARSEST * width:.3g} mm here, but they are {1e3 * step:.3g} mm; take more pictures, or leave out "
            "--spacetime."
        )
    return REACH * width


def swept(lines: StationLines, window: Window, job: Job) -> StationLines:
    """The `lines` of a station with every place that its `window` tells better measured there; others as they are."""
    return replace(lines, lines=tuple(_swept(line, window, job) for line in lines.lines))


def _swept(line: Line, window: Window, job: Job) -> Line:
    try:
        sweep = _Sweep.of(line, window, job)
    except ImageError:
        return line
    for _ in range(ROUNDS):
        sweep.look()
    return sweep.result()


@dataclass
class _Sweep:
    """The pictures of a window, m of them, and n places of the wall followed through them.

    `moments` (m,) [m] of axial position from the own station's on; `wall` (n, 3) [m] in the pipe frame, `at` (n,) the
    moment [m] at which the light is known to pass over each.
    """

    line: Line
    window: Window
    job: Job
    pictures: list[Pixels]
    stops: list[Placement]
    wall: Array
    at: Array
    passage: Passage | None = None
    places: tuple[Array, Array] = field(default_factory=lambda: (np.empty(0), np.empty(0)))
    speed: Array = field(default_factory=lambda: np.empty(0))

    @classmethod
    def of(cls, line: Line, window: Window, job: Job) -> "_Sweep":
        take = place_on_wall(line.stripe, job.rig, laser=line.laser, prior_radius=job.nominal_radius)
        pictures, stops = [], []
        for images, placement in window.stops:
            try:
                pictures.append(images.read(line.take))
                stops.append(placement)
            except (ImageError, KeyError):
                continue
        wall = window.own.pipe_from_rig.apply(take.points.points)
        return cls(line, window, job, pictures, stops, wall, np.zeros(len(wall)))

    @property
    def moments(self) -> Array:
        return np.array([stop.axial for stop in self.stops]) - self.window.own.axial

    def look(self) -> None:
        """Follow the places through all pictures, and move them to where the light passed over them."""
        line, job, moments = self.line, self.job, self.moments
        seen = np.stack([job.rig.project(stop.pipe_from_rig.inverse().apply(self.wall)) for stop in self.stops])
        path = _Path.of(moments, seen)
        self.speed = np.linalg.norm(path.slope(self.at), axis=0)
        channel = job.looks[line.laser].channel
        samples = [
            brightness_at(picture, *place, channel=channel) / self._returned(stop)
            for picture, place, stop in zip(self.pictures, seen, self.stops, strict=True)
        ]
        from_guess = moments[:, None] - self.at
        noise = line.stripe.noise
        self.passage = passages(samples, from_guess, width=noise.width / self.speed, noise=noise)
        told = np.isfinite(self.passage.moment)
        self.at = np.where(told, self.at + np.where(told, self.passage.moment, 0.0), self.at)
        column, row = path.at(self.at)
        self.places = column, row
        self.wall = np.where(told[:, None], self._met(told), self.wall)

    def _returned(self, stop: Placement) -> Array:
        """Light (n,) that matt places of the wall return to the camera at `stop`, over that at the own station: while
        it comes nearer a place grows brighter, which moves the maximum of what it returns.
        """
        shares = []
        for pose in (stop.pipe_from_rig, self.window.own.pipe_from_rig):
            way = pose.apply(self.job.rig.mount.translation) - self.wall
            inwards = -np.einsum("nk,nk->n", way[:, :2], self.wall[:, :2])
            shares.append(np.maximum(inwards, 0.0) / np.linalg.norm(way, axis=1) ** 3)
        return np.divide(*shares, out=np.ones_like(shares[0]), where=shares[1] > 0)

    def _met(self, told: NDArray[np.bool_]) -> Array:
        """The wall points (n, 3) whose places are where the light passed over them, pipe frame."""
        at_rest = [np.where(told, own, single) for own, single in zip(self.places, self._single, strict=True)]
        stripe = replace(self.line.stripe, u=at_rest[0], v=at_rest[1])
        take = place_on_wall(stripe, self.job.rig, laser=self.line.laser, prior_radius=self.job.nominal_radius)
        carried = np.stack([stop.pipe_from_rig.apply(take.points.points).T for stop in self.stops])
        return _Path.of(self.moments, carried).at(self.at).T

    @property
    def _single(self) -> tuple[Array, Array]:
        return self.line.stripe.u, self.line.stripe.v

    def result(self) -> Line:
        """The line with its places, and how far each wall point lies from where one picture alone would put it."""
        passage = self.passage
        u_position = np.full(self.at.shape, np.nan) if passage is None else passage.u * self.speed
        stripe = replaced(self.line.stripe, *self.places, u_position)
        take = place_on_wall(stripe, self.job.rig, laser=self.line.laser, prior_radius=self.job.nominal_radius)
        own = self.window.own.pipe_from_rig.inverse().apply(self.wall)
        return self.line._replace(stripe=stripe, displacement=np.nan_to_num(own - take.points.points))


@dataclass(frozen=True)
class _Path:
    """Polynomials of the moment, `coefficients` (degree + 1, k, n), through what n places have in m pictures."""

    coefficients: Array
    unit: float

    @classmethod
    def of(cls, moments: Array, values: Array) -> "_Path":
        """Through `values` (m, k, n) at `moments` (m,)."""
        unit = float(np.abs(moments).max()) or 1.0
        design = np.vander(moments / unit, min(DEGREE, moments.size - 1) + 1, increasing=True)
        return cls(np.einsum("dm,mkn->dkn", np.linalg.pinv(design), values), unit)

    def at(self, moment: Array) -> Array:
        """(k, n) at `moment` (n,)."""
        return sum(c * (moment / self.unit) ** power for power, c in enumerate(self.coefficients))  # pyright: ignore[reportReturnType]

    def slope(self, moment: Array) -> Array:
        """(k, n) per metre."""
        powers = enumerate(self.coefficients[1:], start=1)
        return sum(power * c * (moment / self.unit) ** (power - 1) for power, c in powers) / self.unit  # pyright: ignore[reportReturnType]
