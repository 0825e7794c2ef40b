"""What the compiled engine is told of a rig, and which rigs it knows; the others go the way of its NumPy twin."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.kernels import is_native
from calibore.lasers import Beam, Cone, LaserSurface, Plane, Sheet
from calibore.rigs._mount import FORWARD, SideFacing
from calibore.rigs._rig import Rig
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]

SURFACES: tuple[type[LaserSurface], ...] = (Plane, Cone, Sheet, Beam)
LAWS = ("perspective", "stereographic", "equidistant", "sine-law", "equisolid-angle")
CAMERA = tuple(f"camera.{name}" for name in ("k", "c1", "c2", "aspect", "principal_point_u", "principal_point_v"))
SURFACE_NUMBERS, MOUNT_NUMBERS = 7, 2
LONGEST_DIRECTION = 1e9


class Make(NamedTuple):
    """Kind of surface, whether the camera faces sideways, lens law, half image height, whether there is a residual."""

    surface: int
    side_facing: bool
    law: int
    half_height: float
    residual: bool


def computes(kernel: str, rig: Rig, laser: int) -> bool:
    """Whether the compiled engine shall and can compute this rig."""
    return is_native(kernel) and _is_known(rig, rig.lasers[laser].surface)


def _is_known(rig: Rig, surface: LaserSurface) -> bool:
    known_mount = rig.mount == FORWARD or type(rig.mount) is SideFacing
    return known_mount and type(surface) in SURFACES and rig.camera.parameter_names == CAMERA


def make_of(rig: Rig, laser: int, *, varied: tuple[str, ...] = ()) -> Make:
    """`varied`: the parameters that will not keep their values."""
    lens = rig.camera.lens
    residual = lens.c1 != 0 or lens.c2 != 0 or bool({"camera.c1", "camera.c2"} & set(varied))
    surface = SURFACES.index(type(rig.lasers[laser].surface))
    return Make(surface, rig.mount != FORWARD, LAWS.index(lens.law), float(lens.half_height), residual)


def names_of(rig: Rig, laser: int) -> tuple[str, ...]:
    """The parameters that matter to the meetings with one laser, in the engine's order."""
    surface = (f"{rig.laser_table(laser)}.{name}" for name in rig.lasers[laser].surface.parameter_names)
    return (*surface, *(f"laser.{name}" for name in rig.mount.parameter_names), *CAMERA)


def values_of(rig: Rig, laser: int) -> Array:
    """The values of `names_of`, SI and px."""
    surface, camera = rig.lasers[laser].surface, rig.camera
    values = [getattr(surface, name) for name in surface.parameter_names]
    values += [getattr(rig.mount, name) for name in rig.mount.parameter_names]
    return np.array([*values, camera.lens.k, camera.lens.c1, camera.lens.c2, camera.aspect, *camera.principal_point])


@lru_cache(maxsize=16)
def known_of(rig: Rig, laser: int) -> tuple[Make, Array, Array]:
    """Make, values and modes: all that the engine is told of a rig, once for many calls."""
    return make_of(rig, laser), values_of(rig, laser), modes_of(rig, laser)


@lru_cache(maxsize=16)
def engine_form(rig: Rig, laser: int) -> tuple[Make, Array, Array] | None:
    """Make, values (p,) and (m, 15) what each column of the covariance's factor does to the rig, for other engines that
    place points; None where they must be placed in NumPy.
    """
    if not _is_known(rig, rig.lasers[laser].surface):
        return None
    modes = _factor_of(rig, laser).T @ _numbers_by_parameters(rig, laser).T
    return make_of(rig, laser), values_of(rig, laser), np.ascontiguousarray(modes)


def modes_of(rig: Rig, laser: int) -> Array:
    """(m, 15): how numbers of surface, mount and camera move together, by one standard uncertainty each."""
    modes = np.linalg.qr(_factor_of(rig, laser).T, mode="r") @ _numbers_by_parameters(rig, laser).T
    return np.ascontiguousarray(modes[modes.any(axis=1)])


def _factor_of(rig: Rig, laser: int) -> Array:
    """(p, m) of the parameters `names_of`; no uncertainty for those that the covariance does not name."""
    covariance = rig.covariance or Covariance.independent({})
    names = names_of(rig, laser)
    known = [name for name in names if name in covariance.names]
    factor = np.zeros((len(names), len(covariance.names)))
    if known:
        factor[[names.index(name) for name in known]] = covariance.factor()[[covariance.names.index(n) for n in known]]
    return factor


def _numbers_by_parameters(rig: Rig, laser: int) -> Array:
    """(15, p)."""
    surface = rig.lasers[laser].surface
    q, m = len(surface.parameter_names), len(rig.mount.parameter_names)
    derivatives = np.zeros((SURFACE_NUMBERS + MOUNT_NUMBERS + len(CAMERA), q + m + len(CAMERA)))
    derivatives[:SURFACE_NUMBERS, :q] = _surface_by_parameters(surface)
    derivatives[SURFACE_NUMBERS : SURFACE_NUMBERS + m, q : q + m] = np.eye(m)
    derivatives[-len(CAMERA) :, -len(CAMERA) :] = np.eye(len(CAMERA))
    return derivatives


def _surface_by_parameters(surface: Any) -> Array:
    """(7, q): normal and level of flat surfaces; apex, axis and half angle of cones."""
    rows = np.zeros((SURFACE_NUMBERS, len(surface.parameter_names)))
    if not isinstance(surface, Cone):
        rows[:3], rows[3] = surface.normal_by_parameters, surface.level_by_parameters
        return rows
    rows[:3], rows[3:6] = surface.apex_by_parameters, surface.axis_by_parameters
    rows[6, 2] = 1.0
    return rows


def each(values: ArrayLike, n: int, *, what: str) -> Array:
    """`values` as one number or one for each of `n` points."""
    values = np.ascontiguousarray(np.atleast_1d(np.asarray(values, dtype=float)))
    if values.shape not in ((1,), (n,)):
        raise InputError(f"{what} needs one number, or one for each of {n} points, got shape {values.shape}.")
    return values


def columns(direction: ArrayLike | None, n: int) -> tuple[Array, Array] | None:
    """Directions (n, 2) of the noise in the image, u and v apart; None: both are noisy."""
    if direction is None:
        return None
    direction = np.asarray(direction, dtype=float)
    if direction.shape != (n, 2) or (np.abs(direction) > LONGEST_DIRECTION).any():
        raise InputError(f"The direction of the noise needs {n} unit vectors (du, dv), got shape {direction.shape}.")
    return np.ascontiguousarray(direction[:, 0]), np.ascontiguousarray(direction[:, 1])
