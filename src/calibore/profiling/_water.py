"""Told by the ring's shape: light that a water surface mirrors, or that glints on it.

Nothing of the wall is seen under water. What is seen there is the lit wall above it upside down, where the camera's
rays are reflected, and here and there the surface itself. Both leave the wall at the two ends of one level chord: the
mirror image in a corner that points inwards, as no pipe has it, and glints along the chord, dark between them. So
where the line leaves the wall's own curve round the invert, the chord between the ends is tried: if what lies under it
is the mirror image of what lies above it, or few points on it, it is water.

This is the specification of `native/src/water`, which `line_on_wall` calls for rigs that the engine knows.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.rigs import Rig
from calibore.status import Status
from calibore.stripe import Stripe

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
OFF = 0.05
"""Of the radius; what lies nearer to the wall's curve may be wall."""
CLOSE, LEVEL = 0.03, 0.015
"""Of the radius; what lies nearer to the mirror image, or to the chord, may be that; to the chord, `LOOSE` times as far
while chords are tried at a distance.
"""
LOOSE = 2.0
CROWN, DRY = np.radians(75), np.radians(115)
"""Half of the arc from which the wall's curve is first drawn, and of the arc from which it is drawn again; water stands
no higher while the camera is dry."""
ROUNDS = 5
OVAL = 0.0035
"""Of the radius: half of the points of a pipe lie nearer to an oval than this."""
BINS = 360
"""Steps of the turn in which the arc that is no wall is looked for."""
STEEPEST = np.radians(25)
"""How far the middle of that arc may be from the lowest place: the roll of a carriage."""
NARROWEST = np.radians(24)
"""Least arc that water covers: a level of 1 % of the pipe's height."""
MOST_RAYS, MOST_MIRRORED = 300, 60
"""Rays that are enough to tell, and points of which the mirror image is drawn."""
FEWEST_OF_WALL = 40
"""Of these rays, without which nothing is told."""
FEWEST = 0.012
"""Of the rays, that must show the mirror image or glints."""
DENSE = 0.6
"""Of the rays that meet the chord; where more of them show a point on it, it is a floor."""
MOST_WALL = 0.25
"""What lies under the chord and is neither, a feature or a ghost, over what is."""
TURNS, RAISES = np.radians([-12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0]), np.linspace(-0.14, 0.4, 19)
FINE_TURNS, FINE_RAISES = np.radians([-2.0, -1.0, 0.0, 1.0, 2.0]), np.array([-0.02, -0.01, 0.0, 0.01, 0.02])
"""How far from the chord between the ends others are tried: turned, and raised by so much of the radius, for the line
leaves the wall the more gently the higher the water stands; and from the best of these, others."""


class Chord(NamedTuple):
    """Water below x . (sin turn, cos turn) = `depth` [m], in the rig's x and y; y points downwards."""

    turn: float
    depth: float

    @property
    def normal(self) -> Array:
        return np.array([np.sin(self.turn), np.cos(self.turn), 0.0])

    def below(self, points: Array) -> Array:
        """How far (n,) [m] `points` (n, 3) lie under it."""
        return points @ self.normal - self.depth


