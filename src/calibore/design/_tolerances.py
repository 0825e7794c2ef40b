"""How well must I build it: from the uncertainty that is wanted to what each parameter is allowed."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._curves import useful_clocks
from calibore.design._prediction import STRIPE, scan_direction
from calibore.design._ring import RingPrediction, predict_ring, ring_clocks
from calibore.design._shares import of_any_laser
from calibore.errors import InputError
from calibore.lasers import Beam
from calibore.rigs import Rig, triangulate

Array = NDArray[np.float64]
SHAPE_OF_LENS = ("c1", "c2", "polynomial", "pupil_walk", "port")
"""Parameters that calibration finds and no workshop builds to."""
NEGLIGIBLE = 1e-9
"""Of the largest effect that a parameter of one nominal radius or one radian could have."""
CLOCKS = 120


@dataclass(frozen=True)
class Tolerance:
    """Of the parameter `name`, in its `unit` (m, rad, px or 1): the `sensitivity` [m per unit] at the clock where it
    is largest; the standard uncertainty allowed `alone`, and `sharing` the variance with all others; None where the
    parameter has no effect.
    """

    name: str
    unit: str
    sensitivity: float
    alone: float | None
    sharing: float | None

    @property
    def limits(self) -> float | None:
        """Half width of a rectangular tolerance with the standard uncertainty `sharing`."""
        return None if self.sharing is None else float(np.sqrt(3) * self.sharing)


@dataclass(frozen=True, eq=False)
class Tolerances:
    """For a standard uncertainty `target` [m] of the radius at the worst useful clock; `fraction` of clocks useful."""

    target: float
    rows: tuple[Tolerance, ...]
    fraction: float


def tolerances(
    rig: Rig, *, nominal_radius: float, target: float, assumptions: Assumptions = HONEST
) -> Tolerances | None:
    """What each parameter is allowed, so that the radius of the nominal wall has at most the standard uncertainty
    `target` [m] at every useful clock; None where the rig measures nowhere.

    Inputs are taken as independent. Sharing: in proportion to 1 / sensitivity, each as much as any other where it
    counts most, scaled so that the worst clock just meets the target.
    """
    if not 0 < target < np.inf:
        raise InputError(f"The target must be a positive uncertainty, got {target} m; 0.5 % of the radius is usual.")
    clock = ring_clocks(rig, CLOCKS)
    ring = predict_ring(rig, clock, nominal_radius, assumptions=assumptions)
    good = useful_clocks(ring.u_radius, ring.first_order)
    if not good.any():
        return None
    slopes = effects(rig, ring, good, assumptions)
    largest = {name: float(np.abs(slope).max()) for name, slope in slopes.items()}
    counts = [name for name, most in largest.items() if most > NEGLIGIBLE * _natural(name, nominal_radius)]
    total = np.sqrt(np.max(sum((slopes[name] / largest[name]) ** 2 for name in counts)))
    rows = (
        Tolerance(
            name,
            unit_of(name),
            largest[name],
            target / largest[name] if name in counts else None,
            float(target / largest[name] / total) if name in counts else None,
        )
        for name in slopes
    )
    ordered = sorted(rows, key=lambda row: (row.sharing is None, row.unit != "px", row.name))
    return Tolerances(target, tuple(ordered), float(good.mean()))


def effects(rig: Rig, ring: RingPrediction, good: NDArray[np.bool_], assumptions: Assumptions) -> Mapping[str, Array]:
    """Derivatives of R (n,) at the good clocks, of the laser that weighs most there, by its parameters, the camera's,
    and a pixel of noise. Lasers of one kind are built alike: "laser.1.aim" stands as "laser.aim".
    """
    parameters = np.zeros((int(good.sum()), len(rig.parameter_names)))
    noise = np.zeros(len(parameters))
    for number, found in enumerate(ring.predictions):
        mine = (ring.laser == number)[good]
        if not mine.any():
            continue
        at = good & (ring.laser == number)
        u, v, branch = (_of_laser(a, at, rig) for a in (found.u, found.v, found.branch))
        slopes = triangulate(rig, u, v, laser=number, branch=branch).radius_sensitivities
        parameters[mine] = slopes.parameters
        along = None if assumptions.direction is None else scan_direction(rig, u, v)
        noise[mine] = _size(slopes.pixel, along)
    columns: dict[str, Array] = {}
    for column, name in enumerate(rig.parameter_names):
        if not name.split(".")[-1].startswith(SHAPE_OF_LENS):
            alike = of_any_laser(name)
            columns[alike] = columns.get(alike, np.zeros(len(noise))) + parameters[:, column]
    return {**columns, STRIPE: noise}


def unit_of(name: str) -> str:
    """Of a parameter, by its last part."""
    last = name.split(".")[-1]
    if last in ("baseline", "offset", "x", "y", "z"):
        return "m"
    if last in ("aim", "half_angle", "clock", "zenith"):
        return "rad"
    return "px" if last in (STRIPE, "k", "principal_point_u", "principal_point_v") else "1"


def _of_laser(values: NDArray, at: NDArray[np.bool_], rig: Rig) -> NDArray:
    """Of a beam there is one place only."""
    return np.atleast_1d(values) if isinstance(rig.lasers[0].surface, Beam) else values[at]


def _size(by_pixel: Array, along: Array | None) -> Array:
    if along is None:
        return np.linalg.norm(by_pixel, axis=1)
    return np.abs(np.einsum("nk,nk->n", by_pixel, along))


def _natural(name: str, nominal_radius: float) -> float:
    return 1.0 if unit_of(name) == "m" else nominal_radius
