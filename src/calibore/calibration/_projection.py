"""How uncertain the direction behind a pixel is, in pixels: what a covariance of camera parameters means in the image.

With the ray d(q; p) of pixel q, the pixel that sees a fixed direction moves by dq = -(dd/dq)^+ dd/dp dp. A turn r of
the whole camera moves all of them by (dd/dq)^+ (r x d); no picture of a free target, and no pipe whose axis is not
known beforehand, can tell such a turn from a change of the parameters. So the turn that fits dq best over the image is
taken out, as mrcal does ("implied rotation").
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import ValidRegion
from calibore.uncertainty import Covariance

Array = NDArray[Any]
ROWS = 24
"""Of the even grid of pixels over which turns are fitted and differences averaged."""
EVENING = 0.1
"""Of the rms over the image: pixels better known than that weigh no more, lest a few of them fix the turn."""


class ProjectionUncertainty(NamedTuple):
    """Of n pixels: `sd` (n,) [px], in the direction in which it is largest; `covariance` (n, 2, 2) [px^2] of (u, v)."""

    sd: Array
    covariance: Array


def projection_uncertainty(
    camera: Camera,
    covariance: Covariance,
    u: ArrayLike,
    v: ArrayLike,
    *,
    keep_rotation: bool = False,
    valid: ValidRegion | None = None,
) -> ProjectionUncertainty:
    """Of the directions behind pixels `u`, `v` (n,), from the part of `covariance` that concerns the camera.

    The implied turn is the weighted best fit over an even grid of pixels (within `valid` zeniths): weights are inverse
    variances of what remains after an unweighted fit. `keep_rotation`: nothing is taken out, for a camera whose frame
    is known by other means. NaN where the lens sees nothing. A walking pupil's origin is not part of a direction; what
    it does on the wall, `wall_uncertainty` says.
    """
    modes, turns = projection_modes(camera, covariance, u, v)
    if not keep_rotation:
        grid = projection_modes(camera, covariance, *image_grid(camera, valid=valid))
        modes = modes + turns @ implied_turns(*grid).turns
    return uncertainty_of(modes)


def uncertainty_of(modes: Array) -> ProjectionUncertainty:
    """Of `modes` (n, 2, m) [px] with unit variance each."""
    covariance = modes @ modes.transpose(0, 2, 1)
    a, b, c = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    return ProjectionUncertainty(np.sqrt((a + c) / 2 + np.hypot((a - c) / 2, b)), covariance)


def projection_modes(camera: Camera, covariance: Covariance, u: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
    """Motions [px] of fixed directions in the image: (n, 2, m) by unit draws of the covariance, (n, 2, 3) by turns
    [rad] of the scene about the camera's axes.
    """
    by_parameters, turns = projection_slopes(camera, u, v)
    names = [name for name in covariance.names if name in camera.parameter_names]
    columns = [camera.parameter_names.index(name) for name in names]
    return by_parameters[:, :, columns] @ covariance.restricted(names).factor(), turns


def projection_slopes(camera: Camera, u: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
    """The same by the camera's parameters (n, 2, p), and by turns (n, 2, 3)."""
    rays = camera.unproject_with_sensitivities(np.atleast_1d(u), np.atleast_1d(v))
    by_pixel = rays.direction_by_pixel
    gram = by_pixel.transpose(0, 2, 1) @ by_pixel
    (a, b), (_, c) = gram[:, 0].T, gram[:, 1].T
    adjugate = np.stack([np.stack([c, -b], -1), np.stack([-b, a], -1)], 1)
    inverse = adjugate / (a * c - b * b)[:, None, None] @ by_pixel.transpose(0, 2, 1)
    x, y, z = rays.direction.T
    zero = np.zeros_like(x)
    turned = np.stack([np.stack([zero, z, -y], -1), np.stack([-z, zero, x], -1), np.stack([y, -x, zero], -1)], 1)
    return -inverse @ rays.direction_by_parameters, inverse @ turned


class Implied(NamedTuple):
    """`turns` (3, m) [rad] that take out what a turn can of each of m motions; `weights` (n,) [1/px^2] of the fit."""

    turns: Array
    weights: Array


def implied_turns(modes: Array, turns: Array) -> Implied:
    """Best over the n pixels of `modes` (n, 2, m) [px] and `turns` (n, 2, 3) [px/rad], in two rounds: even weights,
    then those of what remained.
    """
    even = turns_against(modes, turns, np.ones(len(modes)))
    variance = ((modes + turns @ even) ** 2).sum(axis=(1, 2)) / 2
    floor = EVENING**2 * variance.mean()
    weights = 1 / np.maximum(variance, floor) if floor > 0 else np.ones(len(modes))
    return Implied(turns_against(modes, turns, weights), weights)


def turns_against(modes: Array, turns: Array, weights: Array) -> Array:
    """(3, m) [rad]: least squares of modes + turns @ result with `weights` (n,)."""
    weighted = turns * weights[:, None, None]
    normal = np.einsum("nki,nkj->ij", weighted, turns)
    return -np.linalg.solve(normal, np.einsum("nki,nkm->im", weighted, modes))


def image_grid(camera: Camera, *, rows: int = ROWS, valid: ValidRegion | None = None) -> tuple[Array, Array]:
    """Pixels u, v (n,) of an even grid over the image, where the lens sees and, if given, the zenith is `valid`."""
    rows = min(rows, camera.height)
    step = camera.height / rows
    columns = max(1, round(camera.width / step))
    u = (np.arange(columns) + 0.5) * (camera.width / columns) - 0.5
    u, v = (a.ravel() for a in np.meshgrid(u, (np.arange(rows) + 0.5) * step - 0.5))
    direction = camera.unproject(u, v).direction
    seen = np.isfinite(direction[:, 2])
    if valid is not None and valid.zenith is not None:
        zenith = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])
        seen &= (zenith >= valid.zenith[0]) & (zenith <= valid.zenith[1])
    if seen.sum() < 3:
        raise InputError(
            "Fewer than 3 of the image's pixels lie in the valid region, too few to judge the camera by; check the "
            "limits of the zenith against its lens."
        )
    return u[seen], v[seen]
