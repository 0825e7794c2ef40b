"""A photograph of a flat target of concentric rings and spokes, through any lens, with known truth."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera
from calibore.simulation._sensor import Sensor
from calibore.simulation._soft_edges import NEAR, TargetLight, photographed, softened

Array = NDArray[Any]

INK, PAPER, BACKING = 0.1, 1.0, 0.2  # reflectances
MARGIN = 0.25  # spacings of paper beyond the outermost ring
LIGHT = TargetLight()


def photograph_rings(
    camera: Camera,
    target_from_camera: Pose,
    *,
    ring_spacing: float,
    rings: int,
    spokes: int,
    ink_width: float,
    sensor: Sensor,
    rng: np.random.Generator,
    radius_errors: ArrayLike = 0.0,
    paper_radius: float | None = None,
    light: TargetLight = LIGHT,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w, 3) of a target in the plane z = 0 of its own frame, z away from the camera, its first spoke
    along x.

    `ring_spacing`, `ink_width`, `paper_radius` [m]; `radius_errors` [m]: printed minus stated radius of each ring.
    """
    radii = ring_spacing * np.arange(1, rings + 1) + np.asarray(radius_errors, dtype=float)
    paper = (rings + MARGIN) * ring_spacing if paper_radius is None else paper_radius
    printed = PrintedRings(radii, spokes, ink_width, paper)
    picture = photographed(
        camera, printed, scene_from_camera=target_from_camera, light=light, psf_sigma=sensor.psf_sigma
    )
    return sensor.read_out(picture, rng)


@dataclass(frozen=True, eq=False)
class PrintedRings:
    """Dark rings with ink midlines at `radii` (rings,) [m], innermost first, and spokes from the centre to the
    outermost; `ink_width` [m] of every line; white paper up to `paper_radius` [m] on a dark backing.
    """

    radii: Array
    spokes: int
    ink_width: float
    paper_radius: float

    def __post_init__(self) -> None:
        if len(self.radii) < 1 or not np.all(np.diff(self.radii, prepend=0.0) > self.ink_width) or self.spokes < 1:
            raise InputError(
                f"A ring target needs rings further apart than their ink width of {self.ink_width:g} m, and spokes; "
                f"got radii {np.round(self.radii, 5).tolist()} m and {self.spokes} spokes."
            )

    def lengths(self, origin: Array, direction: Array) -> Array:
        """Places x, y (2, n) on the target that rays meet; NaN where they look elsewhere."""
        distance = -origin[:, 2] / direction[:, 2]
        return (origin + np.where(distance > 0, distance, np.nan)[:, None] * direction).T[:2]

    def appearance(self, lengths: Array, slopes: Array) -> tuple[Array, Array]:
        """Reflectance with softened edges, and which places have an edge of ink or paper nearby."""
        radius = np.hypot(*lengths)
        outward = lengths / np.maximum(radius, 1e-12)
        middles = (self.radii[1:] + self.radii[:-1]) / 2
        from_ring = np.abs(radius - self.radii[np.searchsorted(middles, np.nan_to_num(radius))])
        from_spoke, along = self._from_spoke(lengths)
        radial, across = _pixel(outward, slopes), _pixel(along, slopes)
        half, spoked = self.ink_width / 2, radius <= self.radii[-1]
        near = np.abs(from_ring - half) < NEAR * radial
        near |= (np.abs(from_spoke - half) < NEAR * across) & (radius < 1.01 * self.radii[-1])
        near |= np.abs(radius - self.paper_radius) < NEAR * radial
        ring = softened(from_ring + half, radial) - softened(from_ring - half, radial)
        spoke = (softened(from_spoke + half, across) - softened(from_spoke - half, across)) * spoked
        bare = BACKING + (PAPER - BACKING) * softened(self.paper_radius - radius, radial)
        return bare + (INK - bare) * (1 - (1 - ring) * (1 - spoke)), near

    def _from_spoke(self, lengths: Array) -> tuple[Array, Array]:
        """Distance (n,) from the midline of the nearest spoke, and the unit vector (2, n) across it."""
        step = 2 * np.pi / self.spokes
        turn = step * np.rint(np.arctan2(lengths[1], lengths[0]) / step)
        across = np.stack([-np.sin(turn), np.cos(turn)])
        return np.abs(across[0] * lengths[0] + across[1] * lengths[1]), across


def _pixel(direction: Array, slopes: Array) -> Array:
    """Length (n,) [m] of a pixel along unit vectors (2, n) of the target."""
    by_u, by_v = (direction[0] * slopes[0, :, pixel] + direction[1] * slopes[1, :, pixel] for pixel in (0, 1))
    return np.sqrt(by_u * by_u + by_v * by_v)
