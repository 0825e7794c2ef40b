"""What a rig measures at every pixel of its image, and how well: measurement and uncertainty maps."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._prediction import Prediction, predict
from calibore.lasers import Beam, MeetingFlag
from calibore.rigs import Rig, meetings_of
from calibore.status import Status
from calibore.uncertainty import FIRST_ORDER_FROM, MEASURABLE_ABOVE

COLUMNS, ROWS = 400, 300
PLAUSIBLE = 2.0
"""A second meeting counts as a doubt where its radius is below so many nominal radii."""


class Region(IntEnum):
    """What a pixel of the line would tell; a value from `AMBIGUOUS` downwards is still a value."""

    MEASURED = 0
    AMBIGUOUS = 1
    MONTE_CARLO = 2
    NOT_MEASURABLE = 3
    NO_MEETING = 4
    OUTSIDE_LENS = 5

    @property
    def has_value(self) -> bool:
        return self <= Region.MONTE_CARLO


@dataclass(frozen=True, eq=False)
class ImageMap:
    """Of one `laser`: pixel columns `u` (c,), rows `v` (r,), their `prediction` (r, c) and `region` (r, c)."""

    laser: int
    u: NDArray[np.float64]
    v: NDArray[np.float64]
    prediction: Prediction
    region: NDArray[np.uint8]

    def valued(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """`values` (r, c) where the region has a value, else NaN."""
        return np.where(self.region <= Region.MONTE_CARLO, values, np.nan)

    def fraction(self, region: Region) -> float:
        """Of the image."""
        return float((self.region == region).mean())


def image_map(
    rig: Rig,
    *,
    nominal_radius: float,
    laser: int = 0,
    assumptions: Assumptions = HONEST,
    columns: int = COLUMNS,
    rows: int = ROWS,
) -> ImageMap:
    """R, H and their uncertainty over the image, edge to edge, for a wall about `nominal_radius` [m]."""
    camera = rig.camera
    across = np.linspace(0, camera.width, columns)
    down = np.linspace(0, camera.height, rows) if camera.height > 1 else np.array([camera.principal_point[1]])
    u, v = np.meshgrid(across, down)
    found = predict(
        rig,
        u,
        v,
        u_pixel=assumptions.u_pixel,
        direction=assumptions.direction,
        laser=laser,
        prior_radius=nominal_radius,
    )
    return ImageMap(laser, across, down, found, _regions(rig, found, laser, nominal_radius))


def maps_of(rig: Rig, *, nominal_radius: float, assumptions: Assumptions = HONEST) -> list[ImageMap]:
    """One map per laser; none for spot arrays, whose image holds single spots."""
    if isinstance(rig.lasers[0].surface, Beam):
        return []
    return [
        image_map(rig, nominal_radius=nominal_radius, laser=laser, assumptions=assumptions)
        for laser in range(len(rig.lasers))
    ]


def _regions(rig: Rig, found: Prediction, laser: int, nominal_radius: float) -> NDArray[np.uint8]:
    candidates = meetings_of(rig, found.u.ravel(), found.v.ravel(), laser=laser)
    plausible = (candidates.radius > 0) & (candidates.radius < PLAUSIBLE * nominal_radius)
    doubtful = (plausible.sum(axis=0) > 1).reshape(found.u.shape)
    grazing = ((candidates.flags & MeetingFlag.GRAZING) != 0).any(axis=0).reshape(found.u.shape)
    region = np.full(found.u.shape, Region.MEASURED, dtype=np.uint8)
    region[doubtful] = Region.AMBIGUOUS
    region[found.margin < FIRST_ORDER_FROM] = Region.MONTE_CARLO
    region[found.margin <= MEASURABLE_ABOVE] = Region.NOT_MEASURABLE
    region[found.status != Status.OK] = Region.NO_MEETING
    region[(found.status != Status.OK) & grazing] = Region.NOT_MEASURABLE
    region[found.status == Status.OUTSIDE_LENS] = Region.OUTSIDE_LENS
    return region
