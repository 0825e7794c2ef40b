"""Where the search for an unknown lens starts: for each law k is tried, and every board's pose follows from its rays.

With the unit ray d of a mark and its place X = (x, y, 1) on the board, d x (H X) = 0; H = (r1 r2 t) up to its scale.
That is linear in H and holds for rays of any zenith, also beyond 90 deg.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._bundle import Estimate, bundle, camera_of, parameter_names
from calibore.calibration._boards._data import BoardData, rotation_vectors
from calibore.calibration._lens_models import CENTRE, LensModel, middle_of
from calibore.errors import InputError
from calibore.optics import LENS_LAWS, Camera

Array = NDArray[np.float64]

NARROWEST = np.radians(3.0)
WIDEST = {"perspective": 80.0, "sine-law": 88.0}  # zenith [deg] that is tried for the outermost mark
WIDEST_ELSE = 150.0
TRIALS = 28
POLISHED = 2  # best values of k per law that are followed up
SAMPLE = 18  # marks of a board that are tried
ROUGH = 6  # steps with some parameters held
SETTLED = 1e-5  # of the sum of squares: near enough for a start


def first_estimates(data: BoardData, models: tuple[LensModel, ...]) -> list[Estimate]:
    """For each law among `models`, an estimate with all parameters free; none of those that image no such boards."""
    laws = dict.fromkeys(model.law if model.law in LENS_LAWS else "equidistant" for model in models)
    found = [_law_estimate(data, LensModel(law)) for law in laws]
    return [estimate for estimate in found if estimate is not None]


def _law_estimate(data: BoardData, model: LensModel) -> Estimate | None:
    radius = float(np.hypot(*(data.pixel - middle_of(*data.size)).T).max())
    widest = np.radians(WIDEST.get(model.law, WIDEST_ELSE))
    trials = radius / LENS_LAWS[model.law].ratio(np.geomspace(NARROWEST, widest, TRIALS))
    some = data.only(_sample(data))
    rated = [found for k in trials if (found := _trial(some, model, float(k))) is not None]
    rated.sort(key=lambda found: found[0])
    if not rated:
        return None
    narrow = [bundle(some, start, free=("camera.k",), robust=True, steps=ROUGH) for _, start in rated[:POLISHED]]
    best = min(narrow, key=lambda estimate: float(np.median(estimate.square)))
    centred = bundle(data, best, free=("camera.k", *CENTRE), robust=True, steps=ROUGH)
    return bundle(data, centred, robust=True, settled=SETTLED)


def _sample(data: BoardData) -> NDArray[np.bool_]:
    """About `SAMPLE` of each board's marks (n,), anywhere on it."""
    share = SAMPLE / data.sums(np.ones(data.owner.size))[data.owner]
    return np.random.default_rng(0).random(data.owner.size) < np.where(share > 0.5, 1.0, share)


def _trial(data: BoardData, model: LensModel, k: float) -> tuple[float, Estimate] | None:
    """Median square of the residuals with this k, the poses from the rays alone; None where marks have no ray."""
    values = np.array([k, 1.0, *middle_of(*data.size)])
    camera = camera_of(model, values, data.size)
    poses = poses_from_rays(data, camera)
    if poses is None:
        return None
    pixel = np.stack(camera.project(data.points(poses)[0]), axis=1)
    if not np.isfinite(pixel).all():
        return None
    estimate = Estimate(model, values, poses, data.pixel - pixel, data.size)
    return float(np.median(data.sums(estimate.square) / data.sums(np.ones(len(pixel))))), estimate


def poses_from_rays(data: BoardData, camera: Camera) -> Array | None:
    """Poses (m, 6) of all boards from the rays of their marks; None where a mark has no ray."""
    ray = camera.unproject(*data.pixel.T).direction
    if not np.isfinite(ray).all():
        return None
    scale = float(np.abs(data.place).max())
    place = np.column_stack([data.place[:, :2] / scale, np.ones(len(ray))])
    across = np.eye(3) - ray[:, :, None] * ray[:, None, :]
    normal = data.sums(np.einsum("nij,nk,nl->nikjl", across, place, place).reshape(-1, 9, 9))
    columns = np.linalg.eigh(normal)[1][:, :, 0].reshape(-1, 3, 3)  # board's direction i, coordinate k
    ahead = data.sums(np.einsum("ni,nij,nj->n", ray, columns[data.owner], place)) > 0
    columns = np.where(ahead, 1.0, -1.0)[:, None, None] * columns
    columns = columns * np.array([1 / scale, 1 / scale, 1.0])
    size = np.linalg.norm(columns[:, :, :2], axis=1).mean(axis=1)
    left, _, right = np.linalg.svd(columns[:, :, :2], full_matrices=False)
    axes = left @ right
    rotation = np.concatenate([axes, np.cross(axes[:, :, 0], axes[:, :, 1])[:, :, None]], axis=2)
    return np.column_stack([rotation_vectors(rotation), columns[:, :, 2] / size[:, None]])


def started_like(model: LensModel, estimate: Estimate) -> Estimate:
    """`model` with the parameters that make it most like the camera of `estimate` over the marks it images."""
    camera = estimate.camera
    values = dict(zip(estimate.names, estimate.values, strict=True))
    if model.law == "polynomial":
        radius = np.hypot(*_corners(camera).T).max()
        widest = np.nanmax(camera.lens.zenith(np.linspace(0, radius, 200)))
        zenith = np.linspace(0.02, 1.0, 80) * min(widest, 0.98 * camera.lens.max_zenith)
        powers = zenith[:, None] ** np.arange(1, 2 * len(model.extras) + 2, 2)
        terms, *_ = np.linalg.lstsq(powers, camera.lens.image_radius(zenith), rcond=None)
        values |= {"camera.k": terms[0]} | dict(zip(model.parameters[1:], terms[1:] / terms[0], strict=True))
    elif model.law != estimate.model.law:
        raise InputError(f"{model.name} is started from its own law.")
    vector = np.array([values.get(name, 0.0) for name in parameter_names(model)])
    return Estimate(model, vector, estimate.poses, estimate.residual, estimate.size, estimate.bends)


def _corners(camera: Camera) -> Array:
    """Corners of the picture (4, 2) from the principal point, in units of u [px]."""
    u, v = np.array([-0.5, camera.width - 0.5]), np.array([-0.5, camera.height - 0.5])
    x, y = u - camera.principal_point[0], (v - camera.principal_point[1]) / camera.aspect
    return np.array([(a, b) for a in x for b in y])
