"""Two upright pins before a plain background: where their axes lie, row by row."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.targets._marks import Array, PinMarks

Half = Literal["upper", "lower"]
Mask = NDArray[np.bool_]

EDGE_SMOOTHING = 1.5
"""Gaussian [px] whose derivative finds edges: about the blur of an ordinary lens."""
EDGE_REACH = 4
"""Pixels around the coarse edge in which the steepest place is looked for."""
SMOOTHING_REACH = 6
"""Pixels that the smoothing reaches to."""
LEAST_CONTRAST = 0.08
"""A pin differs from the background by at least this fraction of it, and by 6 standard deviations of the noise."""
NARROWEST = 5
"""Narrower runs of pixels [px] are dust; also the least background on both sides of a pin."""
LEAST_ROWS = 40
"""Rows in which a pin must be seen alone."""
TRIMMED = 6
"""Rows left out at each end of a pin, where its tip is blurred."""
JUMP = 1.6
"""Both edges move less than this [px] from row to row: half a right angle would be 1, nothing upright comes near it."""
LEVEL_JUMP = 0.15
"""Nor does a pin's brightness change so much (fraction of the background): another pin has covered it."""
OUTLYING = 4.5
"""Rows so many standard deviations off the pin's smooth axis are left out (dust, a scratch)."""
LEAST_SIGMA = 1e-3
"""px; a picture without noise is no better than this."""


@dataclass(frozen=True)
class _Run:
    """Pixels `first` to `last` of one row that differ from the background, on average by `level`."""

    row: int
    first: int
    last: int
    level: float
    alone: bool


def find_pins(image: NDArray[Any], *, near_half: Half, far_half: Half) -> PinMarks:
    """The axes of the pin that fills most of the `near_half` and of the one in the `far_half` of `image` (h, w[, 3]).

    Rows in which one pin covers the other are left out. Raises ImageError where a pin is not found.
    """
    if {near_half, far_half} != {"upper", "lower"}:
        raise InputError(
            f'The near pin is in the "{near_half}" half and the far pin in the "{far_half}" half; one must be "upper" '
            'and the other "lower".'
        )
    plane = image.astype(float) if image.ndim == 2 else image[..., :3].mean(axis=2)
    relative = plane / _background(plane) - 1
    tracks = _tracks(relative, _threshold(relative))
    halves = {"upper": range(plane.shape[0] // 2), "lower": range(plane.shape[0] // 2, plane.shape[0])}
    far, near = (_pin(plane, tracks, halves[half], half) for half in (far_half, near_half))
    return PinMarks(
        *(np.concatenate([a, b]) for a, b in zip(far[:3], near[:3], strict=True)),
        near=np.repeat([False, True], [far[0].size, near[0].size]),
        half_width=np.concatenate([far[3], near[3]]),
    )


def _background(plane: Array) -> Array:
    """The smooth brightness (h, w) behind everything: a robust quadratic surface."""
    v, u = (np.linspace(-1, 1, n) for n in plane.shape)
    y, x = np.meshgrid(v[::12], u[::12], indexing="ij")
    design = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1).reshape(-1, 6)
    seen = plane[::12, ::12].ravel()
    kept, surface = np.ones(seen.size, dtype=bool), np.zeros(design.shape[1])
    for _ in range(8):
        surface, *_ = np.linalg.lstsq(design[kept], seen[kept], rcond=None)
        off = np.abs(seen - design @ surface)
        kept = off <= max(3 * 1.4826 * float(np.median(off)), 1e-9)
    level, by_u, by_v, by_uu, by_uv, by_vv = surface
    along, down = (by_u + by_uu * u) * u, level + (by_v + by_vv * v) * v
    return np.maximum(down[:, None] + along + by_uv * v[:, None] * u, 1.0)


def _threshold(relative: Array) -> float:
    noise = 1.4826 * float(np.median(np.abs(np.diff(relative[::4], axis=1)))) / np.sqrt(2)
    return max(LEAST_CONTRAST, 6 * noise)


def _tracks(relative: Array, threshold: float) -> list[list[_Run]]:
    """Runs of neighbouring rows that continue each other."""
    finished: list[list[_Run]] = []
    open_tracks: list[list[_Run]] = []
    for row, line in enumerate(relative):
        runs, continued = _runs(row, line, threshold), []
        for track in open_tracks:
            following = next((run for run in runs if _continues(track[-1], run)), None)
            if following is None:
                finished.append(track)
            else:
                runs.remove(following)
                continued.append([*track, following] if len(track) == 1 else _extended(track, following))
        open_tracks = [*continued, *([run] for run in runs)]
    return finished + open_tracks


def _extended(track: list[_Run], run: _Run) -> list[_Run]:
    track.append(run)
    return track


def _runs(row: int, line: Array, threshold: float) -> list[_Run]:
    differs = np.concatenate([[False], np.abs(line) > threshold, [False]])
    edges = np.flatnonzero(differs[1:] != differs[:-1])
    found = [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2) if b - a >= NARROWEST]
    limits = [-NARROWEST, *(end for run in found for end in run), line.size + NARROWEST]
    runs = []
    for index, (first, last) in enumerate(found):
        room = min(first - limits[2 * index], limits[2 * index + 3] - last)
        inside = first > EDGE_REACH and last < line.size - 1 - EDGE_REACH
        middle = line[first + 2 : last - 1] if last - first > NARROWEST else line[first : last + 1]
        runs.append(_Run(row, first, last, float(middle.mean()), inside and room > 2 * NARROWEST))
    return runs


