"""The place of a corner of four squares: a blurred crossing of two edges fitted to the grey values round it.

In the picture grey = a + g . p + b erf(d1 / (sqrt(2) s)) erf(d2 / (sqrt(2) s)), d1, d2 the distances from the two edges
through the corner, s the blur. How edges curve (wide lenses) is known from the neighbouring corners better than from
the window, and is held: free, it would double the scatter; left out, it moves corners by several hundredths of a pixel.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.targets._boards_lattice import Lattice

Array = NDArray[np.float64]

REACH = 0.42  # of the distance to the next corner: the window stays clear of other corners
SMALLEST, LARGEST = 3.0, 10.0  # radius of a window [px]
STEPS = 12
SETTLED = 1e-4  # px
FARTHEST = 2.0  # px from where OpenCV saw the corner
BLURS = 0.3, 8.0  # px
LARGEST_STEP = 0.5  # px, rad
FIRMNESS = 1e-9  # of the trace of a normal matrix
ROOT_2 = np.sqrt(2.0)


class Corners(NamedTuple):
    """Places (n, 2) [px], NaN where there is no corner; standard uncertainty `sigma` (n,) [px] of each coordinate by
    the noise of the window; `blur` (n,) [px].
    """

    places: Array
    sigma: Array
    blur: Array


class _Windows(NamedTuple):
    """Grey values (n, m) at offsets `x`, `y` (m,) from the pixels `origin` (n, 2); `weight` (n, m) 0 or 1."""

    grey: Array
    x: Array
    y: Array
    origin: Array
    weight: Array


def measured_corners(
    image: Array, rough: Array, lattice: Lattice, *, clear: float = np.inf, shun: float = 0.0
) -> Corners:
    """Corners near the places `rough` (n, 2) [px] of `image` (h, w). `clear` [squares]: how far from a corner, along
    both edges at once, markers begin; pixels nearer than `shun` [px] to them are left out.
    """
    result = Corners(*(np.full(shape, np.nan) for shape in (rough.shape, len(rough), len(rough))))
    radius = np.clip(REACH * lattice.spacing, SMALLEST, LARGEST)
    known = np.isfinite(np.column_stack([rough, lattice.along, lattice.down])).all(axis=1)
    inside = np.all((rough >= radius[:, None]) & (rough <= np.array(image.shape[::-1]) - 1 - radius[:, None]), axis=1)
    use = np.flatnonzero(known & inside)
    if use.size == 0:
        return result
    part = Lattice(*(terms[use] for terms in lattice))
    windows = _windows(image, rough[use], radius[use], part, clear, shun)
    for whole, found in zip(result, _fitted(windows, rough[use], part), strict=True):
        whole[use] = found
    return result


def _windows(image: Array, rough: Array, radius: Array, lattice: Lattice, clear: float, shun: float) -> _Windows:
    half = int(np.ceil(radius.max()))
    y, x = (part.ravel().astype(float) for part in np.mgrid[-half : half + 1, -half : half + 1])
    origin = np.rint(rough).astype(np.intp)
    rows = np.clip(origin[:, 1, None] + y.astype(np.intp), 0, image.shape[0] - 1)
    columns = np.clip(origin[:, 0, None] + x.astype(np.intp), 0, image.shape[1] - 1)
    px, py = x + (origin - rough)[:, 0, None], y + (origin - rough)[:, 1, None]
    weight = np.hypot(px, py) <= radius[:, None]
    (ax, ay), (bx, by) = lattice.along.T, lattice.down.T
    determinant = ax * by - ay * bx
    column = (by[:, None] * px - bx[:, None] * py) / determinant[:, None]
    row = (ax[:, None] * py - ay[:, None] * px) / determinant[:, None]
    lengths = (np.linalg.norm(step, axis=1)[:, None] for step in (lattice.along, lattice.down))
    into_marker = [(np.abs(place) - clear) * length for place, length in zip((column, row), lengths, strict=True)]
    weight &= np.minimum(*into_marker) < -shun
    return _Windows(image[rows, columns].astype(float), x, y, origin.astype(float), weight.astype(float))


def _fitted(windows: _Windows, rough: Array, lattice: Lattice) -> Corners:
    """Gauss-Newton, all windows at once; parameters: place (2), directions of both edges, blur, then those that the
    grey value is linear in.
    """
    kappa = _curvature(lattice.along, lattice.along_bend), _curvature(lattice.down, lattice.down_bend)
    ways = [np.arctan2(step[:, 1], step[:, 0]) for step in (lattice.along, lattice.down)]
    start = rough - windows.origin
    theta = np.column_stack([start, *ways, np.ones(len(rough))])
    step, covariance = np.full(theta.shape, np.inf), np.zeros((len(rough), 9, 9))
    for _ in range(STEPS):
        step, covariance = _step(windows, theta, kappa)
        theta = theta + np.clip(step, -LARGEST_STEP, LARGEST_STEP)
        theta[:, 4] = np.clip(theta[:, 4], *BLURS)
        if np.hypot(step[:, 0], step[:, 1]).max() < SETTLED:
            break
    good = np.hypot(step[:, 0], step[:, 1]) < 100 * SETTLED
    good &= (np.linalg.norm(theta[:, :2] - start, axis=1) < FARTHEST) & (theta[:, 4] < BLURS[1])
    sigma = _scatter(windows, theta, kappa) * np.sqrt((covariance[:, 0, 0] + covariance[:, 1, 1]) / 2)
    places = np.where(good[:, None], theta[:, :2] + windows.origin, np.nan)
    return Corners(places, np.where(good, sigma, np.nan), np.where(good, theta[:, 4], np.nan))


def _step(windows: _Windows, theta: Array, kappa: tuple[Array, Array]) -> tuple[Array, Array]:
    """Change (n, 5) of the parameters, and the inverse (n, 9, 9) of the normal matrix."""
    shape, jacobian = _shape(windows, theta, kappa)
    linear, residual = _linear(windows, shape)
    design = np.concatenate([jacobian * linear[:, None, :1], _basis(windows, shape)], axis=2)
    weighted = design * windows.weight[:, :, None]
    inverse = np.asarray(np.linalg.inv(_firm(np.einsum("nmi,nmj->nij", weighted, design))), dtype=float)
    return np.einsum("nij,njm,nm->ni", inverse[:, :5], weighted.transpose(0, 2, 1), residual, optimize=True), inverse


def _scatter(windows: _Windows, theta: Array, kappa: tuple[Array, Array]) -> Array:
    """Standard deviation (n,) of the grey values about the fit."""
    _, residual = _linear(windows, _shape(windows, theta, kappa)[0])
    square = np.einsum("nm,nm->n", windows.weight * residual, residual)
    return np.sqrt(square / np.maximum(windows.weight.sum(axis=1) - 9, 1))


def _firm(normal: Array) -> Array:
    """A normal matrix (n, p, p) that has an inverse also where a window says nothing of a parameter."""
    return normal + np.eye(normal.shape[1]) * FIRMNESS * np.trace(normal, axis1=1, axis2=2)[:, None, None]


def _curvature(step: Array, bend: Array) -> Array:
    """How far (n,) [1/px] an edge along `step` curves towards its normal, per half square of the way along it."""
    length = np.linalg.norm(step, axis=1)
    return (step[:, 0] * bend[:, 1] - step[:, 1] * bend[:, 0]) / length**3


def _shape(windows: _Windows, theta: Array, kappa: tuple[Array, Array]) -> tuple[Array, Array]:
    """The crossing (n, m) of values -1 to 1 and its derivatives (n, m, 5)."""
    from scipy.special import erf

    x, y = windows.x - theta[:, :1], windows.y - theta[:, 1:2]
    blur = theta[:, 4:5]
    steps, slopes, distances, normals, ways = [], [], [], [], []
    for angle, curvature in zip((theta[:, 2:3], theta[:, 3:4]), kappa, strict=True):
        cosine, sine = np.cos(angle), np.sin(angle)
        along, across = cosine * x + sine * y, cosine * y - sine * x
        bent = curvature[:, None] * along
        distance = across - bent * along / 2
        steps.append(erf(distance / (ROOT_2 * blur)))
        slopes.append(2 / (ROOT_2 * np.sqrt(np.pi) * blur) * np.exp(-((distance / blur) ** 2) / 2))
        distances.append(distance)
        normals.append((sine + bent * cosine, -cosine + bent * sine))  # derivative of the distance by the place
        ways.append(-along - bent * across)  # and by the direction
    first, second = slopes[0] * steps[1], slopes[1] * steps[0]
    jacobian = [first * normals[0][i] + second * normals[1][i] for i in range(2)]
    jacobian += [first * ways[0], second * ways[1], -(first * distances[0] + second * distances[1]) / blur]
    return steps[0] * steps[1], np.stack(jacobian, axis=2)


def _basis(windows: _Windows, shape: Array) -> Array:
    """What the grey value is linear in (n, m, 4): the crossing, 1, x and y."""
    ones = np.ones_like(shape)
    return np.stack([shape, ones, windows.x * ones, windows.y * ones], axis=2)


def _linear(windows: _Windows, shape: Array) -> tuple[Array, Array]:
    """b, a, g (n, 4) for a given shape, and the residuals (n, m)."""
    basis = _basis(windows, shape)
    weighted = basis * windows.weight[:, :, None]
    normal = _firm(np.einsum("nmi,nmj->nij", weighted, basis))
    linear = np.linalg.solve(normal, np.einsum("nmi,nm->ni", weighted, windows.grey)[..., None])[..., 0]
    return linear, windows.grey - np.einsum("nmi,ni->nm", basis, linear)
