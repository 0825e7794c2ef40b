"""The place of a corner of four squares: a blurred crossing of two edges fitted to the grey values round it.

In the picture grey = a + g . p + b erf(d1 / (sqrt(2) s)) erf(d2 / (sqrt(2) s)), d1, d2 the distances from the two edges
through the corner, s the blur. How edges curve (wide lenses) is known from the neighbouring corners better than from the
window, and is held: free, it would double the scatter; left out, it moves corners by up to 0.1 px.
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
ROOT_2 = np.sqrt(2.0)


class Corners(NamedTuple):
    """Places (n, 2) [px], NaN where there is no corner; standard uncertainty `sigma` (n,) [px] of each coordinate by the
    noise of the window; `blur` (n,) [px].
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
    """Corners near the places `rough` (n, 2) [px] of `image` (h, w). `clear` [squares]: how far from a corner, along both
    edges at once, markers begin; pixels nearer than `shun` [px] to them are left out.
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
    places, sigma, blur = _fitted(windows, rough[use], part)
    result.places[use], result.sigma[use], result.blur[use] = places, sigma, blur
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


def _fitted(windows: _Windows, rough: Array, lattice: Lattice) -> tuple[Array, Array, Array]:
    """Gauss-Newton, all windows at once; parameters: place (2), directions of two edges, blur, b, a, g (2)."""
    n = len(rough)
    kappa = [_curvature(lattice.along, lattice.along_bend), _curvature(lattice.down, lattice.down_bend)]
    theta = np.zeros((n, 5))
    theta[:, :2] = rough - windows.origin
    theta[:, 2] = np.arctan2(lattice.along[:, 1], lattice.along[:, 0])
    theta[:, 3] = np.arctan2(lattice.down[:, 1], lattice.down[:, 0])
    theta[:, 4] = 1.0
    start = theta.copy()
    shape, jacobian = _shape(windows, theta, kappa)
    settled = np.zeros(n, dtype=bool)
    step, normal, scatter = np.zeros((n, 5)), np.zeros((n, 9, 9)), np.zeros(n)
    for _ in range(STEPS):
        linear, residual = _linear(windows, shape)
        design = np.concatenate([jacobian * linear[:, None, :1], _basis(windows, shape)], axis=2)
        weighted = design * windows.weight[:, :, None]
        normal = np.einsum("nmi,nmj->nij", weighted, design)
        normal += np.eye(9) * 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None]
        step = np.linalg.solve(normal, np.einsum("nmi,nm->ni", weighted, residual)[..., None])[..., 0][:, :5]
        theta = theta + np.clip(step, -0.5, 0.5)
        theta[:, 4] = np.clip(theta[:, 4], *BLURS)
        shape, jacobian = _shape(windows, theta, kappa)
        settled = np.hypot(step[:, 0], step[:, 1]) < SETTLED
        if settled.all():
            break
    _, residual = _linear(windows, shape)
    freedom = np.maximum(windows.weight.sum(axis=1) - 9, 1)
    scatter = np.einsum("nm,nm->n", windows.weight * residual, residual) / freedom
    covariance = np.linalg.inv(normal)
    sigma = np.sqrt(scatter * (covariance[:, 0, 0] + covariance[:, 1, 1]) / 2)
    moved = np.linalg.norm(theta[:, :2] - start[:, :2], axis=1)
    good = (np.hypot(step[:, 0], step[:, 1]) < 100 * SETTLED) & (moved < FARTHEST) & (theta[:, 4] < BLURS[1])
    places = np.where(good[:, None], theta[:, :2] + windows.origin, np.nan)
    return places, np.where(good, sigma, np.nan), np.where(good, theta[:, 4], np.nan)


def _curvature(step: Array, bend: Array) -> Array:
    """How far (n,) [1/px] an edge along `step` curves towards its normal, per half square of the way along it."""
    length = np.linalg.norm(step, axis=1)
    return (step[:, 0] * bend[:, 1] - step[:, 1] * bend[:, 0]) / length**3


def _shape(windows: _Windows, theta: Array, kappa: list[Array]) -> tuple[Array, Array]:
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
    normal = np.einsum("nmi,nmj->nij", weighted, basis)
    normal += np.eye(4) * 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None]
    linear = np.linalg.solve(normal, np.einsum("nmi,nm->ni", weighted, windows.grey)[..., None])[..., 0]
    return linear, windows.grey - np.einsum("nmi,ni->nm", basis, linear)
