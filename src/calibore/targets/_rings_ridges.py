"""Dark lines of a picture as single points with a direction, and what they say of a ring target: centre and spokes."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


WORKING_SIZE = 640
"""px: the longer side of the picture is reduced to this before lines are sought."""
RIDGE_SCALE = 1.5
"""Gaussian [working px] under which a line is a ridge."""
SURROUNDINGS = 14.0
"""Gaussian [working px] of the local brightness that lines are compared with."""
FAINTEST = 0.012
"""Curvature across a line, of relative brightness per working px^2, below which it is noise or paper."""
STRAIGHTEST = 0.5
"""A line bends much less along itself than across: the ratio of both curvatures is at most this."""
FEWEST_POINTS, MOST_POINTS, MOST_VOTERS = 50, 12000, 3000
CANDIDATES, APART = 5, 10
"""Centres that are tried, working px between them."""
BEYOND = 0.3
"""The centre is looked for beyond the picture's edges too, by this fraction of its size, to say that it is there."""
VOTE_SOFTNESS = 2.0
"""Gaussian [working px] over which votes for a centre agree."""
NEAR, REACH = 12.0, 160.0
"""Working px: votes weigh as 1 / (distance + `NEAR`) up to `REACH`; nearby lines tell better where the centre is."""


@dataclass(frozen=True, eq=False)
class Ridges:
    """Points (n, 2) [px] on dark lines, unit `normal`s (n, 2) across them; `scale`: pixels per working pixel."""

    point: Array
    normal: Array
    scale: int
    size: tuple[int, int]


def reduced(plane: Array) -> tuple[Array, int]:
    """The picture averaged over blocks of `scale` x `scale` pixels, and `scale`."""
    scale = max(1, int(np.ceil(max(plane.shape) / WORKING_SIZE)))
    height, width = (side // scale for side in plane.shape)
    blocks = plane[: height * scale, : width * scale].reshape(height, scale, width, scale)
    return blocks.mean(axis=(1, 3)), scale


def find_ridges(plane: Array) -> Ridges:
    """The strongest dark lines of a picture (h, w), thinned to single points."""
    from scipy.ndimage import gaussian_filter

    small, scale = reduced(plane)
    local = gaussian_filter(small, SURROUNDINGS)
    relative = small / (local + 0.05 * local.max() + 1e-9)
    slopes: list[Any] = [(2, 0), (0, 2), (1, 1), (1, 0), (0, 1)]
    dvv, duu, duv, dv, du = (gaussian_filter(relative, RIDGE_SCALE, order=order) for order in slopes)
    half, mean = np.hypot((duu - dvv) / 2, duv), (duu + dvv) / 2
    across, along = mean + half, mean - half
    turn = 0.5 * np.arctan2(2 * duv, duu - dvv)
    normal = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    offset = -(du * normal[..., 0] + dv * normal[..., 1]) / np.where(across > 0, across, np.inf)
    found = (across > FAINTEST) & (np.abs(along) < STRAIGHTEST * across) & (np.abs(offset) < 0.75)
    row, column = np.nonzero(found)
    if row.size > MOST_POINTS:
        kept = np.sort(np.argsort(-across[row, column], kind="stable")[:MOST_POINTS])
        row, column = row[kept], column[kept]
    point = np.stack([column, row], axis=1) + offset[row, column, None] * normal[row, column]
    return Ridges((point + 0.5) * scale - 0.5, normal[row, column], scale, (plane.shape[1], plane.shape[0]))


def likely_centres(ridges: Ridges) -> list[Array]:
    """Places (2,) [px] where normals of rings and directions of spokes meet, the likeliest first."""
    if len(ridges.point) < FEWEST_POINTS:
        return []
    agreed, margin = _votes(ridges)
    centres = []
    for _ in range(CANDIDATES):
        row, column = np.unravel_index(int(np.argmax(agreed)), agreed.shape)
        centres.append((np.array([column, row]) - margin + 0.5) * ridges.scale - 0.5)
        agreed[max(row - APART, 0) : row + APART + 1, max(column - APART, 0) : column + APART + 1] = 0
    return centres


def _votes(ridges: Ridges) -> tuple[Array, Array]:
    """How many lines agree on each working pixel of the picture and a margin (2,) round it."""
    from scipy.ndimage import gaussian_filter

    size = np.array(ridges.size) / ridges.scale
    margin = np.rint(BEYOND * size)
    cells = np.ceil(size + 2 * margin).astype(int)
    reach = np.arange(-REACH, REACH, 1.5, dtype=np.float32)
    weight = 1 / (np.abs(reach) + NEAR)
    voters = np.unique(np.linspace(0, len(ridges.point) - 1, MOST_VOTERS).astype(int))
    normal = ridges.normal[voters].astype(np.float32)
    start = ((ridges.point[voters] + 0.5) / ridges.scale - 0.5 + margin).astype(np.float32)
    votes = np.zeros(cells[0] * cells[1])
    for direction in (normal, np.stack([-normal[:, 1], normal[:, 0]], axis=1)):
        place = np.rint(start[:, None] + reach[:, None] * direction[:, None]).astype(np.int32)
        inside = np.all((place >= 0) & (place < cells), axis=2)
        cell = place[..., 1] * cells[0] + place[..., 0]
        votes += np.bincount(cell[inside], np.broadcast_to(weight, inside.shape)[inside], minlength=votes.size)
    return gaussian_filter(votes.reshape(cells[1], cells[0]), VOTE_SOFTNESS), margin
