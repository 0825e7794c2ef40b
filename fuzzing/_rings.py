"""Entry without files: lines that become rings, and rings that become quantities, of numbers that nothing measured."""

import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np

from calibore.errors import CaliboreError
from fuzzing._numbers import Random, number, numbers

RADIUS = 0.15


class Rings:
    """`line_on_wall` of random rigs, and `ring_quantities` of any ring."""

    def prepare(self, scratch: Path) -> None:
        """No files."""

    def attempt(self, rng: Random, scratch: Path) -> list[Callable[[], object]]:
        """One call of each."""
        from calibore.metrics import RingShape, ring_quantities
        from calibore.profiling._line_ring import line_on_wall

        kernel = str(rng.choice(["native", "native", "numpy"]))
        rig, stripe = _line(rng)
        prior = number(rng, 0.1, 0.2) if rng.random() < 0.8 else None
        shape, nominal, roll = _shape(rng), number(rng, 0.1, 0.2), number(rng, -4, 4)
        return [
            lambda: _quietly(lambda: line_on_wall(stripe, rig, prior_radius=prior, kernel=kernel)),
            lambda: ring_quantities(RingShape(*shape), nominal_radius=nominal, roll=roll, kernel=kernel),
        ]


def _quietly(work: Callable[[], object]) -> None:
    """Such lines no picture gives, and nobody hands them in: only a crash, a panic or a hang counts."""
    with warnings.catch_warnings(), suppress(CaliboreError, ArithmeticError, LookupError, ValueError):
        warnings.simplefilter("ignore")
        work()


def _line(rng: Random) -> tuple:
    from calibore.simulation import random_rig
    from calibore.stripe import NoiseModel, Stripe

    kind = str(rng.choice(["perpendicular-plane", "coaxial-cone", "single-cone"]))
    rig = random_rig(rng, RADIUS, kind=kind).with_default_uncertainty(RADIUS)
    count = int(rng.choice([0, 1, 3, 40, 300]))
    azimuth = np.arange(count) * 2 * np.pi / max(count, 1)
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    place = rng.uniform(40, 250) + rng.normal(0, 1, count)
    middle = rig.camera.principal_point
    u, v = (middle[axis] + place * direction[:, axis] for axis in (0, 1))
    bad = rng.random(count) < 0.1
    u[bad] = numbers(rng, int(bad.sum()), -1e3, 1e4)
    status = rng.choice([0, 0, 0, 0, 1, 3, 4], count).astype(np.uint8)
    u_position = np.abs(numbers(rng, count, 0, 1))
    correlation = numbers(rng, int(rng.choice([0, 1, 5, 20])), -1, 1)
    noise = NoiseModel(1.0, 0.1, 0.1, 2.0, 1.0)
    return rig, Stripe(u, v, direction, u_position, status, np.full(count, 99.0), correlation, noise, 1.0, middle)


def _shape(rng: Random) -> tuple[np.ndarray, ...]:
    count = int(rng.choice([3, 4, 9, 40, 400]))
    clock = np.arange(count) * 2 * np.pi / count
    if rng.random() < 0.1:
        clock = numbers(rng, count, 0, 6.3)
    radius = RADIUS * (1 + 0.02 * np.cos(2 * np.arange(count))) + rng.normal(0, 1e-4, count)
    strange = rng.random(count) < rng.choice([0, 0.01, 0.5])
    radius[strange] = numbers(rng, int(strange.sum()), -1, 1)
    radius[rng.random(count) < rng.choice([0, 0.1, 0.9])] = np.nan
    u = np.full(count, 1e-4) if rng.random() < 0.7 else numbers(rng, count, 0, 1e-3)
    modes = numbers(rng, int(rng.integers(4)) * count, -1e-4, 1e-4).reshape(-1, count)
    return clock, radius, u, modes, numbers(rng, int(rng.choice([0, 1, 3, 30])), -1, 1)
