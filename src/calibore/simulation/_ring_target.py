"""A photograph of a flat target of concentric rings and spokes, through any lens, with known truth."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera
from calibore.simulation._sensor import Sensor

Array = NDArray[np.float64]

FINENESS = 3  # samples along each side of a pixel that an edge passes
SOFTNESS = 0.2  # px: edges are drawn so soft (Gaussian) that the samples carry them without aliasing; part of the blur
NEAR = 1.6  # px from an edge within which a pixel is sampled finely
BAND = 256  # rows drawn at once
REACH = 5.0  # standard deviations at which the blur ends
COLOUR = (1.0, 0.97, 0.9)  # of the lamps


@dataclass(frozen=True)
class TargetLight:
    """Light on a flat target, as fractions of full scale. `exposure`: white paper in the middle of the picture;
    `falloff` towards its corners with the square of the image radius; `gradient` from one edge of the picture to the
    opposite one, growing in the image direction `azimuth` [rad].
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


@dataclass(frozen=True, eq=False)
class PrintedRings:
    """What is printed: `radii` [m] of the rings' ink midlines, innermost first; `spokes`, the first along the target's
    x, up to the outermost ring; `ink_width` [m] of every line; reflectances of ink, paper and of the backing beyond
    `paper_radius` [m].
    """

    radii: Array
    spokes: int
    ink_width: float
    paper_radius: float
    ink: float = 0.1
    paper: float = 1.0
    backing: float = 0.2

    def __post_init__(self) -> None:
        if len(self.radii) < 1 or not np.all(np.diff(self.radii, prepend=0.0) > self.ink_width) or self.spokes < 1:
            raise InputError(
                f"A ring target needs rings further apart than their ink width of {self.ink_width:g} m, and spokes; "
                f"got radii {np.round(self.radii, 5).tolist()} m and {self.spokes} spokes."
            )


class _Places(NamedTuple):
    """Places (n,) [m] on the target's plane that samples look at, and their slopes by the pixel, each (n, 2)."""

    x: Array
    y: Array
    x_by_pixel: Array
    y_by_pixel: Array


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
    light: TargetLight | None = None,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w, 3) of a target in the plane z = 0 of its own frame, z away from the camera.

    `ring_spacing`, `ink_width`, `paper_radius` [m]; `radius_errors` [m]: printed minus stated radius of each ring.
    """
    radii = ring_spacing * np.arange(1, rings + 1) + np.asarray(radius_errors, dtype=float)
    printed = PrintedRings(radii, spokes, ink_width, paper_radius or (rings + 0.25) * ring_spacing)
    light = light or TargetLight()
    picture = np.empty((camera.height, camera.width), dtype=np.float32)
    for top in range(0, camera.height, BAND):
        bottom = min(top + BAND, camera.height)
        picture[top:bottom] = _band(camera, target_from_camera, printed, light, sensor.psf_sigma, (top, bottom))
    return sensor.read_out(picture[..., None] * np.array(COLOUR, dtype=np.float32), rng)


def _band(
    camera: Camera, pose: Pose, printed: PrintedRings, light: TargetLight, psf_sigma: float, rows: tuple[int, int]
) -> NDArray[np.float32]:
    """Blurred light of the picture's `rows` (first, end)."""
    halo = int(np.ceil(REACH * psf_sigma)) + 1
    v, u = (part.astype(float) for part in np.mgrid[rows[0] - halo : rows[1] + halo, -halo : camera.width + halo])
    offsets = (np.arange(FINENESS) - (FINENESS - 1) / 2) / FINENESS
    centres = _places(camera, pose, u, v)
    fine = np.repeat(_reflectance(printed, centres)[:, None], FINENESS**2, axis=1).astype(np.float32)
    near = np.flatnonzero(_near_an_edge(printed, centres))
    du, dv = np.tile(offsets, FINENESS), np.repeat(offsets, FINENESS)
    samples = _sampled(camera, pose, u.ravel()[near][:, None] + du, v.ravel()[near][:, None] + dv)
    slopes = (np.repeat(part[near], FINENESS**2, axis=0) for part in centres[2:])
    fine[near] = _reflectance(printed, _Places(*samples, *slopes)).reshape(near.size, FINENESS**2)
    fine *= light.at(camera, u, v).astype(np.float32).reshape(-1, 1)
    grid = fine.reshape(*u.shape, FINENESS, FINENESS).transpose(0, 2, 1, 3)
    blurred = _blurred(grid.reshape(FINENESS * u.shape[0], -1), psf_sigma)
    return blurred[halo:-halo, halo:-halo]


