"""A rig: a camera, the laser surfaces that move with it, and how well its parameters are known."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.lasers import LaserSurface
from calibore.optics import Camera
from calibore.rigs._defaults import default_inputs
from calibore.rigs._mount import FORWARD, Mount
from calibore.rigs._valid import ValidRegion
from calibore.uncertainty import Covariance

CHANNELS = ("red", "green", "blue", "luma")


@dataclass(frozen=True)
class Laser:
    """`surface` in the rig frame; `channel` of the image that shows it, None where the rig file does not say; `takes`
    in which it is lit, None for all.
    """

    surface: LaserSurface
    channel: str | None = None
    takes: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        if self.channel is not None and self.channel not in CHANNELS:
            raise InputError(f'Channel "{self.channel}" is not known; allowed: {", ".join(CHANNELS)}.')

    def is_lit(self, take: int) -> bool:
        return self.takes is None or take in self.takes


@dataclass(frozen=True, eq=False)
class Rig:
    """A camera on its `mount` and the laser surfaces, in the rig frame.

    `covariance` of the parameters (names as `parameter_names`, SI), shared by the whole scan; None where nothing is
    stated. `stripe` [px]: stated standard uncertainty of a line position, None where the image shall tell.
    `default_uncertainty`: the uncertainty of the laser's lengths is the default, not stated by the rig file.
    `valid`: where it was calibrated, None where nothing is known of it.
    """

    configuration: str
    camera: Camera
    lasers: tuple[Laser, ...]
    covariance: Covariance | None = None
    stripe: float | None = None
    default_uncertainty: bool = False
    degrees_of_freedom: float | None = None
    mount: Mount = FORWARD
    valid: ValidRegion | None = None

    def __post_init__(self) -> None:
        if not self.lasers:
            raise InputError("A rig needs at least one laser, got none; add a [laser] table.")
        if self.stripe is not None and not 0 <= self.stripe < np.inf:
            raise InputError(f"The stripe's standard uncertainty must not be negative, got {self.stripe} px.")
        unknown = set(self.covariance.names if self.covariance else ()) - set(self.parameter_names)
        if unknown:
            raise InputError(
                f"This rig has no parameter {', '.join(sorted(unknown))}; allowed: {', '.join(self.parameter_names)}."
            )

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Dotted paths of all parameters: those of every laser's surface, of the mount, of the camera."""
        surfaces = (
            f"{self.laser_table(number)}.{name}"
            for number, laser in enumerate(self.lasers)
            for name in laser.surface.parameter_names
        )
        return (*surfaces, *(f"laser.{name}" for name in self.mount.parameter_names), *self.camera.parameter_names)

    def laser_table(self, laser: int) -> str:
        """First part of the names of a laser's parameters: "laser", or "laser.0", "laser.1" where there are more."""
        return "laser" if len(self.lasers) == 1 else f"laser.{laser}"

    def among_all(self, by_surface: NDArray[Any], *, laser: int) -> NDArray[Any]:
        """Derivatives (..., q) by the surface of `laser`, with columns of zeros for the surfaces of the others."""
        before = sum(len(one.surface.parameter_names) for one in self.lasers[:laser])
        after = sum(len(one.surface.parameter_names) for one in self.lasers[laser + 1 :])
        if before == after == 0:
            return by_surface
        return np.pad(by_surface, [(0, 0)] * (by_surface.ndim - 1) + [(before, after)])

    def knowing(self, covariance: Covariance | None, degrees_of_freedom: float | None = None) -> "Rig":
        """This rig with other uncertainties of its parameters."""
        return replace(self, covariance=covariance, degrees_of_freedom=degrees_of_freedom, default_uncertainty=False)

    def project(self, points: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Pixels u, v (n,) of `points` (n, 3) of the rig frame; NaN for points outside the lens's range."""
        return self.camera.project(self.mount.camera_points(np.asarray(points)))

    def with_default_uncertainty(self, nominal_radius: float) -> "Rig":
        """This rig with the default for lasers of unstated uncertainty (`default_inputs`), for a pipe of
        `nominal_radius` [m]. Whoever knows better states it in the rig file.
        """
        if not 0 < nominal_radius < np.inf:
            raise InputError(f"The nominal radius must be positive, got {nominal_radius} m.")
        stated = set(self.covariance.names if self.covariance else ())
        rig = self
        for number, laser in enumerate(self.lasers):
            default = default_inputs(laser.surface, self.mount, nominal_radius, table=self.laser_table(number))
            missing = [name for name in default.names if name not in stated]
            if missing:
                default = default.restricted(missing)
                covariance = default if rig.covariance is None else rig.covariance.joined(default)
                rig = replace(rig, covariance=covariance, default_uncertainty=True)
        return rig
