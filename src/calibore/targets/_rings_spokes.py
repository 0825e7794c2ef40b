"""The spokes of a ring target among the dark lines of a picture: how many, where they run, where they meet."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._rings_ridges import Ridges

Array = NDArray[Any]

NEAREST, FARTHEST = 6.0, 80.0
"""Working px from the centre between which spokes are counted."""
CELL = 2.0
"""Working px: a spoke is a run of such cells that are mostly filled."""
BEAM = 3.0
"""Working px to both sides of a direction from the centre within which points count for it."""
FILLED = 0.4
"""Fraction of the cells of a spoke that hold points of it; rings interrupt it."""
SHORTEST = 12.0
"""Working px of a direction that must lie in the picture for it to be judged."""
DIRECTIONS = 720
APART = np.deg2rad(6.0)
"""Spokes are at least this far apart."""
STRAYING = 0.06
"""A spoke strays from its inner, straight stretch by up to this fraction of the distance (distortion) outwards."""
ROUNDS = 3
ROUNDS_ROBUST = 6
DEGREE = 4
"""Of the polynomial that describes a spoke's offset along its length."""


@dataclass(frozen=True, eq=False)
class Spoke:
    """`azimuth` [rad] in which a spoke leaves the `centre` (2,) [px]; its offset from that direction, towards growing
    azimuth, is a polynomial of the distance with `coefficients`, known up to `length` [px].
    """

    centre: Array
    azimuth: float
    coefficients: Array
    length: float

    @property
    def along(self) -> Array:
        return np.array([np.cos(self.azimuth), np.sin(self.azimuth)])

    @property
    def across(self) -> Array:
        return np.array([-np.sin(self.azimuth), np.cos(self.azimuth)])

    def coordinates(self, places: Array) -> tuple[Array, Array]:
        """Distance along the spoke's direction and offset from it, both (n,) [px], of `places` (n, 2)."""
        relative = places - self.centre
        return relative @ self.along, relative @ self.across

    def offset(self, distance: Array) -> Array:
        return np.polynomial.polynomial.polyval(distance, self.coefficients)

    def points(self, distance: Array) -> Array:
        """Places (n, 2) [px] of the spoke's midline."""
        return self.centre + distance[:, None] * self.along + self.offset(distance)[:, None] * self.across


def find_spokes(ridges: Ridges, centre: Array) -> tuple[Spoke, ...]:
    """Spokes in order of azimuth, all with the `centre` in which they meet."""
    lines: list[tuple[Array, Array]] = []
    for _ in range(ROUNDS):
        azimuths = _directions(ridges, centre)
        if azimuths.size < 2:
            return ()
        lines = _different([_inner_line(ridges, centre, azimuth) for azimuth in azimuths])
        if len(lines) < 2:
            return ()
        centre = meeting_point(*zip(*lines, strict=True))
    return tuple(_traced(ridges, centre, azimuth) for azimuth in sorted(_azimuth(along) for _, along in lines))


def _different(lines: list[tuple[Array, Array]]) -> list[tuple[Array, Array]]:
    """Without those that run where another does: a short spoke may be met twice."""
    kept: list[tuple[Array, Array]] = []
    for point, along in lines:
        if all(along @ other < np.cos(APART) for _, other in kept):
            kept.append((point, along))
    return kept


def _azimuth(along: Array) -> float:
    return float(np.arctan2(along[1], along[0]) % (2 * np.pi))


def meeting_of(spokes: tuple[Spoke, ...]) -> Array:
    """Where (2,) [px] spokes meet: there they are nearly straight."""
    slopes = [spoke.along + spoke.coefficients[1] * spoke.across for spoke in spokes]
    return meeting_point(
        tuple(spoke.points(np.zeros(1))[0] for spoke in spokes), tuple(slope / np.hypot(*slope) for slope in slopes)
    )


def meeting_point(points: tuple[Array, ...], alongs: tuple[Array, ...]) -> Array:
    """The place (2,) nearest to all lines through `points` in the unit directions `alongs`."""
    across = np.array([[-along[1], along[0]] for along in alongs])
    return np.linalg.lstsq(across, np.sum(across * np.array(points), axis=1), rcond=None)[0]


def _relative(ridges: Ridges, centre: Array) -> tuple[Array, Array, Array]:
    """Distance (n,) [px] and azimuth (n,) from the centre, and how far (n,) [px] each point's line passes it."""
    offset = ridges.point - centre
    return np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0]), np.abs(np.sum(offset * ridges.normal, axis=1))


