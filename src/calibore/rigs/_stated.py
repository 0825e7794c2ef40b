"""[uncertainty] and [drift] of a rig file: standard uncertainties or limits, distributions, correlations, by name."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from calibore.errors import InputError
from calibore.rigs._documents import CAMERA_INPUTS
from calibore.rigs._rig import Rig
from calibore.uncertainty import Covariance, Distribution

PORT = ("port_thickness", "port_index", "port_distance", "port_medium_index")


class Stated(NamedTuple):
    """A standard uncertainty, SI, its distribution and its degrees of freedom."""

    u: float
    distribution: Distribution
    degrees_of_freedom: float


Inputs = Mapping[str, Stated]


def stated_inputs(table: Any, rig: Rig | None, laser_keys: Mapping[str, float | None]) -> Covariance | None:
    """The inputs that [uncertainty] names, by dotted path, with their correlations; None where it names none."""
    inputs = named_inputs(table, rig, laser_keys, table_name="uncertainty")
    correlations = {(row.between[0], row.between[1]): row.coefficient for row in table.correlation}
    if not inputs:
        if correlations:
            raise InputError("uncertainty.correlation has nothing to correlate; state the uncertainties it names.")
        return None
    return Covariance.correlated(
        {path: one.u for path, one in inputs.items()},
        correlations,
        distributions={path: one.distribution for path, one in inputs.items()},
        degrees_of_freedom={path: one.degrees_of_freedom for path, one in inputs.items()},
    )


def named_inputs(table: Any, rig: Rig | None, laser_keys: Mapping[str, float | None], *, table_name: str) -> Inputs:
    """What the table [uncertainty] or [drift] states, by dotted path.

    A laser's key counts for every laser of the rig, for each apart; `principal_point` for u and for v. A camera alone,
    `rig` None, has no `laser_keys`.
    """
    inputs: dict[str, Stated] = {}
    for key in laser_keys:
        if rig is not None and getattr(table, key) is not None:
            inputs |= dict.fromkeys(_paths(rig, key), _stated(getattr(table, key), f"{table_name}.{key}"))
    for key in (*CAMERA_INPUTS, *PORT):
        if getattr(table, key) is not None:
            names = ("principal_point_u", "principal_point_v") if key == "principal_point" else (key,)
            stated = _stated(getattr(table, key), f"{table_name}.{key}")
            inputs |= dict.fromkeys((f"camera.{name}" for name in names), stated)
    for number, u in enumerate(table.pupil_walk):
        inputs[f"camera.pupil_walk_{2 * number + 2}"] = Stated(u, Distribution.NORMAL, float("inf"))
    return inputs


def _paths(rig: Rig, key: str) -> list[str]:
    if key in rig.mount.parameter_names:
        return [f"laser.{key}"]
    return [f"{rig.laser_table(number)}.{key}" for number in range(len(rig.lasers))]


def _stated(value: Any, key: str) -> Stated:
    if isinstance(value, float):
        return Stated(value, Distribution.NORMAL, float("inf"))
    if (value.u is None) == (value.limits is None):
        raise InputError(f"{key} needs either u (standard uncertainty) or limits (half width); give one.")
    freedom = value.degrees_of_freedom or float("inf")
    if value.u is not None:
        return Stated(value.u, Distribution(value.distribution or "normal"), freedom)
    distribution = Distribution(value.distribution or "rectangular")
    if distribution is Distribution.NORMAL:
        raise InputError(
            f"{key} gives limits of a normal distribution, which has none; give u, or another distribution."
        )
    return Stated(distribution.u_of_limits(value.limits), distribution, freedom)
