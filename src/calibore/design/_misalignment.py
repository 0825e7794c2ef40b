"""What a laser that is not where it should be costs: known about (uncertainty) or not (error)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._curves import useful_clocks
from calibore.design._prediction import predict_on_wall
from calibore.design._ring import predict_ring, ring_clocks
from calibore.errors import InputError
from calibore.lasers import Beam, Cone, Plane
from calibore.rigs import Rig, SideFacing, lit_points, moved, triangulate
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
ANGLES = np.radians(np.linspace(0, 2, 11))
CLOCKS = 120


@dataclass(frozen=True, eq=False)
class Misalignment:
    """Of the parameter `name`, over `angle` (a,) [rad]: the worst standard uncertainty `u_radius` [m] of useful clocks
    when the angle is a standard uncertainty; `worst_error` and `mean_error` [m] of R round the nominal wall when it
    is there and nobody knows.
    """

    name: str
    angle: Array
    u_radius: Array
    worst_error: Array
    mean_error: Array


def misalignments(rig: Rig, *, nominal_radius: float, assumptions: Assumptions = HONEST) -> list[Misalignment]:
    """For the angles by which lasers of this kind go astray (Swanbom 2007, section 4.3.6, for every configuration)."""
    clock = ring_clocks(rig, CLOCKS)
    ring = predict_ring(rig, clock, nominal_radius, assumptions=assumptions)
    good = useful_clocks(ring.u_radius, ring.first_order)
    if not good.any():
        return []
    found = []
    for name in _angles_of(rig):
        sizes: list[float] = (np.tan(ANGLES) if name in ("tilt_y", "skew", "lean") else ANGLES).tolist()
        paths = _paths(rig, name)
        u = [_worst_u(rig, clock[good], nominal_radius, assumptions, dict.fromkeys(paths, size)) for size in sizes]
        errors = [_errors(rig, clock, good, ring.laser, nominal_radius, dict.fromkeys(paths, s)) for s in sizes]
        worst = [np.abs(e).max() if np.isfinite(e).all() else np.nan for e in errors]
        found.append(Misalignment(name, ANGLES, np.array(u), np.array(worst), np.array([e.mean() for e in errors])))
    return found


def _angles_of(rig: Rig) -> tuple[str, ...]:
    surface = rig.lasers[0].surface
    if isinstance(rig.mount, SideFacing):
        return "aim", "skew"
    if isinstance(surface, Plane):
        return ("tilt_y",)
    if isinstance(surface, Cone):
        return ("aim",)
    return ("zenith",) if isinstance(surface, Beam) else ()


def _paths(rig: Rig, name: str) -> list[str]:
    if name in rig.mount.parameter_names:
        return [f"laser.{name}"]
    return [f"{rig.laser_table(number)}.{name}" for number in range(len(rig.lasers))]


def _worst_u(rig: Rig, clock: Array, radius: float, assumptions: Assumptions, more: dict[str, float]) -> float:
    if isinstance(rig.lasers[0].surface, Beam):
        clock = ring_clocks(rig)
    known = rig.knowing(_with_more(rig.covariance, more))
    return float(np.nanmax(predict_ring(known, clock, radius, assumptions=assumptions).u_radius))


def _with_more(known: Covariance | None, more: dict[str, float]) -> Covariance:
    """`known` with the variances of `more` added, uncorrelated."""
    if known is None:
        return Covariance.independent(more)
    matrix = known.matrix.copy()
    for name, u in more.items():
        if name in known.names:
            at = known.names.index(name)
            matrix[at, at] += u**2
    enlarged = Covariance(known.names, matrix, known.distributions, known.degrees_of_freedom)
    absent = {name: u for name, u in more.items() if name not in known.names}
    return enlarged.joined(Covariance.independent(absent)) if absent else enlarged


def _errors(
    rig: Rig, clock: Array, good: NDArray[np.bool_], laser: NDArray[np.intp], radius: float, change: dict[str, float]
) -> Array:
    """R - R0 [m] at the good clocks, of the laser that weighs most there: where the light of the real rig falls, as
    the stated rig reads it.
    """
    try:
        real = moved(rig, change)
    except InputError:
        return np.full(int(good.sum()), np.nan)
    error = np.full(clock.shape, np.nan)
    for number in range(len(rig.lasers)):
        mine = good & (laser == number)
        if not mine.any():
            continue
        points = lit_points(real, clock[mine], radius, laser=number)
        u, v = real.project(points)
        branch = predict_on_wall(rig, clock[mine], radius, laser=number).branch
        error[mine] = triangulate(rig, u, v, laser=number, branch=branch).radius - radius
    return error[good]