def wet_rays(points: Array, clock: Array, stripe: Stripe, rig: Rig) -> Bools:
    """Which rays (n,) of `stripe`, whose wall points are `points` (n, 3) [m] at `clock` (n,) [rad], show what lies
    under a water surface, or a glint on it.
    """
    found, wet = np.flatnonzero(stripe.found & np.isfinite(points[:, 0])), np.zeros(stripe.u.size, dtype=bool)
    stride = max(stripe.u.size // MOST_RAYS, 1)
    some = found[::stride]
    if some.size < FEWEST_OF_WALL or stripe.centre is None:
        return wet
    pixel = np.stack([stripe.u, stripe.v], axis=1)[some]
    size, most = float(np.median(_polar(pixel - stripe.centre)[1])), 0.0
    for glints, wall in _walls(points[some], clock[some]):
        off = wall.off(points[some], clock[some])
        seen = _Seen(points[some], pixel, off, wall.radius, rig, size, stripe.u.size / stride, glints)
        score, chord = seen.water()
        if chord is not None and score > most:
            depth, off = chord.below(points[found]), np.abs(wall.off(points[found], clock[found]))
            most, wet = score, np.zeros(stripe.u.size, dtype=bool)
            wet[found] = (depth > 0) | ((depth > -CLOSE * wall.radius) & (off > CLOSE * wall.radius))
    return wet


def without_water(stripe: Stripe, wet: Bools | Sequence[int]) -> Stripe:
    """`stripe` without its points on the `wet` rays (n,), or those of these numbers, which get the status WATER."""

    def told(name: str, of_water: float) -> NDArray[Any]:
        values = getattr(stripe, name).copy()
        values[wet] = of_water
        return values

    gone = {name: told(name, np.nan) for name in ("u", "v", "u_position", "height")}
    return replace(stripe, **gone, status=told("status", Status.WATER))


class _Wall(NamedTuple):
    """The wall's curve about the rig axis: a series in the clock, 1, cos, sin and so on; `radius` [m], its mean."""

    series: Array

    @property
    def radius(self) -> float:
        return float(self.series[0])

    def off(self, points: Array, clock: Array) -> Array:
        """How far (n,) [m] the `points` (n, 3) lie outside it."""
        return np.hypot(points[:, 0], points[:, 1]) - _terms(clock, self.series.size) @ self.series

    @classmethod
    def through(cls, points: Array, clock: Array, may: Bools, *, terms: int) -> "_Wall | None":
        """Through the points that `may` be wall, drawn first from the crown, then from what is near, in the end with so
        many `terms`; None where too little of the wall was found.
        """
        near, reach, wall = _from_crown(clock) < CROWN, np.hypot(points[:, 0], points[:, 1]), None
        design = _terms(clock, terms)
        for count in [3, 3, *[terms] * (ROUNDS - 2)]:
            if np.count_nonzero(near) < FEWEST_OF_WALL:
                return None
            some = design[near, :count]
            try:
                wall = cls(np.asarray(np.linalg.solve(some.T @ some, some.T @ reach[near]), dtype=np.float64))
            except np.linalg.LinAlgError:  # all of it in one place
                return None
            near = may & (np.abs(reach - design[:, :count] @ wall.series) < OFF * wall.radius)
        return wall


def _walls(points: Array, clock: Array) -> list[tuple[bool, _Wall]]:
    """The wall as an oval through most of the ring; and, where no oval describes it as well as one describes a pipe,
    as the circle of its upper half: a mirror image that nearly completes the ring bends an oval away from both.
    Whether glints can be told by each.
    """
    oval = _Wall.through(points, clock, np.ones(clock.size, dtype=bool), terms=5)
    if oval is None or np.median(np.abs(oval.off(points, clock))) < OVAL * oval.radius:
        return [] if oval is None else [(True, oval)]
    upper = _Wall.through(points, clock, _from_crown(clock) < DRY, terms=3)
    return [(True, oval)] if upper is None else [(True, oval), (False, upper)]


def _from_crown(clock: Array) -> Array:
    return np.abs(np.mod(clock + np.pi, 2 * np.pi) - np.pi)


def _terms(clock: Array, count: int) -> Array:
    orders = range(1, count // 2 + 1)
    return np.stack([np.ones(clock.size), *(f(k * clock) for k in orders for f in (np.cos, np.sin))], axis=1)


class _Seen(NamedTuple):
    """The points found (n, 3) [m] with their `pixel` (n, 2), and how far `off` (n,) [m] they lie outside the wall of
    `radius` [m], `size` [px] in the picture; on how many `rays` they were looked for; whether `glints` count.
    """

    points: Array
    pixel: Array
    off: Array
    radius: float
    rig: Rig
    size: float
    rays: float
    glints: bool

    def water(self) -> tuple[float, Chord | None]:
        """The chord that explains what lies round the invert better than the wall does, and how much better."""
        chord = self._between_ends()
        if chord is None:
            return 0.0, None
        _, chord = self._best(chord, TURNS, RAISES, slack=LOOSE)
        return self._best(chord, FINE_TURNS, FINE_RAISES, slack=1.0)

    def _is_off(self) -> Bools:
        return np.abs(self.off) > OFF * self.radius

    def _fewest(self) -> float:
        return FEWEST * len(self.points)

    def _between_ends(self) -> Chord | None:
        """Where the line leaves the wall on both sides of the lowest place; None where it does not."""
        from_down = np.arctan2(self.points[:, 0], self.points[:, 1])
        step = ((from_down + np.pi) * (BINS / (2 * np.pi))).astype(np.intp) % BINS
        off = self._is_off()
        wall = np.bincount(step[~off], minlength=BINS) > np.bincount(step[off], minlength=BINS)
        if np.count_nonzero(off) < self._fewest() or not wall.any():
            return None
        lit = np.flatnonzero(wall)
        gaps = np.diff(np.append(lit, lit[0] + BINS))
        for at in np.argsort(-gaps, kind="stable")[:2]:
            begin, width = (lit[at] + 1) * 2 * np.pi / BINS - np.pi, (gaps[at] - 1) * 2 * np.pi / BINS
            middle = np.mod(begin + width / 2 + np.pi, 2 * np.pi) - np.pi
            if width >= NARROWEST and abs(middle) < STEEPEST:
                return Chord(float(middle), self.radius * float(np.cos(width / 2)))
        return None

    def _best(self, chord: Chord, turns: Array, raises: Array, *, slack: float) -> tuple[float, Chord]:
        """The best of the chords turned and raised from this one, with its score; `slack`: see `LOOSE`."""
        tried = [Chord(chord.turn + turn, chord.depth - up * self.radius) for turn in turns for up in raises]
        depths = np.stack([one.normal for one in tried]) @ self.points.T - np.array([[one.depth] for one in tried])
        images = self._images(tried)
        scores = [self._score(*one, slack * self.radius) for one in zip(tried, depths, images, strict=True)]
        best = int(np.argmax(scores))
        return scores[best], tried[best]

    def _images(self, tried: list[Chord]) -> Array:
        """Pixels (chords, k, 2) of what each chord would mirror, NaN where it mirrors nothing."""
        some = self.points[:: max(len(self.points) // MOST_MIRRORED, 1)]
        normal = np.stack([chord.normal for chord in tried])
        depth = normal @ some.T - np.array([[chord.depth] for chord in tried])
        mirrored = some - 2 * depth[..., None] * normal[:, None, :]
        pixel = np.stack(self.rig.project(mirrored.reshape(-1, 3)), axis=1).reshape(*depth.shape, 2)
        return np.where((depth < 0)[..., None], pixel, np.nan)

    def _score(self, chord: Chord, depth: Array, image: Array, unit: float) -> float:
        """Points that water explains and the wall does not, less three times as many under the chord that it does not
        explain; 0 where it is none. `depth` (n,) [m] under the chord, pixels (k, 2) of what it would mirror; what is
        near to the chord is a share of the `unit` [m].
        """
        under, on_it, off = depth > LEVEL * unit, np.abs(depth) <= LEVEL * unit, self._is_off()
        glints, told = int(np.count_nonzero(on_it & off)), 0
        if not self.glints or np.count_nonzero(on_it) > DENSE * self._rays_to(chord):
            glints = 0
        if np.count_nonzero(under & off) + glints < self._fewest():
            return 0.0
        mirrored = self._in(image, self.pixel[under])
        told = glints + int(np.count_nonzero(mirrored & off[under]))
        other = int(np.count_nonzero(~mirrored))
        return float(told - 3 * other) if told >= self._fewest() and other <= MOST_WALL * told else 0.0

    def _rays_to(self, chord: Chord) -> float:
        """How many of the rays that were looked at meet the water."""
        return self.rays * float(np.arccos(np.clip(chord.depth / self.radius, -1.0, 1.0))) / np.pi

    def _in(self, image: Array, pixel: Array) -> Bools:
        """Which of the `pixel`s (m, 2) lie where the picture would show the mirror image (k, 2), by their distance from
        its middle: it goes round that once.
        """
        image = image[np.isfinite(image[:, 0])]
        if len(image) == 0 or len(pixel) == 0:
            return np.zeros(len(pixel), dtype=bool)
        middle = image.sum(axis=0) / len(image)
        azimuth, distance = _polar(image - middle)
        order = np.argsort(azimuth)
        at, own = _polar(pixel - middle)
        return np.abs(own - np.interp(at, azimuth[order], distance[order], period=2 * np.pi)) < CLOSE * self.size


def _polar(place: Array) -> tuple[Array, Array]:
    return np.arctan2(place[:, 1], place[:, 0]), np.hypot(place[:, 0], place[:, 1])
