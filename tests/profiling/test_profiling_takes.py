"""Takes of one station: how much they share is found out, not assumed."""

import numpy as np
import pytest

from calibore.profiling._grid import Ring, clock_grid
from calibore.profiling._takes import combine_takes, take_correlation
from calibore.status import Status

POSITIONS = 400
U = 1e-4


def takes(shared, *, count=2, seed=0, u=U):
    """Rings of a round pipe whose noise has the correlation `shared` between takes."""
    rng = np.random.default_rng(seed)
    common = rng.standard_normal(POSITIONS)
    rings = []
    for _ in range(count):
        noise = np.sqrt(shared) * common + np.sqrt(1 - shared) * rng.standard_normal(POSITIONS)
        rings.append(ring(0.15 + u * noise, u))
    return rings


def ring(radius, u):
    return Ring(
        clock=clock_grid(),
        radius=radius,
        axial=np.full(POSITIONS, 0.3),
        u=np.full(POSITIONS, u) + 0 * radius,
        modes=np.full((1, POSITIONS), 2e-4) + 0 * radius,
        status=np.where(np.isfinite(radius), Status.OK, Status.NO_PEAK).astype(np.uint8),
        correlation=np.zeros(3),
    )


@pytest.mark.parametrize("shared", [0.0, 0.3, 0.7, 0.95])
def test_the_correlation_of_takes_is_recovered(shared):
    found = [take_correlation(takes(shared, seed=seed)) for seed in range(40)]
    # one pair of 400 positions tells 1 - rho to 12 % (median of chi-square); below zero it is cut, which lifts the mean
    assert np.mean(found) == pytest.approx(shared, abs=0.06 if shared == 0 else 0.03)


@pytest.mark.parametrize("shared", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("count", [2, 4])
def test_the_combined_uncertainty_is_the_scatter_of_combined_takes(shared, count):
    errors, stated = [], []
    for seed in range(30):
        combined, _ = combine_takes(takes(shared, count=count, seed=seed))
        errors.append(combined.radius - 0.15)
        stated.append(combined.u)
    assert np.std(errors) == pytest.approx(np.mean(stated), rel=0.04)


def test_what_takes_share_in_the_rig_does_not_average_down():
    combined, _ = combine_takes(takes(0.0, count=4))
    np.testing.assert_allclose(combined.modes, 2e-4, rtol=1e-12)


def test_a_position_seen_in_one_take_only_keeps_its_value_and_uncertainty():
    first, second = takes(0.0)
    radius = second.radius.copy()
    radius[10:20] = np.nan
    combined, _ = combine_takes([first, ring(radius, U)])
    np.testing.assert_allclose(combined.radius[10:20], first.radius[10:20], rtol=1e-12)
    np.testing.assert_allclose(combined.u[10:20], U, rtol=1e-12)
    assert (combined.status == Status.OK).all()


def test_a_position_seen_in_no_take_stays_missing():
    radius = np.full(POSITIONS, 0.15)
    radius[5] = np.nan
    combined, _ = combine_takes([ring(radius, U), ring(radius, U)])
    assert np.isnan(combined.radius[5])
    assert np.isnan(combined.u[5])
    assert combined.status[5] == Status.NO_PEAK


def test_takes_that_contradict_each_other_are_not_averaged_to_a_confident_number():
    first, second = takes(0.0)
    radius = second.radius.copy()
    radius[7] += 100 * U
    combined, _ = combine_takes([first, ring(radius, U)])
    assert abs(combined.radius[7] - first.radius[7]) <= 1.96 * combined.u[7]
    assert abs(combined.radius[7] - radius[7]) <= 1.96 * combined.u[7]


def test_two_takes_too_thin_to_compare_count_as_one():
    radius = np.full(POSITIONS, np.nan)
    radius[:20] = 0.15
    combined, shared = combine_takes([ring(radius, U), ring(radius, U)])
    assert shared == 1.0
    np.testing.assert_allclose(combined.u[:20], U, rtol=1e-12)


@pytest.mark.parametrize("count", [3, 5])
def test_a_take_that_alone_contradicts_the_others_is_left_out(count):
    """A glint in one of them, 40 u away over 30 positions: the result is that of the other takes."""
    rings = takes(0.0, count=count, seed=9)
    glint = slice(100, 130)
    struck = rings[1].radius.copy()
    struck[glint] += 40 * U
    combined, _ = combine_takes([rings[0], ring(struck, U), *rings[2:]])
    error = (combined.radius - 0.15)[glint]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(U / np.sqrt(count - 1), rel=0.3)
    assert np.all(combined.u[glint] < 1.3 * U / np.sqrt(count - 1))


def test_two_against_two_and_one_against_one_stay_a_disagreement():
    """Nobody can say who is wrong, so the interval covers both."""
    for count in (2, 4):
        rings = takes(0.0, count=count, seed=10)
        wrong = [ring(one.radius + 40 * U, U) for one in rings[: count // 2]]
        combined, _ = combine_takes([*wrong, *rings[count // 2 :]])
        assert np.all(combined.u > 15 * U)


def test_takes_of_the_same_wall_are_not_left_out_by_chance():
    for seed in range(5):
        rings = takes(0.0, count=3, seed=20 + seed)
        combined, _ = combine_takes(rings)
        assert combined.u == pytest.approx(U / np.sqrt(3), rel=0.15)
