"""When a line that sweeps over the wall passes over a place of it (Curless and Levoy 1995; Swanbom 2007, 2.3.5).

In one picture the profile across the line is cut off by edges and changed by dirt narrower than the line. The light
that one place of the wall returns while the line sweeps over it is not: whatever lies beside the place, it rises and
falls as the light does, scaled by what the place returns.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._estimators import SATURATED_FROM
from calibore.stripe._features import freed_of_features
from calibore.stripe._noise import NoiseModel
from calibore.stripe._picture import prepare
from calibore.stripe._scatter import observe_scatter
from calibore.stripe._stripe import Stripe

Array = NDArray[np.float64]
STEPS = 4
"""Gauss-Newton steps; the first guess is the moment at which one picture shows the line there."""
LONGEST_STEP = 1.0
"""Line widths by which one step may move a passage."""
FARTHEST = 2.0
"""Line widths between the first guess and the passage beyond which it belongs to another place."""
BY_CHANCE = 2.0
"""Standard deviations by which chi-square may exceed its mean before samples miss the Gaussian by more than noise."""
LOST = 2 * FARTHEST
"""Line widths beyond which a search that leads nowhere is not followed."""
WHITEST = 65535.0
"""Grey values; no passage is higher."""
UNKNOWNS = 3
"""Amplitude, moment and background."""
FEWEST = UNKNOWNS + 2
"""Samples that fix them with something left over."""
SINGULAR, LEAST = 1e-9, 1e-60
"""Least determinant of the scaled normal matrix at which the samples fix a moment, and least of its diagonal before."""
TAPS = 6
"""Pixels in each direction from which brightness is interpolated."""
FAINTEST = 3.0
"""Standard uncertainties that the amplitude of a passage must have."""


@dataclass(frozen=True)
class Passage:
    """When the line passed over n places: `moment` and its standard uncertainty `u` in the unit of the moments of the
    pictures, from their noise alone; `height` [grey values]. NaN where the samples do not tell.
    """

    moment: Array
    u: Array
    height: Array


def brightness_at(image: NDArray[np.generic], u: Array, v: Array, *, channel: str) -> Array:
    """Brightness (n,) [grey values] of `image` at columns `u` and rows `v` (n,); NaN nearer than `TAPS` / 2 px to its
    edge and where it is saturated.

    Between pixels by Lanczos interpolation: a place wanders across pixels while the light passes, and interpolation
    that blurs more half-way between them (bilinear: a line of 1.2 px by a tenth of its height) would shift the passage.
    """
    picture = prepare(image, channel)
    plane = picture.plane()
    height, width = plane.shape
    left, top = np.floor(u), np.floor(v)
    low, high = TAPS // 2 - 1, TAPS // 2
    inside = (left >= low) & (left < width - high) & (top >= low) & (top < height - high)
    reach = np.arange(-low, high + 1)
    column, row = (np.where(inside, at, low).astype(np.intp)[:, None] + reach for at in (left, top))
    values = plane[row[:, :, None], column[:, None, :]].astype(np.float64)
    across, down = (
        _lanczos(np.where(inside, at - whole, 0.0)[:, None] - reach.astype(np.float64))
        for at, whole in ((u, left), (v, top))
    )
    mixed = np.einsum("nji,ni,nj->n", values, across, down)
    white = SATURATED_FROM * picture.white
    return np.where(inside & (values.max(axis=(1, 2)) < white), mixed, np.nan)


def _lanczos(distance: Array) -> Array:
    """Weights (n, taps) of samples at `distance` [px], normalised."""
    weight = np.sinc(distance) * np.sinc(distance / (TAPS // 2))
    return weight / weight.sum(axis=1, keepdims=True)


def passages(samples: Sequence[Array], moments: Array, *, width: Array, noise: NoiseModel) -> Passage:
    """The passages over n places from `samples`, one (n,) [grey values] for each of the m pictures at `moments` (m, n),
    which count from the first guess; `width` (n,): standard deviation of a passage, in the unit of the moments.

    Weighted least squares of a Gaussian of that width on a background, weights 1 / V(brightness) of `noise`; where the
    samples miss it by more than their noise, `u` grows by as much.
    """
    y, t = np.stack(samples), moments / width
    known = np.isfinite(y)
    freedom = np.maximum(known.sum(axis=0) - UNKNOWNS, 1)
    y, weight = np.where(known, y, 0.0), known.astype(np.float64)
    moment, height, u, step, misfit = (np.zeros(width.shape) for _ in range(5))
    for _ in range(STEPS + 1):
        shape = np.exp(-0.5 * (t - moment) ** 2)
        height, background = (np.clip(np.nan_to_num(level), -WHITEST, WHITEST) for level in _level(y, shape, weight))
        line = np.maximum(height, 0.0) * shape
        weight = np.where(known, 1 / noise.variance(line), 0.0)
        rest = y - background - height * shape
        step, u = _step(rest, shape, height * shape * (t - moment), weight)
        misfit = np.sum(weight * rest**2, axis=0) / (freedom + BY_CHANCE * np.sqrt(2 * freedom))
        moment = np.clip(moment + np.clip(np.nan_to_num(step), -LONGEST_STEP, LONGEST_STEP), -LOST, LOST)
    told = (known.sum(axis=0) >= FEWEST) & (np.abs(moment) < FARTHEST) & (np.abs(step) < 0.1) & (height > 0)
    told &= height > FAINTEST * np.sqrt(noise.additive)
    blank = np.where(told, 0.0, np.nan)
    return Passage(moment * width + blank, u * np.sqrt(np.maximum(misfit, 1.0)) * width + blank, height + blank)


def _level(y: Array, shape: Array, weight: Array) -> tuple[Array, Array]:
    """Height and background (n,) of a known `shape` (m, n), by weighted least squares."""
    ss, s, one = (np.sum(weight * part, axis=0) for part in (shape * shape, shape, np.ones_like(shape)))
    sy, oney = np.sum(weight * shape * y, axis=0), np.sum(weight * y, axis=0)
    determinant = ss * one - s * s
    with np.errstate(divide="ignore", invalid="ignore"):
        return (one * sy - s * oney) / determinant, (ss * oney - s * sy) / determinant


def _step(rest: Array, shape: Array, slope: Array, weight: Array) -> tuple[Array, Array]:
    """Gauss-Newton step (n,) of the moment and its standard uncertainty, amplitude and background free."""
    jacobian = np.stack([shape, slope, np.ones_like(shape)], axis=2)
    normal = np.einsum("mna,mn,mnb->nab", jacobian, weight, jacobian)
    target = np.einsum("mna,mn,mn->na", jacobian, weight, rest)
    scale = np.sqrt(np.maximum(np.einsum("naa->na", normal), LEAST))
    scaled = normal / (scale[:, :, None] * scale[:, None, :])
    fixed = np.abs(np.linalg.det(scaled)) > SINGULAR
    inverse = np.full(normal.shape, np.nan)
    inverse[fixed] = np.linalg.inv(scaled[fixed]) / (scale[:, :, None] * scale[:, None, :])[fixed]
    return np.einsum("na,na->n", inverse[:, 1], target), np.sqrt(inverse[:, 1, 1])


def replaced(stripe: Stripe, u: Array, v: Array, u_position: Array) -> Stripe:
    """The line of `stripe` with other places `u`, `v` [px] and their modelled `u_position` [px], (n,) each, where these
    are not NaN; how they scatter about their neighbours says again how well they are known.
    """
    told = np.isfinite(u_position) & stripe.found
    column, row = np.where(told, u, stripe.u), np.where(told, v, stripe.v)
    modelled = np.where(told, u_position, stripe.u_position)
    start = stripe.centre or (0.0, 0.0)
    position = np.einsum("nk,nk->n", np.stack([column - start[0], row - start[1]], axis=1), stripe.direction)
    closed, width = stripe.centre is not None, stripe.noise.width
    spacing = 2 * np.pi * float(np.nanmedian(position)) / position.size if closed else 1.0
    scatter = observe_scatter(position, modelled, width=width, spacing=spacing, closed=closed)
    scaled = modelled * scatter.scale
    first = replace(stripe, u=column, v=row, u_position=scaled, scale=scatter.scale, correlation=scatter.correlation)
    return freed_of_features(first)
