"""Photographs of a flat target of concentric rings and spokes."""

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera
from calibore.simulation._ring_target import photograph_rings
from calibore.simulation._sensor import Sensor
from calibore.simulation._soft_edges import TargetLight
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres
from calibore.simulation._targets._values import camera_values

INK = 0.06  # of the spacing, as on the dissertation's targets


@dataclass(frozen=True, eq=False)
class RingTarget(Target):
    """`rings` of equal `ring_spacing` [m] with `spokes`, drawn `ink_width` [m] wide (None: 6 % of the spacing), lie in
    `plane` of the frame of `camera` (as both truly are), their centre over `centre` [m], the first spoke turned by
    `roll` [rad]. `u_ring` [m]: standard deviation of what each printed radius is off by.

    target.toml states `nominal_baseline` [m], the plane's own where None. Photographed `takes` times.
    """

    camera: Camera
    plane: Plane
    ring_spacing: float
    rings: int
    spokes: int = 8
    ink_width: float | None = None
    centre: tuple[float, float] = (0.0, 0.0)
    roll: float = 0.0
    u_ring: float = 0.0
    takes: int = 1
    nominal_baseline: float | None = None
    sensor: Sensor = field(default_factory=lambda: Sensor(psf_sigma=0.8))
    light: TargetLight = field(default_factory=TargetLight)
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "lens"

    def __post_init__(self) -> None:
        if not (self.ring_spacing > 0 and self.rings >= 1 and self.spokes >= 2 and self.takes >= 1):
            raise InputError(
                f"A ring target needs a positive spacing, a ring, 2 spokes and a photograph, got {self.ring_spacing:g} "
                f"m, {self.rings} rings, {self.spokes} spokes, {self.takes} takes."
            )
        if self.u_ring < 0 or not 0 < self.ink < self.ring_spacing:
            raise InputError(
                f"Lines of a ring target are thinner than their spacing, and u_ring is not negative, got "
                f"{1e3 * self.ink:g} mm of {1e3 * self.ring_spacing:g} mm and u_ring {1e3 * self.u_ring:g} mm."
            )

    @property
    def ink(self) -> float:
        """Width [m] of its lines."""
        return INK * self.ring_spacing if self.ink_width is None else self.ink_width

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Rings with the errors of their printing."""
        errors = self.u_ring * rng.standard_normal(self.rings)
        photographed = partial(self._photograph, errors)
        plane = {f"laser.{key}": float(getattr(self.plane, key)) for key in self.plane.parameter_names}
        return Layout(
            said={
                "kind": "concentric-rings",
                "images": "rings {take}.png",
                "ring_spacing": metres(self.ring_spacing),
                "rings": self.rings,
                "spokes": self.spokes,
                "nominal_baseline": metres(self.nominal_baseline or self.plane.baseline),
            },
            truth={
                **camera_values(self.camera),
                **plane,
                "ring_radius": self.ring_spacing * np.arange(1, self.rings + 1) + errors,
                "centre": np.array(self.centre),
                "roll": self.roll,
            },
            pictures={f"rings {take}.png": photographed for take in range(self.takes)},
        )

    def _photograph(self, errors: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return photograph_rings(
            self.camera,
            target_pose(self.plane, centre=self.centre, roll=self.roll),
            ring_spacing=self.ring_spacing,
            rings=self.rings,
            spokes=self.spokes,
            ink_width=self.ink,
            radius_errors=errors,
            sensor=self.sensor,
            light=self.light,
            rng=rng,
        )


def target_pose(plane: Plane, *, centre: tuple[float, float] = (0.0, 0.0), roll: float = 0.0) -> Pose:
    """target_from_camera: the target is z = 0 of its own frame, its first spoke along x, which is turned by `roll`
    [rad] from the camera's x towards its y.
    """
    normal = np.array([-plane.tilt_x, -plane.tilt_y, 1.0])
    along = np.array([1.0, 0.0, plane.tilt_x])
    normal, along = normal / np.linalg.norm(normal), along / np.linalg.norm(along)
    across, cosine, sine = np.cross(normal, along), np.cos(roll), np.sin(roll)
    rotation = np.stack([cosine * along + sine * across, cosine * across - sine * along, normal])
    x, y = centre
    return Pose(rotation, -rotation @ np.array([x, y, plane.baseline + plane.tilt_x * x + plane.tilt_y * y]))
