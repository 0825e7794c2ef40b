"""Where the line of a laser on a known surface would appear, to know where to look for it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._references import FlatTarget, Reference, RingGauge
from calibore.errors import InputError
from calibore.geometry import xy_of
from calibore.lasers import Cone
from calibore.rigs import Rig, project_ring

Array = NDArray[np.float64]
POINTS = 96
INNER, OUTER = 0.65, 1.4
"""A line is looked for between these multiples of its nearest and farthest distance from its middle."""
SPARE = 6.0
"""px further in and out."""
FARTHEST = 20.0
"""Multiples of the stand-off within which light falls on a flat."""
HALVINGS = 60


class Annulus(NamedTuple):
    """`centre` (column, row), from `inner` to `outer` [px]."""

    centre: tuple[float, float]
    inner: float
    outer: float


def annulus(rig: Rig, reference: Reference, *, laser: int) -> Annulus:
    """Holds the line that `laser` draws on `reference` set up straight; InputError where the camera sees none."""
    if isinstance(reference, RingGauge):
        _, u, v = project_ring(rig, reference.diameter / 2, POINTS, laser=laser)
    elif isinstance(reference, FlatTarget):
        u, v = rig.project(_on_flat(rig, reference.distance, laser))
    else:
        raise InputError(f"There is no outline of the line on a {type(reference).__name__}.")
    seen = np.isfinite(u)
    if not seen.any():
        raise InputError(
            "the laser's light as the rig file describes it does not fall on it; check its size and the rig"
        )
    centre = float(u[seen].mean()), float(v[seen].mean())
    distance = np.hypot(u[seen] - centre[0], v[seen] - centre[1])
    corners = np.array([[0, 0], [0, rig.camera.height], [rig.camera.width, 0], [rig.camera.width, rig.camera.height]])
    farthest = float(np.hypot(*(corners - centre).T).max())
    inner, outer = max(INNER * float(distance.min()) - SPARE, 0.0), OUTER * float(distance.max()) + SPARE
    return Annulus(centre, inner, min(outer, farthest))


def _on_flat(rig: Rig, stand_off: float, laser: int) -> Array:
    """Points (n, 3) where the light of a cone falls on a flat across the rig axis: from the cone's axis outwards, where
    the value of its surface changes sign.
    """
    cone = rig.lasers[laser].surface
    assert isinstance(cone, Cone)
    middle = cone.apex + cone.axis * ((stand_off - cone.apex[2]) / cone.axis[2])
    ways = np.stack([*xy_of(np.arange(POINTS) * (2 * np.pi / POINTS), 1.0), np.zeros(POINTS)], axis=1)
    low, high = np.zeros(POINTS), np.full(POINTS, FARTHEST * stand_off)
    inside = np.sign(cone.value(middle + 1e-9 * stand_off * ways))
    lit = np.sign(cone.value(middle + high[:, None] * ways)) != inside
    for _ in range(HALVINGS):
        half = (low + high) / 2
        same = np.sign(cone.value(middle + half[:, None] * ways)) == inside
        low, high = np.where(same, half, low), np.where(same, high, half)
    return np.where(lit[:, None], middle + low[:, None] * ways, np.nan)
