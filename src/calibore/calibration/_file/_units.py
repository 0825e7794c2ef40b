"""In which unit a parameter stands in a calibration's FILE."""

LENGTHS = frozenset(
    {"baseline", "offset", "x", "y", "z", "centre_x", "centre_y", "centre_z", "distance", "range", "length", "height"}
    | {"port_thickness", "port_distance", "slide", "slope", "intercept", "length_origin", "diameter", "radius", "pivot"}
)
ANGLES = frozenset({"aim", "half_angle", "clock", "zenith", "roll", "pitch", "yaw", "turn"})
PIXELS = frozenset({"k", "principal_point_u", "principal_point_v"})


def unit_of_parameter(name: str) -> str:
    """`"laser.0.aim"` -> `"rad"`, `"camera.k"` -> `"px"`, `"camera.pupil_walk_2"` -> `"m/rad^2"`, "" a pure number."""
    last = name.split(".")[-1]
    if last.startswith("pupil_walk_"):
        return f"m/rad^{last.rsplit('_', 1)[1]}"
    for unit, names in (("m", LENGTHS), ("rad", ANGLES), ("px", PIXELS)):
        if last in names:
            return unit
    return ""
