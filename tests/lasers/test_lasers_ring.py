"""The cone for a ring lights that ring, and its angles move as they state."""

import numpy as np
import pytest
from rays_everywhere import STEP

from calibore.errors import InputError
from calibore.lasers import Cone, ring_angles

RNG = np.random.default_rng(1)
CASES = np.column_stack([RNG.uniform(0.01, 0.99, 200), RNG.uniform(0.02, 5, 200) * RNG.choice([-1, 1], 200)])


def test_the_light_falls_on_crown_and_invert_at_the_stated_projection():
    for baseline, projection in CASES:
        for clock in (0.0, 2.0):
            cone = Cone.for_ring(baseline, projection, 1.0, clock=clock)
            outwards = np.array([np.sin(clock), -np.cos(clock), 0])
            crown_and_invert = np.array([outwards, -outwards]) + np.array([0, 0, projection])
            assert np.abs(cone.value(crown_and_invert)).max() < 1e-14 * (1 + abs(projection))


def test_angles_move_with_baseline_and_projection_as_stated():
    for baseline, projection in CASES:
        _, _, jacobian = ring_angles(baseline, projection, 1.0)
        by_baseline = ring_angles(baseline + 1j * STEP, projection, 1.0)[:2]
        by_projection = ring_angles(baseline, projection + 1j * STEP, 1.0)[:2]
        expected = np.imag([by_baseline, by_projection]).T / STEP
        np.testing.assert_allclose(jacobian, expected, rtol=1e-11, atol=1e-14)


def test_a_rig_of_another_size_has_the_same_angles():
    for baseline, projection in CASES:
        scaled = ring_angles(0.15 * baseline, 0.15 * projection, 0.15)
        np.testing.assert_allclose(scaled[:2], ring_angles(baseline, projection, 1.0)[:2], rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("baseline", [-0.1, 1.0, np.nan])
def test_a_laser_outside_the_pipe_is_refused(baseline):
    with pytest.raises(InputError, match="the laser stands inside the pipe"):
        Cone.for_ring(baseline, 1.0, 1.0)


@pytest.mark.parametrize("projection", [0.0, np.nan, np.inf])
def test_a_ring_beside_the_apex_is_refused(projection):
    with pytest.raises(InputError, match="projection must be a length other than 0"):
        Cone.for_ring(0.5, projection, 1.0)
