"""Pictures of things with sharp edges: sampled finely where edges pass, so that they lie exactly where they belong."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import Pose
from calibore.optics import Camera

Array = NDArray[Any]

FINENESS = 3  # samples along each side of a pixel that an edge passes
SOFTNESS = 0.2  # px: edges are drawn so soft (Gaussian) that the samples carry them without aliasing; part of the blur
NEAR = 1.6  # px from an edge within which a pixel is sampled finely
BAND = 256  # rows drawn at once
REACH = 5.0  # standard deviations at which the blur ends
LAMP = (1.0, 0.97, 0.9)  # colour


@dataclass(frozen=True)
class TargetLight:
    """Light on a target, as fractions of full scale. `exposure`: white paper in the middle of the picture; `falloff`
    towards its corners with the square of the image radius; `gradient` from one edge of the picture to the opposite
    one, growing in the image direction `azimuth` [rad].
    """

    exposure: float = 0.78
    falloff: float = 0.25
    gradient: float = 0.15
    azimuth: float = 0.6

    def at(self, camera: Camera, u: Array, v: Array) -> Array:
        """Light on white paper seen by the pixels `u`, `v`."""
        x, y = (u - (camera.width - 1) / 2) / camera.width, (v - (camera.height - 1) / 2) / camera.height
        shade = 1 - self.falloff * 2 * (x * x + y * y)
        return self.exposure * shade * (1 + self.gradient * (x * np.cos(self.azimuth) + y * np.sin(self.azimuth)))


class Scene(Protocol):
    """What a camera looks at, described by a few smooth functions of the pixel (lengths in the scene)."""

    def lengths(self, origin: Array, direction: Array) -> Array:
        """The smooth functions (f, n) [m] of rays (n, 3)."""
        ...

    def appearance(self, lengths: Array, slopes: Array) -> tuple[Array, Array]:
        """Reflectance (n,) with edges softened by `SOFTNESS` px, and whether (n,) an edge is within `NEAR` px;
        `slopes` (f, n, 2) [m/px] of the lengths by the pixel.
        """
        ...


def photographed(
    camera: Camera, scene: Scene, *, scene_from_camera: Pose, light: TargetLight, psf_sigma: float
) -> NDArray[np.float32]:
    """Light (h, w, 3) on the pixels as fractions of full scale."""
    picture = np.empty((camera.height, camera.width), dtype=np.float32)
    for top in range(0, camera.height, BAND):
        rows = top, min(top + BAND, camera.height)
        picture[rows[0] : rows[1]] = _band(camera, scene, scene_from_camera, light, psf_sigma, rows)
    return picture[..., None] * np.array(LAMP, dtype=np.float32)


def softened(distance: Array, pixel: Array) -> Array:
    """0 ... 1 across an edge at `distance` 0; `pixel`: length of a pixel there."""
    from scipy.special import ndtr

    return ndtr(distance / np.maximum(SOFTNESS * pixel, 1e-12))


def _band(
    camera: Camera, scene: Scene, pose: Pose, light: TargetLight, psf_sigma: float, rows: tuple[int, int]
) -> NDArray[np.float32]:
    """Blurred light of the picture's `rows` (first, end)."""
    halo = int(np.ceil(REACH * psf_sigma)) + 1
    v, u = (part.astype(float) for part in np.mgrid[rows[0] - halo : rows[1] + halo, -halo : camera.width + halo])
    lengths = _lengths(camera, scene, pose, u, v)
    slopes = _slopes(lengths.reshape(-1, *u.shape)).reshape(len(lengths), -1, 2)
    reflectance, near = scene.appearance(lengths, slopes)
    fine = np.repeat(np.nan_to_num(reflectance).astype(np.float32)[:, None], FINENESS**2, axis=1)
    near = np.flatnonzero(near)
    offsets = (np.arange(FINENESS) - (FINENESS - 1) / 2) / FINENESS
    du, dv = np.tile(offsets, FINENESS), np.repeat(offsets, FINENESS)
    inner = _lengths(camera, scene, pose, u.ravel()[near][:, None] + du, v.ravel()[near][:, None] + dv)
    sharp, _ = scene.appearance(inner, np.repeat(slopes[:, near], FINENESS**2, axis=1))
    fine[near] = np.nan_to_num(sharp).reshape(near.size, FINENESS**2)
    fine *= light.at(camera, u, v).astype(np.float32).reshape(-1, 1)
    grid = fine.reshape(*u.shape, FINENESS, FINENESS).transpose(0, 2, 1, 3)
    return _blurred(grid.reshape(FINENESS * u.shape[0], -1), psf_sigma)[halo:-halo, halo:-halo]


def _lengths(camera: Camera, scene: Scene, pose: Pose, u: Array, v: Array) -> Array:
    rays = camera.unproject(u.ravel(), v.ravel())
    with np.errstate(divide="ignore", invalid="ignore"):
        return scene.lengths(pose.apply(rays.origin), rays.direction @ pose.rotation.T)


def _slopes(lengths: Array) -> Array:
    """Derivatives (f, h, w, 2) by u and v."""
    by_v, by_u = np.gradient(lengths, axis=(1, 2))
    return np.stack([by_u, by_v], axis=-1)


def _blurred(fine: NDArray[np.float32], psf_sigma: float) -> NDArray[np.float32]:
    """Pixels from samples: Gaussian blur (less the softness already there), then the pixel's area, along both axes."""
    sigma = FINENESS * np.sqrt(psf_sigma**2 - SOFTNESS**2)
    reach = FINENESS * int(np.ceil(REACH * sigma / FINENESS))
    gauss = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel = np.convolve(gauss / gauss.sum(), np.full(FINENESS, 1 / FINENESS)).astype(np.float32)
    for _ in range(2):
        padded = np.pad(fine.T, ((reach, reach), (0, 0)), mode="edge")
        stop = fine.shape[1] - FINENESS + 1
        fine = np.zeros((fine.shape[1] // FINENESS, fine.shape[0]), dtype=np.float32)
        for tap, weight in enumerate(kernel):
            fine += weight * padded[tap : tap + stop : FINENESS]
    return fine
