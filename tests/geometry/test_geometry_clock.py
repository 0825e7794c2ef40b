"""Clock positions: one convention, fixed by golden positions."""

import numpy as np
import pytest

from calibore.geometry import clock_of, xy_of

GOLDEN = {
    0: (0.0, -1.0),
    3: (1.0, 0.0),
    6: (0.0, 1.0),
    9: (-1.0, 0.0),
    1: (0.5, -np.sqrt(0.75)),
    8: (-np.sqrt(0.75), 0.5),
}


@pytest.mark.parametrize(("hour", "place"), GOLDEN.items())
def test_a_feature_at_a_known_hour_stands_at_its_known_place(hour, place):
    clock = hour * np.pi / 6
    assert np.allclose(xy_of(clock, 1.0), place, atol=1e-15)
    assert clock_of(*place) == pytest.approx(clock, abs=1e-15)


def test_clock_and_coordinates_are_inverse_all_round_and_for_every_radius():
    rng = np.random.default_rng(1)
    clock, radius = rng.uniform(0, 2 * np.pi, 10_000), rng.uniform(0.01, 3, 10_000)
    x, y = xy_of(clock, radius)
    assert np.allclose(clock_of(x, y), clock, atol=1e-12)
    assert np.allclose(np.hypot(x, y), radius, rtol=1e-14)


def test_the_clock_never_reaches_a_full_turn():
    assert clock_of(-1e-300, -1.0) == 0.0
    assert clock_of(-1e-15, -1.0) < 2 * np.pi


def test_the_clock_runs_clockwise_looking_along_travel():
    clock = np.linspace(0.1, 6.0, 50)
    x, y = xy_of(clock, 1.0)
    ahead = x[:-1] * y[1:] - y[:-1] * x[1:]  # z of the cross product; z is forward
    assert (ahead > 0).all()
