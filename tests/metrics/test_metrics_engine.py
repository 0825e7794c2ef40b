"""The compiled engine finds what its specification, the NumPy code, finds."""

from dataclasses import fields

import numpy as np
import pytest
from metrics_rings import NOMINAL, random_ring

from calibore.errors import UsageError
from calibore.metrics import RingShape, ring_quantities
from calibore.metrics._engine import _by_engine
from calibore.uncertainty import Quantity

ROUNDING = 1e-9
"""Of u: both sum in another order, and what they solve has a condition of up to 1e5."""
OPEN = 1e-4
"""Of u, with a third of the ring missing or many features: the conditions there are up to 1e10."""


def both(ring, **options):
    return [ring_quantities(ring, nominal_radius=NOMINAL, kernel=kernel, **options) for kernel in ("native", "numpy")]


def furthest(ours, theirs):
    """The largest difference of any number, over its uncertainty; infinite where one of both is NaN."""
    pairs = [(getattr(ours, f.name), getattr(theirs, f.name)) for f in fields(ours)]
    pairs = [(a, b) for a, b in pairs if isinstance(a, Quantity) and not (np.isnan(a.value) and np.isnan(b.value))]
    apart = [max(abs(a.value - b.value), abs(a.u - b.u)) / b.u for a, b in pairs]
    return max(np.where(np.isnan(apart), np.inf, apart), default=0.0)


def with_modes(ring, rng):
    """`ring` with three slow common modes and as many lags of correlation as a grid gives."""
    modes = np.stack([np.ones_like(ring.clock), np.cos(ring.clock), np.sin(2 * ring.clock)]) * rng.normal(
        0, 1e-4, (3, 1)
    )
    return RingShape(ring.clock, ring.radius, ring.u_independent, modes, ring.correlation[:3])


@pytest.mark.parametrize("kind", ["white", "correlated"])
@pytest.mark.parametrize("count", [40, 100, 400, 1500])
@pytest.mark.parametrize("noise", [1e-4, 5e-3])
def test_whole_rings_have_the_same_quantities_from_both_kernels(kind, count, noise):
    rng = np.random.default_rng([count, len(kind)])
    for spread, offset in ((0.0, 0.0), (0.5, 0.1), (4.0, 0.4)):
        ring, _ = random_ring(rng, noise=noise, kind=kind, count=count, spread=spread, offset=offset)
        ring = with_modes(ring, rng)
        ours, theirs = both(ring, roll=rng.uniform(-1, 1))
        assert ours.flags == theirs.flags
        assert furthest(ours, theirs) < (OPEN if ours.flags else ROUNDING)


@pytest.mark.parametrize(
    "case", [{"gap": 0.35}, {"dent": True}, {"rail": True}, {"dent": True, "rail": True, "gap": 0.3}]
)
def test_gaps_and_features_are_treated_alike_by_both_kernels(case):
    rng = np.random.default_rng(7)
    for noise in (3e-4, 3e-3):
        ring = with_modes(random_ring(rng, noise=noise, kind="correlated", offset=0.2, **case)[0], rng)
        assert _by_engine(ring, 0.0) is not None
        ours, theirs = both(ring)
        assert (ours.flags, ours.points, ours.fraction_directions) == (
            theirs.flags,
            theirs.points,
            theirs.fraction_directions,
        )
        assert furthest(ours, theirs) < OPEN


def test_lone_readings_and_enlarged_noise_are_noticed_by_both_kernels():
    ring, _ = random_ring(np.random.default_rng(3), noise=1e-3)
    radius = ring.radius.copy()
    radius[[17, 200]] *= 1.05
    for changed in (
        RingShape(ring.clock, radius, ring.u_independent),
        RingShape(ring.clock, ring.radius, ring.u_independent / 3),
    ):
        ours, theirs = both(changed)
        assert {"lone-points", "noise-above-stated"} & set(ours.flags)
        assert ours.flags == theirs.flags
        assert furthest(ours, theirs) < OPEN


def test_what_is_no_ring_is_no_ring_for_either_kernel():
    clock = np.arange(400) * 2 * np.pi / 400
    cloud = RingShape(clock, np.random.default_rng(1).uniform(0.01, 1.0, 400), np.full(400, 1e-3))
    few = RingShape(clock, np.where(np.arange(400) < 7, 0.15, np.nan), np.full(400, 1e-3))
    for ring in (cloud, few):
        ours, theirs = both(ring)
        assert ours.flags == theirs.flags
        assert np.isnan(ours.diameter_mean.value) == np.isnan(theirs.diameter_mean.value)


def test_an_unknown_kernel_is_refused():
    ring, _ = random_ring(np.random.default_rng(3), noise=1e-3)
    with pytest.raises(UsageError, match="cuda"):
        ring_quantities(ring, nominal_radius=NOMINAL, kernel="cuda")
