"""Where a fit of ring marks begins: read off the pictures themselves."""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import LensModel, middle_of
from calibore.calibration._rings._model import RingModel, target_names
from calibore.calibration._rings._target import RingTarget
from calibore.optics import LENS_LAWS, Camera
from calibore.targets import RingMarks

Array = NDArray[np.float64]

DISTANCES = np.geomspace(0.2, 5.0, 80)
"""Over the nominal baseline: pupils lie behind the front of a lens, and people measure roughly."""
OTHERS = np.geomspace(0.05, 20.0, 240)
"""Distances of the other pictures over that of the one with most rings."""
NOISE = 0.05
"""px: a misfit of the mean radii of rings that does not matter."""
BEYOND = 1.01
"""A lens must image a little more than the farthest ring's mean radius."""
REACH = 1.5
"""k over the farthest ring's radius, where nothing better is found: every law images that."""

_Start = tuple[float, dict[str, float]]


def start_values(model: RingModel, nominal_baseline: float, *, principal_point: tuple[float, float] | None) -> Array:
    """Parameters of `model` from the mean radius of every ring in the pictures: exact for a target that stands square
    before the camera. `nominal_baseline` [m] of the first picture only says where to look.
    """
    width, height = model.size
    values = dict.fromkeys(model.names, 0.0) | {"camera.aspect": 1.0}
    point = principal_point or middle_of(width, height)
    values |= {"camera.principal_point_u": point[0], "camera.principal_point_v": point[1]}
    seen = [ring_radii(marks, model.printed.radii) for marks in model.marks]
    best = max(range(len(seen)), key=lambda i: seen[i][0].size)
    baseline, lens = _lens(model.lens, *seen[best], nominal_baseline, height / 2)
    values |= lens
    camera = model.camera(np.array([values[name] for name in model.names]))
    for number, marks in enumerate(model.marks):
        distance = baseline if number == best else _distance(camera, *seen[number], baseline)
        target = _target(camera, marks, distance, model.printed.spokes)
        places = [getattr(target, name) for name in RingTarget.parameter_names]
        values |= dict(zip(target_names(number), places, strict=True))
    return np.array([values[name] for name in model.names])


def ring_radii(marks: RingMarks, printed: Array) -> tuple[Array, Array]:
    """Printed radii [m] of the rings found, and their mean radii in the picture [px] about the centre of the spokes."""
    found = np.unique(marks.ring[marks.ring > 0])
    away = np.hypot(marks.u - marks.centre[0], marks.v - marks.centre[1])
    return printed[found - 1], np.array([away[marks.ring == ring].mean() for ring in found])


def _lens(lens: LensModel, printed: Array, image: Array, nominal: float, half_height: float) -> _Start:
    """Distance [m] and lens parameters that fit best, of those that image all that is seen: for a given distance they
    are found by linear least squares. Where distances hardly differ, the nominal one is preferred.
    """
    starts = [_linear(lens, np.arctan(printed / nominal / far), image, half_height) for far in DISTANCES]
    doubt = (NOISE * np.log(DISTANCES) / np.log(2)) ** 2
    for number in np.argsort([cost for cost, _ in starts] + doubt):
        values = starts[number][1]
        if _images(lens, values, image.max() * BEYOND, half_height):
            return float(nominal * DISTANCES[number]), values
    best = int(np.argmin([cost for cost, _ in starts]))
    return float(nominal * DISTANCES[best]), {"camera.k": REACH * image.max()}


def _linear(lens: LensModel, zenith: Array, image: Array, half_height: float) -> tuple[float, dict[str, float]]:
    """Mean square [px^2] and parameters of the lens for known zeniths: r = k f + k c1 (k / h)^2 f^3 + ..., or
    k zenith + k p3 zenith^3 + ...
    """
    ratio = zenith if lens.law == "polynomial" else LENS_LAWS[lens.law].ratio(zenith)
    matrix = np.stack([ratio ** (1 + 2 * power) for power in range(len(lens.parameters))], axis=1)
    solution = np.linalg.lstsq(matrix, image, rcond=None)[0]
    k = float(solution[0])
    unit = 1.0 if lens.law == "polynomial" else (k / half_height) ** 2
    extras = [float(value / k / unit**power) for power, value in enumerate(solution[1:], start=1)]
    return float(np.mean((matrix @ solution - image) ** 2)), dict(zip(lens.parameters, [k, *extras], strict=True))


def _images(lens: LensModel, values: dict[str, float], radius: float, half_height: float) -> bool:
    """Whether a lens with these values images anything at `radius` [px]."""
    if values["camera.k"] <= 0:
        return False
    camera = lens.camera(values, width=int(2 * half_height), height=int(2 * half_height))
    return bool(np.isfinite(camera.lens.zenith(np.array([radius]))).all())


def _distance(camera: Camera, printed: Array, image: Array, baseline: float) -> float:
    """How far [m] a target stands that a known camera sees so."""
    distances = baseline * OTHERS
    predicted = camera.lens.image_radius(np.arctan(printed / distances[:, None]))
    misfit = np.nansum((predicted - image) ** 2, axis=1) + np.where(np.isnan(predicted).any(axis=1), np.inf, 0.0)
    return float(distances[np.argmin(misfit)])


def _target(camera: Camera, marks: RingMarks, distance: float, spokes: int) -> RingTarget:
    direction = camera.unproject(np.array([marks.centre[0]]), np.array([marks.centre[1]])).direction[0]
    x, y = direction[:2] * distance / direction[2]
    on_spoke = marks.ring == 0
    azimuth = np.arctan2(marks.v[on_spoke] - marks.centre[1], marks.u[on_spoke] - marks.centre[0])
    turned = azimuth - marks.spoke[on_spoke] * (2 * np.pi / spokes)
    roll = float(np.angle(np.exp(1j * turned).sum())) if turned.size else 0.0
    return RingTarget(distance, 0.0, 0.0, float(x), float(y), roll)
