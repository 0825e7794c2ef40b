"""Why a point is missing or suspect.

One byte per point, stored with CF `flag_values` and `flag_meanings`. Stored numbers never change, so new statuses come
at the end; which of them carry a value `has_value` tells. Where none does the value is NaN.
"""

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class Status(IntEnum):
    """Status of one point; see `MEANING` for the sentence shown to people."""

    OK = 0
    RESOLVED = 1
    SATURATED = 2
    NO_PEAK = 3
    MULTIPLE = 4
    OFF_RING = 5
    NOT_LASER = 6
    OUTSIDE_LENS = 7
    GRAZING = 8
    BEHIND = 9
    NO_IMAGE = 10
    EXTRAPOLATED = 11
    STUCK = 12
    OFF_TIP = 13
    NO_READING = 14
    WATER = 15

    @property
    def has_value(self) -> bool:
        return self <= Status.SATURATED or self is Status.EXTRAPOLATED


MEANING: dict[Status, str] = {
    Status.OK: "measured",
    Status.RESOLVED: "several peaks on the ray, or lasers that differ: one was chosen",
    Status.SATURATED: "measured on a saturated line",
    Status.NO_PEAK: "no line found",
    Status.MULTIPLE: "several peaks on the ray, none preferred",
    Status.OFF_RING: "a peak that does not belong to the ring",
    Status.NOT_LASER: "light of another colour or another line width than the laser's",
    Status.OUTSIDE_LENS: "beyond what the lens law can image",
    Status.GRAZING: "the camera ray only grazes the laser surface",
    Status.BEHIND: "the meeting lies behind the camera",
    Status.NO_IMAGE: "no usable image for this station",
    Status.EXTRAPOLATED: "measured outside the region where the rig was calibrated",
    Status.STUCK: "the probe's pin stuck where the wall falls back",
    Status.OFF_TIP: "the wall is steeper or narrower than the probe's ball: its end did not touch it here",
    Status.NO_READING: "no usable voltages of the probe",
    Status.WATER: "light mirrored in a water surface, or the surface itself",
}

_HAS_VALUE = np.array([status.has_value for status in Status])


def has_value(status: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which points of `status`, any shape, carry a value."""
    return _HAS_VALUE[status]