def _continues(before: _Run, after: _Run) -> bool:
    moved = max(abs(before.first - after.first), abs(before.last - after.last))
    return moved < JUMP and abs(before.level - after.level) < LEVEL_JUMP


def _pin(plane: Array, tracks: list[list[_Run]], half: range, name: str) -> tuple[Array, Array, Array, Array]:
    """u, v, sigma and half width of the axis of the longest track in `half`."""
    usable = [[run for run in track[TRIMMED:-TRIMMED] if run.alone and run.row in half] for track in tracks]
    track = max(usable, key=len, default=[])
    if len(track) < LEAST_ROWS:
        raise ImageError(
            f"no pin stands alone in at least {LEAST_ROWS} rows of the {name} half; set an upright pin there before a "
            "plain, evenly lit background, wholly inside the picture, and see that the other pin does not cover it"
        )
    rows = np.array([run.row for run in track])
    ends = (np.array([run.first for run in track]), np.array([run.last for run in track]))
    left, right = (_steepest(plane[rows], end) for end in ends)
    return _without_outliers((left + right) / 2, rows.astype(float), (right - left) / 2)


def _steepest(lines: Array, coarse: NDArray[np.intp]) -> Array:
    """Place (n,) [px] of the steepest slope of each of `lines` (n, w) near `coarse` (n,); NaN where there is none."""
    from scipy.ndimage import gaussian_filter1d

    around = np.arange(-EDGE_REACH - SMOOTHING_REACH, EDGE_REACH + SMOOTHING_REACH + 1)
    window = np.take_along_axis(lines, np.clip(coarse[:, None] + around, 0, lines.shape[1] - 1), axis=1)
    slope = np.abs(gaussian_filter1d(window, EDGE_SMOOTHING, axis=1, order=1, mode="nearest"))
    near = np.log(np.maximum(slope[:, SMOOTHING_REACH:-SMOOTHING_REACH], 1e-9))
    columns = coarse[:, None] + np.arange(-EDGE_REACH, EDGE_REACH + 1)
    top = np.argmax(near, axis=1)
    inner = (top > 0) & (top < columns.shape[1] - 1)
    before, at, after = (near[np.arange(top.size), np.clip(top + d, 0, columns.shape[1] - 1)] for d in (-1, 0, 1))
    bend = np.where(inner, before - 2 * at + after, np.nan)
    offset = 0.5 * (before - after) / np.where(bend < 0, bend, np.nan)
    return columns[np.arange(top.size), top] + offset


def _without_outliers(u: Array, v: Array, half_width: Array) -> tuple[Array, Array, Array, Array]:
    """Marks on a smooth axis of smoothly changing width, and the scatter about it."""
    known, spread = np.isfinite(u) & np.isfinite(half_width), [LEAST_SIGMA]
    for _ in range(3):
        u, v, half_width = u[known], v[known], half_width[known]
        if u.size < LEAST_ROWS // 2:
            raise ImageError(
                "a pin's edges are too ragged to be followed; focus on both pins and light them evenly, with no cable "
                "or hand behind them"
            )
        off = [np.abs(a - np.polyval(np.polyfit(v - v.mean(), a, 3), v - v.mean())) for a in (u, half_width)]
        spread = [1.4826 * float(np.median(a)) + LEAST_SIGMA for a in off]
        known = (off[0] <= OUTLYING * spread[0]) & (off[1] <= OUTLYING * spread[1])
    return u, v, np.full(u.size, max(spread[0], LEAST_SIGMA)), half_width
