"""Dips of brightness along rays from the centre of a ring target: dark lines crossed."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Whole

Array = NDArray[Any]

RAYS = 1440
STEP = 0.5
"""px along a ray."""
SMOOTHING, BESIDE = 0.6, 1.0
"""Gaussian [px] over the picture before rays are read, and [rays] over the rays."""
SHALLOWEST, NOISIEST = 0.035, 7.0
"""A dip is at least this fraction of the paper's brightness deep, and this many standard deviations of the noise."""
DARKEST_PAPER = 0.3
"""Paper is at least this bright, relative to the paper near the centre."""
END_OF_PAPER = 0.6
"""Beyond the last place so bright, relative to the paper beside the outermost dip, a ray has left the paper."""
NEAREST = 4.0
"""px from the centre to the first ring, at least."""


@dataclass(frozen=True, eq=False)
class Dips:
    """Dark lines crossed by rays: number of the `ray` (n,), distance `radius` [px], `width` [px] at half depth, `depth`
    as a fraction of the paper's brightness, and the ring's number `ring` (n,) from 1, 0 where not known. Of the rays:
    `azimuths` (rays,) [rad]; `paper`, `frame` (rays,) [px]: where they leave the paper and the picture.
    """

    ray: Whole
    radius: Array
    width: Array
    depth: Array
    ring: Whole
    azimuths: Array
    paper: Array
    frame: Array

    def kept(self, which: NDArray[np.bool_]) -> "Dips":
        """Some of the dips."""
        parts = {name: getattr(self, name)[which] for name in ("ray", "radius", "width", "depth", "ring")}
        return replace(self, **parts)


def find_dips(plane: Array, centre: Array) -> Dips:
    """All dips of a picture (h, w) round the `centre`, not numbered."""
    azimuths = np.arange(RAYS) * (2 * np.pi / RAYS)
    profiles, ends = _profiles(plane, centre, azimuths)
    ray, radius, width, depth, paper = _dips(profiles, ends)
    return Dips(ray, radius, width, depth, np.zeros(ray.size, dtype=np.intp), azimuths, paper, ends * STEP)


def _profiles(plane: Array, centre: Array, azimuths: Array) -> tuple[Array, Whole]:
    """Brightness (rays, steps) along the rays, and how many steps of each lie in the picture."""
    from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates

    height, width = plane.shape
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]]) - centre
    radius = np.arange(0, np.hypot(*corners.T).max(), STEP)
    u = centre[0] + radius * np.cos(azimuths)[:, None]
    v = centre[1] + radius * np.sin(azimuths)[:, None]
    smooth = gaussian_filter(plane.astype(np.float32), SMOOTHING)
    profiles = map_coordinates(smooth, [v, u], order=1, mode="nearest")
    inside = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    return gaussian_filter1d(profiles, BESIDE, axis=0, mode="wrap"), inside.sum(axis=1)


def _dips(profiles: Array, ends: Whole) -> tuple[Whole, Array, Array, Array, Array]:
    """Ray (n,), distance [px] of the middle between the flanks, width at half depth [px] and relative depth of all dark
    lines; where each ray leaves the paper.
    """
    from scipy.signal import find_peaks

    paper = np.quantile(profiles[:, : int(ends.max()) // 4], 0.8)
    noise = np.median(np.abs(np.diff(profiles, n=2, axis=0))) / 0.6745 / np.sqrt(6)
    least = max(NOISIEST * noise, 0.3 * SHALLOWEST * paper)
    found, leaves = [], ends * STEP
    for ray, (profile, end) in enumerate(zip(profiles, ends, strict=True)):
        line = profile[:end]
        index, about = find_peaks(-line, prominence=least, width=0, rel_height=0.5)
        depth, left, right = about["prominences"], about["left_ips"] * STEP, about["right_ips"] * STEP
        shoulder = line[index] + depth
        kept = (depth > SHALLOWEST * shoulder) & (shoulder > DARKEST_PAPER * paper) & (left + right > 2 * NEAREST)
        found.append((np.full(index.size, ray), (left + right) / 2, right - left, depth / shoulder, kept))
        if kept.any():
            bright = np.flatnonzero(line > END_OF_PAPER * shoulder[kept][-1])[-1]
            leaves[ray] = bright * STEP
    ray, radius, width, depth, kept = (np.concatenate(part) for part in zip(*found, strict=True))
    return ray[kept], radius[kept], width[kept], depth[kept], leaves