def _sampled(camera: Camera, pose: Pose, u: Array, v: Array) -> tuple[Array, Array]:
    """Places (n,), (n,) on the target that points of the picture look at; NaN where they look elsewhere."""
    rays = camera.unproject(u.ravel(), v.ravel())
    origin, direction = pose.apply(rays.origin), rays.direction @ pose.rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = -origin[:, 2] / direction[:, 2]
        distance = np.where(distance > 0, distance, np.nan)
    return origin[:, 0] + distance * direction[:, 0], origin[:, 1] + distance * direction[:, 1]


def _places(camera: Camera, pose: Pose, u: Array, v: Array) -> _Places:
    x, y = _sampled(camera, pose, u, v)
    slopes = [np.stack(np.gradient(part.reshape(u.shape))[::-1], axis=-1).reshape(-1, 2) for part in (x, y)]
    return _Places(x, y, *slopes)


def _ring_and_spoke(printed: PrintedRings, places: _Places) -> tuple[Array, Array, Array, Array, Array]:
    """Radius (n,); distance from the nearest ring and from the nearest spoke; target length of a pixel across each."""
    radius = np.hypot(places.x, places.y)
    cosine, sine = places.x / np.maximum(radius, 1e-12), places.y / np.maximum(radius, 1e-12)
    middles = (printed.radii[1:] + printed.radii[:-1]) / 2
    from_ring = radius - printed.radii[np.searchsorted(middles, np.nan_to_num(radius))]
    across_ring = np.hypot(*(cosine[:, None] * places.x_by_pixel + sine[:, None] * places.y_by_pixel).T)
    step = 2 * np.pi / printed.spokes
    spoke = step * np.rint(np.arctan2(places.y, places.x) / step)
    c, s = np.cos(spoke), np.sin(spoke)
    from_spoke = places.y * c - places.x * s
    across_spoke = np.hypot(*(c[:, None] * places.y_by_pixel - s[:, None] * places.x_by_pixel).T)
    return radius, from_ring, from_spoke, across_ring, across_spoke


def _near_an_edge(printed: PrintedRings, places: _Places) -> NDArray[np.bool_]:
    """Pixels with an edge of ink or paper within `NEAR`."""
    radius, from_ring, from_spoke, across_ring, across_spoke = _ring_and_spoke(printed, places)
    half = printed.ink_width / 2
    with np.errstate(invalid="ignore"):
        near = np.abs(np.abs(from_ring) - half) < NEAR * across_ring
        near |= (np.abs(np.abs(from_spoke) - half) < NEAR * across_spoke) & (radius < 1.01 * printed.radii[-1])
        return near | (np.abs(radius - printed.paper_radius) < NEAR * across_ring)


def _reflectance(printed: PrintedRings, places: _Places) -> Array:
    """Reflectance (n,) with softened edges; 0 where the samples look past the target's plane."""
    from scipy.special import ndtr

    radius, from_ring, from_spoke, across_ring, across_spoke = _ring_and_spoke(printed, places)
    half = printed.ink_width / 2

    def covered(low: Array, high: Array, pixel: Array) -> Array:
        soft = np.maximum(SOFTNESS * pixel, 1e-12)
        return ndtr(high / soft) - ndtr(low / soft)

    ring = covered(from_ring - half, from_ring + half, across_ring)
    spoke = covered(from_spoke - half, from_spoke + half, across_spoke) * (radius <= printed.radii[-1])
    paper = ndtr((printed.paper_radius - radius) / np.maximum(SOFTNESS * across_ring, 1e-12))
    bare = printed.backing + (printed.paper - printed.backing) * paper
    reflectance = bare + (printed.ink - bare) * (1 - (1 - ring) * (1 - spoke))
    return np.nan_to_num(reflectance, nan=0.0)


def _blurred(fine: NDArray[np.float32], psf_sigma: float) -> NDArray[np.float32]:
    """Pixels from samples: Gaussian blur (less the softness already there), then the pixel's area, along both axes."""
    sigma = FINENESS * np.sqrt(psf_sigma**2 - SOFTNESS**2)
    reach = FINENESS * int(np.ceil(REACH * sigma / FINENESS))
    gauss = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel = np.convolve(gauss / gauss.sum(), np.full(FINENESS, 1 / FINENESS)).astype(np.float32)
    for _ in range(2):
        padded = np.pad(fine.T, ((reach, reach), (0, 0)), mode="edge")
        count = fine.shape[1] // FINENESS
        stop = FINENESS * (count - 1) + 1
        fine = sum(weight * padded[tap : tap + stop : FINENESS] for tap, weight in enumerate(kernel))
    return fine
