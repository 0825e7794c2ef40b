"""What profile.zarr and points.zarr hold: names, dimensions, types, units (contract, section 4)."""

from dataclasses import dataclass, field
from typing import Any

from calibore.status import Status

STATIONS_PER_CHUNK = 32
POINTS_PER_CHUNK = 65536
PROFILE_FORMAT = "calibore-profile/1"
POINTS_FORMAT = "calibore-points/1"


@dataclass(frozen=True)
class Variable:
    """One array of a store: floats are filled with NaN, integers with 0."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    long_name: str
    dtype: str = "float64"
    more: dict[str, Any] = field(default_factory=dict)

    @property
    def attributes(self) -> dict[str, Any]:
        units = {"units": self.units} if self.units else {}
        return {"long_name": self.long_name, **units, **self.more}


STATUS_FLAGS = {
    "flag_values": [int(status) for status in Status],
    "flag_meanings": " ".join(status.name.lower() for status in Status),
}

_RING, _STATION, _POINT = ("station", "clock"), ("station",), ("point",)
_ON_STATIONS = {"coordinates": "axial"}


def _grid(name: str, units: str, long_name: str, dtype: str = "float64", **more: Any) -> Variable:
    return Variable(name, _RING, units, long_name, dtype, _ON_STATIONS | more)


def _per_station(name: str, units: str, long_name: str) -> Variable:
    return Variable(name, _STATION, units, long_name, more=_ON_STATIONS)


PROFILE_VARIABLES = (
    Variable("station", _STATION, "", "number in the image's name, or the video's frame number", "int64"),
    Variable("axial", _STATION, "m", "axial position of the rig origin"),
    Variable("clock", ("clock",), "rad", "angle round the pipe from the crown, clockwise looking along travel"),
    _grid("radius", "m", "distance of the wall from the rig axis"),
    _grid("axial_position", "m", "axial position of the wall point"),
    _grid("u_independent", "m", "standard uncertainty of radius that differs from point to point"),
    _grid("u_common", "m", "standard uncertainty of radius shared by the whole scan"),
    Variable(
        "common_mode",
        ("mode", *_RING),
        "m",
        "shared uncertainty in low rank: cov(radius) = diag(u_independent^2) + sum over modes of m m^T",
        more=_ON_STATIONS,
    ),
    Variable(
        "noise_correlation",
        ("station", "lag"),
        "",
        "correlation of the independent part with that of the clock position 1, 2, ... steps away",
        more=_ON_STATIONS,
    ),
    _grid("status", "", "why a point is missing or suspect", "uint8", **STATUS_FLAGS),
    _per_station("centre_x", "m", "fitted pipe centre in the rig frame, to the right"),
    _per_station("centre_y", "m", "fitted pipe centre in the rig frame, downwards"),
    _per_station("u_centre_x", "m", "standard uncertainty of centre_x"),
    _per_station("u_centre_y", "m", "standard uncertainty of centre_y"),
    _per_station("time_s", "s", "time since the start of the scan"),
    _per_station("roll", "rad", "roll of the rig"),
)

# float32 keeps 7 digits: 15 nm on a radius of 0.25 m, 6e-5 px in a 1024 px image, 0.05 um of arc; z and axial grow
# with the length of the pipe and stay float64.
POINTS_VARIABLES = (
    Variable("x", _POINT, "m", "to the right in the pipe frame", "float32"),
    Variable("y", _POINT, "m", "downwards in the pipe frame", "float32"),
    Variable("z", _POINT, "m", "along travel in the pipe frame"),
    Variable("radius", _POINT, "m", "distance of the wall from the rig axis", "float32"),
    Variable("clock", _POINT, "rad", "angle round the pipe from the crown, clockwise looking along travel", "float32"),
    Variable("axial", _POINT, "m", "axial position of the wall point"),
    Variable("u_radius", _POINT, "m", "standard uncertainty of radius", "float32"),
    Variable("u", _POINT, "pixel", "column of the stripe in the image", "float32"),
    Variable("v", _POINT, "pixel", "row of the stripe in the image", "float32"),
    Variable("station", _POINT, "", "station the point belongs to", "int64"),
    Variable("take", _POINT, "", "take the point was found in", "int32"),
    Variable("status", _POINT, "", "why a point is missing or suspect", "uint8", STATUS_FLAGS),
)
