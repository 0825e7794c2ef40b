"""Wall points by Monte Carlo (JCGM 101): pixel noise and rig drawn at random, near frontiers too."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore._native import draw_points
from calibore.errors import InputError
from calibore.kernels import DEFAULT_KERNEL
from calibore.rigs import _engine as native
from calibore.rigs._arguments import check_choice, check_noise, pixels_of
from calibore.rigs._measuring import choice_of
from calibore.rigs._moving import moved
from calibore.rigs._rig import Rig
from calibore.rigs._triangulation import triangulate
from calibore.uncertainty import Covariance, shortest_interval, symmetric_interval

Array = NDArray[np.float64]
SUMMARY = 16
FEWEST = 2
PROBABILITY = 0.95


@dataclass(frozen=True, eq=False)
class DrawnQuantity:
    """One coordinate of n points [m]: `mean`, standard uncertainty `u`, `median` (n,); `symmetric` and `shortest`
    coverage interval (n, 2).
    """

    mean: Array
    u: Array
    median: Array
    symmetric: Array
    shortest: Array


@dataclass(frozen=True, eq=False)
class Drawn:
    """n wall points by `draws` draws, of those draws in which the pixel meets the wall; NaN where too few do.

    `covariance` (n,) [m^2] of radius and axial; `lost` (n,) fraction of draws without a meeting; `branch` (n,) of the
    meetings. `radius_draws`, `axial_draws` (n, draws) [m], NaN where lost, empty unless kept: the same column is the
    same rig, so they tell the covariance between points.
    """

    radius: DrawnQuantity
    axial: DrawnQuantity
    covariance: Array
    lost: Array
    branch: NDArray[np.intp]
    draws: int
    probability: float | None
    radius_draws: Array
    axial_draws: Array


class Pixels(NamedTuple):
    """n pixels, their `noise` [px], (1,) or (n,), and its direction, u and v apart."""

    u: Array
    v: Array
    noise: Array
    direction: tuple[Array, Array] | None

    def scattered(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """One draw of u and v."""
        along = rng.standard_normal(self.u.size) * self.noise
        if self.direction is None:
            return self.u + along, self.v + rng.standard_normal(self.u.size) * self.noise
        return self.u + along * self.direction[0], self.v + along * self.direction[1]


def monte_carlo(
    rig: Rig,
    u: ArrayLike,
    v: ArrayLike,
    *,
    u_pixel: ArrayLike,
    draws: int,
    rng: np.random.Generator,
    laser: int = 0,
    prior_radius: ArrayLike | None = None,
    branch: ArrayLike | None = None,
    direction: ArrayLike | None = None,
    probability: float | None = PROBABILITY,
    keep: bool = False,
    kernel: str = DEFAULT_KERNEL,
    threads: int | None = None,
) -> Drawn:
    """Wall points of the pixels `u`, `v` (n,) when the rig is drawn from its covariance, the same rig for all pixels of
    one draw, and the pixels from normal distributions.

    `u_pixel`, `direction`, `prior_radius`, `branch`: see `measure`. Every draw keeps to the meeting, near or far, that
    counts without noise. A draw is lost where there is no meeting ahead; a grazing one counts. `probability` None
    leaves intervals and median out. The same `rng` gives the same bytes, whatever the `threads`.
    """
    check_choice(rig, laser, prior_radius, branch)
    u, v = (np.ascontiguousarray(a, dtype=float) for a in np.broadcast_arrays(*pixels_of(u, v)))
    if draws < FEWEST:
        raise InputError(f"Monte Carlo needs at least {FEWEST} draws, got {draws}; some 10 000 tell u within 1 %.")
    pixels = Pixels(u, v, native.each(u_pixel, u.size, what="u_pixel"), native.columns(direction, u.size))
    check_noise(pixels.noise, probability)
    branches = _branches(rig, u, v, laser=laser, prior_radius=prior_radius, branch=branch)
    covariance = rig.covariance or Covariance.independent({})
    seed, shifts = int(rng.integers(2**63)), covariance.draw(rng, draws)
    if native.computes(kernel, rig, laser):
        room = 2 * u.size * draws if keep else 0
        rows, kept = np.empty((u.size, SUMMARY)), np.empty(room)
        draw_points(
            native.make_of(rig, laser, varied=covariance.names),
            native.values_of(rig, laser),
            _rigs(rig, laser, covariance.names, shifts),
            *(u, v, branches.astype(float), pixels.noise, pixels.direction),
            *(seed, probability, threads or 0, rows, kept),
        )
        radii, axials = kept.reshape(u.size, 2, -1 if room else 0).transpose(1, 0, 2)
    else:
        radii, axials = _drawn(rig, pixels, branches, laser, shifts, np.random.default_rng(seed))
        rows = np.array([_summary(*pair, probability) for pair in zip(radii, axials, strict=True)])
        rows = rows.reshape(u.size, SUMMARY)
    radius, axial, lost = _quantity(rows, 0), _quantity(rows, 1), 1 - rows[:, 5] / draws
    if not keep:
        radii = axials = np.empty((u.size, 0))
    return Drawn(radius, axial, rows[:, 4], lost, branches, draws, probability, radii, axials)


def _branches(
    rig: Rig, u: Array, v: Array, *, laser: int, prior_radius: ArrayLike | None, branch: ArrayLike | None
) -> NDArray[np.intp]:
    numbered, choice = choice_of(rig, u.size, laser=laser, prior_radius=prior_radius, branch=branch)
    if numbered:
        return np.broadcast_to(choice.astype(np.intp), u.shape).copy()
    return triangulate(rig, u, v, laser=laser, prior_radius=choice).branch


def _rigs(rig: Rig, laser: int, names: tuple[str, ...], shifts: Array) -> Array:
    """(draws, p) values of the engine's parameters in every draw."""
    wanted = native.names_of(rig, laser)
    rigs = np.tile(native.values_of(rig, laser), (len(shifts), 1))
    for column, name in enumerate(names):
        if name in wanted:
            rigs[:, wanted.index(name)] += shifts[:, column]
    return rigs


