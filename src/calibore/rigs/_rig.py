"""A rig: a camera, the laser surfaces that move with it, and how well its parameters are known."""

from dataclasses import dataclass, replace

import numpy as np

from calibore.errors import InputError
from calibore.lasers import LaserSurface
from calibore.optics import Camera
from calibore.uncertainty import Covariance

CHANNELS = ("red", "green", "blue", "luma")
BASELINE = "laser.baseline"
DEFAULT_BASELINE_LIMIT = 0.001  # of the nominal radius, as limits (Swanbom 2007, section 4.3.2)


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
    """The rig frame is the camera frame (forward-looking rigs).

    `covariance` of the parameters (names as `parameter_names`, SI), shared by the whole scan; None where nothing is
    stated. `stripe` [px]: stated standard uncertainty of a line position, None where the image shall tell.
    `default_uncertainty`: the baseline's uncertainty is the default, not stated by the rig file.
    """

    configuration: str
    camera: Camera
    lasers: tuple[Laser, ...]
    covariance: Covariance | None = None
    stripe: float | None = None
    default_uncertainty: bool = False
    degrees_of_freedom: float | None = None

    def __post_init__(self) -> None:
        if not self.lasers:
            raise InputError("A rig needs at least one laser, got none; add a [laser] table.")
        if self.stripe is not None and not 0 <= self.stripe < np.inf:
            raise InputError(f"The stripe's standard uncertainty must not be negative, got {self.stripe} px.")
        unknown = set(self.covariance.names if self.covariance else ()) - set(self.parameter_names())
        if unknown:
            raise InputError(
                f"This rig has no parameter {', '.join(sorted(unknown))}; allowed: {', '.join(self.parameter_names())}."
            )

    def parameter_names(self, laser: int = 0) -> tuple[str, ...]:
        """Dotted paths of the parameters that a measurement with this laser depends on."""
        surface = self.lasers[laser].surface
        return (*(f"laser.{name}" for name in surface.parameter_names), *self.camera.parameter_names)

    def with_default_uncertainty(self, nominal_radius: float) -> "Rig":
        """This rig with the default for a baseline of unstated uncertainty: +-0.1 % of `nominal_radius` [m] as limits
        of a rectangular distribution (JCGM 100, 4.3.7). Whoever knows better states it in the rig file.
        """
        if self.covariance is not None and BASELINE in self.covariance.names:
            return self
        if not 0 < nominal_radius < np.inf:
            raise InputError(f"The nominal radius must be positive, got {nominal_radius} m.")
        default = Covariance.independent({BASELINE: DEFAULT_BASELINE_LIMIT * nominal_radius / np.sqrt(3)})
        covariance = default if self.covariance is None else self.covariance.joined(default)
        return replace(self, covariance=covariance, default_uncertainty=True)
