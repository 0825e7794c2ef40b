"""A prediction put to the test: many true rigs, drawn from what is known of one, measure walls of known radius."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._appraisal import RANGE
from calibore.design._candidates import inputs_of
from calibore.design._fusion import combine_lasers
from calibore.design._optimise import Optimised
from calibore.design._prediction import scan_direction
from calibore.design._requirement import Requirement
from calibore.design._ring import predict_ring, ring_clocks
from calibore.rigs import Rig, lit_points, meetings_of, moved

Array = NDArray[np.float64]
DRAWS, CLOCKS = 3000, 12
"""3000 draws settle the rms of one common input to 1.3 % (1 / sqrt(2 n))."""


@dataclass(frozen=True)
class Verification:
    """`predicted` and `simulated` rms error [m] over `places` of the wall and `draws` of the rig; `ratio` of the two,
    place by place (rms of error / u).
    """

    predicted: float
    simulated: float
    ratio: float
    places: int
    draws: int


def verify(rig: Rig, wanted: Requirement, *, rng: np.random.Generator, draws: int = DRAWS) -> Verification:
    """Each true rig sees round walls over the pipe's range; `rig`, as it is believed to be, computes their radius from
    noisy pixels. Lasers are combined by the weights of the prediction.
    """
    clock, radius = np.meshgrid(ring_clocks(rig, CLOCKS), np.linspace(*wanted.radii, RANGE), indexing="ij")
    assumed = inputs_of(wanted)
    ring = predict_ring(rig, clock, radius, assumptions=assumed)
    good = ring.first_order
    clock, radius, u = clock[good], radius[good], ring.u_radius[good]
    weights = combine_lasers(ring.predictions, rule=assumed.rule).weights[:, good]
    errors = np.zeros((draws, radius.size))
    true = list(_drawn(rig, rng, draws))
    for laser, weight in enumerate(weights):
        used = weight != 0
        measured = _measured(rig, true, clock[used], radius[used], laser=laser, noise=wanted.noise.stripe, rng=rng)
        errors[:, used] += weight[used] * (measured - radius[used])
    return Verification(
        predicted=float(np.sqrt(np.mean(u**2))),
        simulated=float(np.sqrt(np.nanmean(errors**2))),
        ratio=float(np.sqrt(np.nanmean((errors / u) ** 2))),
        places=radius.size,
        draws=draws,
    )


def verify_best(
    found: Optimised, *, seed: int = 1, draws: int = DRAWS, progress: Callable[[int, int], None] | None = None
) -> dict[str, Verification]:
    """The best design of every configuration, by configuration."""
    verified: dict[str, Verification] = {}
    for name, option in found.by_configuration.items():
        rng = np.random.default_rng(seed)
        verified[name] = verify(option.design.candidate.rig(found.wanted), found.wanted, rng=rng, draws=draws)
        if progress:
            progress(len(verified), len(found.by_configuration))
    return verified


def _drawn(rig: Rig, rng: np.random.Generator, draws: int) -> list[Rig]:
    if rig.covariance is None:
        return [rig] * draws
    names = rig.covariance.names
    shifts = rig.covariance.draw(rng, draws)
    return [moved(rig, dict(zip(names, shift.tolist(), strict=True))) for shift in shifts]


def _measured(
    rig: Rig, true: list[Rig], clock: Array, radius: Array, *, laser: int, noise: float, rng: np.random.Generator
) -> Array:
    """(draws, places) [m] as `rig` computes them from what the `true` rigs see."""
    pixels = np.array([one.project(lit_points(one, clock, radius, laser=laser)) for one in true])
    u, v = (pixels[:, axis].ravel() for axis in (0, 1))
    shift = noise * rng.standard_normal(u.size)[:, None] * scan_direction(rig, u, v)
    met = meetings_of(rig, u + shift[:, 0], v + shift[:, 1], laser=laser).radius
    away = np.abs(met - np.tile(radius, len(true)))
    nearest = np.argmin(np.where(np.isfinite(away), away, np.inf), axis=0)
    return met[nearest, np.arange(u.size)].reshape(len(true), radius.size)