def _drawn(
    rig: Rig, pixels: Pixels, branch: NDArray[np.intp], laser: int, shifts: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """(n, draws) radius and axial, by `meet` of every drawn rig."""
    names = rig.covariance.names if rig.covariance else ()
    radii, axials = np.full((2, pixels.u.size, len(shifts)), np.nan)
    for number, shift in enumerate(shifts):
        u, v = pixels.scattered(rng)
        try:
            other = moved(rig, dict(zip(names, shift.tolist(), strict=True)))
        except InputError:  # no such rig: lost
            continue
        points = points_on(other, u, v, laser, branch)
        radii[:, number], axials[:, number] = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
    return radii, axials


def points_on(rig: Rig, u: Array, v: Array, laser: int, branch: NDArray[np.intp]) -> Array:
    """(n, 3) where the rays meet the laser on `branch`, grazing or not; NaN where they do not, or behind the camera."""
    rays = rig.mount.place(rig.camera.unproject(u, v))
    meetings = rig.lasers[laser].surface.meet(rays.origin, rays.direction)
    distance = meetings.distance[branch, np.arange(u.size)]
    ahead = (meetings.flags[branch, np.arange(u.size)] != 0) & np.isfinite(distance) & (distance > 0)
    return rays.origin + np.where(ahead, distance, np.nan)[:, None] * rays.direction


def _summary(radius: Array, axial: Array, probability: float | None) -> Array:
    """The numbers of one pixel, as the engine gives them."""
    here = np.isfinite(radius)
    summary, both, count = np.full(SUMMARY, np.nan), np.stack([radius[here], axial[here]]), int(here.sum())
    summary[5] = count
    if count:
        summary[:2] = both.mean(axis=1)
    if count >= FEWEST:
        (summary[2], summary[4]), (_, summary[3]) = np.cov(both)
    if count and probability is not None:
        inside = round(probability * count)
        for i, values in enumerate(both):
            shortest = shortest_interval(values, probability) if 0 < inside < count else (np.nan, np.nan)
            summary[6 + 5 * i : 11 + 5 * i] = *symmetric_interval(values, probability), np.median(values), *shortest
    return summary


def _quantity(rows: Array, i: int) -> DrawnQuantity:
    low, high, median, *shortest = rows[:, 6 + 5 * i : 11 + 5 * i].T
    return DrawnQuantity(
        rows[:, i], np.sqrt(rows[:, 2 + i]), median, np.stack([low, high], axis=1), np.stack(shortest, axis=1)
    )
