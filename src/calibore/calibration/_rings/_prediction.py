"""Where along the direction of each mark its line should appear: the pixel whose ray meets the target on that line."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rings._target import RingTarget
from calibore.rigs import Rig, triangulate

Array = NDArray[np.float64]

FIRST_STEP = 0.25
"""px: from it the first slope."""
STEPS = 12
FOUND = 1e-5
"""px: a step as small as that ends the search; secants leave less than a thousandth of it."""


class Aims(NamedTuple):
    """Marks at `u`, `v` (m,) [px] with the unit vectors `direction` (m, 2), all on rings of `radius` (m,) [m], or all
    on spokes at `angle` (m,) [rad] from the first; `ink_width` [m] of rings.
    """

    u: Array
    v: Array
    direction: Array
    radius: Array | None
    angle: Array
    ink_width: float

    def at(self, shift: Array) -> tuple[Array, Array]:
        """The pixels `shift` (m,) [px] along the directions."""
        return self.u + shift * self.direction[:, 0], self.v + shift * self.direction[:, 1]


class Prediction(NamedTuple):
    """`shift` (m,) [px] from each mark to its line; `slope` (m,) [m/px] of what it is beyond or beside it; derivatives
    of that [m] by the place of the target (m, 6) and by the camera (m, c). NaN where the lens does not image the line.
    """

    shift: Array
    slope: Array
    by_target: Array
    by_camera: Array


def predict(rig: Rig, target: RingTarget, aims: Aims) -> Prediction:
    """Prediction for marks of one picture; `rig`: the camera and the plane of the target."""
    shift = _search(rig, target, aims)
    found = triangulate(rig, *aims.at(shift))
    place = target.across(found.points, aims.angle) if aims.radius is None else target.radius(found.points)
    by_point = place.by_point[:, None, :]
    slope = np.einsum("nij,nj->ni", by_point @ found.d_pixel, aims.direction)[:, 0]
    by_rig = (by_point @ found.d_parameters)[:, 0]
    return Prediction(shift, slope, place.by_parameters + np.pad(by_rig[:, :3], [(0, 0), (0, 3)]), by_rig[:, 3:])


def _search(rig: Rig, target: RingTarget, aims: Aims) -> Array:
    """The zero of `_gap` along each direction, by secants."""
    half, before, shift = np.zeros(aims.u.size), np.zeros(aims.u.size), np.full(aims.u.size, FIRST_STEP)
    with np.errstate(all="ignore"):  # a mark that leaves the lens's range becomes NaN
        last, gap = _gap(rig, target, aims, before, half), _gap(rig, target, aims, shift, half)
        slope = (gap - last) / FIRST_STEP
        if aims.radius is not None and aims.ink_width:
            half = aims.ink_width / 2 / slope
            last, gap = _gap(rig, target, aims, before, half), _gap(rig, target, aims, shift, half)
        for _ in range(STEPS):
            moved = np.abs(shift - before) > FOUND
            slope = np.where(moved, (gap - last) / np.where(moved, shift - before, 1.0), slope)
            step = -gap / slope
            before, last, shift = shift, gap, shift + step
            if not np.nanmax(np.abs(step), initial=0.0) > FOUND:
                break
            gap = _gap(rig, target, aims, shift, half)
    return shift


def _gap(rig: Rig, target: RingTarget, aims: Aims, shift: Array, half: Array | float) -> Array:
    """How far [m] the pixels at `shift` are beyond their rings or beside their spokes.

    A mark is the middle between the edges of the ink as they appear, `half` (m,) [px] away, not the image of the ink's
    middle: the radii of its edges, not its own, have the printed radius as their mean.
    """
    if aims.radius is None:
        return target.off_spoke(_seen(rig, target, *aims.at(shift)), aims.angle)
    if not np.any(half):
        return target.off_centre(_seen(rig, target, *aims.at(shift))) - aims.radius
    edges = [target.off_centre(_seen(rig, target, *aims.at(shift + way * half))) for way in (-1, 1)]
    return (edges[0] + edges[1]) / 2 - aims.radius


def _seen(rig: Rig, target: RingTarget, u: Array, v: Array) -> Array:
    """Points (m, 3) of the target's plane, without sensitivities: ten times faster than `triangulate`."""
    rays = rig.camera.unproject(u, v)
    plane = target.plane
    distance = -plane.value(np.atleast_2d(rays.origin)) / (rays.direction @ plane.normal)
    return rays.origin + distance[:, None] * rays.direction