def _directions(ridges: Ridges, centre: Array) -> Array:
    """Azimuths in which cells filled with points of radial lines follow one another."""
    distance, azimuth, passing = _relative(ridges, centre)
    scale = ridges.scale
    radial = (passing < BEAM * scale + 0.12 * distance) & (distance > NEAREST * scale) & (distance < FARTHEST * scale)
    turns = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    cells = int(np.ceil((FARTHEST - NEAREST) / CELL))
    filled = np.zeros((DIRECTIONS, cells), dtype=bool)
    cell = np.clip(((distance[radial] / scale - NEAREST) / CELL).astype(int), 0, cells - 1)
    home = np.rint(azimuth[radial] * (DIRECTIONS / (2 * np.pi))).astype(int)
    spread = np.maximum(np.arcsin(np.minimum(BEAM * scale / distance[radial], 0.2)), 0) * (DIRECTIONS / (2 * np.pi))
    for shift in range(-int(spread.max(initial=0)), int(spread.max(initial=0)) + 1):
        near = np.abs(shift) <= spread
        filled[(home[near] + shift) % DIRECTIONS, cell[near]] = True
    seen = _cells_in_picture(ridges, centre, turns, cells)
    share = (filled & seen).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    share[seen.sum(axis=1) * CELL < SHORTEST] = 0
    return turns[_peaks(share)]


def _cells_in_picture(ridges: Ridges, centre: Array, turns: Array, cells: int) -> NDArray[np.bool_]:
    distance = (NEAREST + CELL * (np.arange(cells) + 0.5)) * ridges.scale
    u = centre[0] + distance * np.cos(turns)[:, None]
    v = centre[1] + distance * np.sin(turns)[:, None]
    edge = 4 * ridges.scale
    return (u > edge) & (u < ridges.size[0] - edge) & (v > edge) & (v < ridges.size[1] - edge)


def _peaks(share: Array) -> NDArray[np.intp]:
    """The middles of the runs of directions that are the fullest within `APART`."""
    reach = int(APART / (2 * np.pi) * DIRECTIONS)
    around = np.max([np.roll(share, shift) for shift in range(-reach, reach + 1)], axis=0)
    best = (share >= FILLED) & (share >= around)
    if best.all() or not best.any():
        return np.zeros(0, dtype=np.intp)
    turned = int(np.flatnonzero(~best)[0])
    places = np.flatnonzero(np.roll(best, -turned))
    runs = np.split(places, np.flatnonzero(np.diff(places) > reach) + 1)
    return np.array([(int(run[0] + run[-1]) // 2 + turned) % DIRECTIONS for run in runs])


def _inner_line(ridges: Ridges, centre: Array, azimuth: float) -> tuple[Array, Array]:
    """Where the spoke at `azimuth` passes the centre, and its unit direction there."""
    distance, turn, passing = _relative(ridges, centre)
    beside = np.abs((turn - azimuth + np.pi) % (2 * np.pi) - np.pi) * distance
    scale = ridges.scale
    member = (beside < 1.5 * BEAM * scale + 0.03 * distance) & (passing < BEAM * scale + 0.12 * distance)
    member &= (distance > NEAREST * scale) & (distance < FARTHEST * scale)
    point = ridges.point[member]
    along, across = _axes(azimuth)
    s, t = (point - centre) @ along, (point - centre) @ across
    offset, slope, _ = _robust_polynomial(s, t, 2, scale)
    direction = along + slope * across
    return centre + offset * across, direction / np.hypot(*direction)


def _traced(ridges: Ridges, centre: Array, azimuth: float) -> Spoke:
    """The spoke as far as it can be followed, from its inner stretch outwards."""
    distance, _, passing = _relative(ridges, centre)
    along, across = _axes(azimuth)
    s, t = (ridges.point - centre) @ along, (ridges.point - centre) @ across
    scale = ridges.scale
    radial = (s > NEAREST * scale) & (passing < BEAM * scale + 0.35 * distance)
    end, coefficients = FARTHEST * scale, np.zeros(DEGREE + 1)
    while True:
        reach = 1.5 * BEAM * scale + STRAYING * np.maximum(s - 0.8 * end, 0)
        member = radial & (s < end) & (np.abs(t - np.polynomial.polynomial.polyval(s, coefficients)) < reach)
        if member.sum() < 3 * DEGREE:
            break
        degree = DEGREE if end > 2 * FARTHEST * scale else 2
        coefficients = np.zeros(DEGREE + 1)
        coefficients[: degree + 1] = _robust_polynomial(s[member], t[member], degree, scale)
        length = float(np.quantile(s[member], 0.995))
        if length < 0.9 * end:
            break
        end *= 1.3
    length = float(np.quantile(s[member], 0.995)) if member.any() else 0.0
    return Spoke(centre, azimuth, coefficients, length)


def _axes(azimuth: float) -> tuple[Array, Array]:
    cosine, sine = np.cos(azimuth), np.sin(azimuth)
    return np.array([cosine, sine]), np.array([-sine, cosine])


def _robust_polynomial(s: Array, t: Array, degree: int, scale: float) -> Array:
    """Coefficients, constant first, of t(s); outliers count less (Cauchy weights)."""
    reach = max(float(s.max(initial=1.0)), 1.0)
    design = np.vander(s / reach, degree + 1, increasing=True)
    weight, solution = np.ones(s.shape), np.zeros(degree + 1)
    for _ in range(ROUNDS_ROBUST):
        solution = np.linalg.lstsq(design * weight[:, None], t * weight, rcond=None)[0]
        weight = 1 / np.sqrt(1 + ((t - design @ solution) / (0.5 * scale)) ** 2)
    return solution / reach ** np.arange(degree + 1)
