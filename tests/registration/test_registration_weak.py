"""Walls that hardly tell the axial shift: the fit settles all the same."""

import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))
from registration_walls import random_motion, random_wall, seen

from calibore.registration import register

STATIONS = np.arange(6) * 0.012


def test_a_shift_that_noise_nearly_hides_is_found_within_its_own_uncertainty():
    # most of the information along the axis is noise in the slopes of six rings
    rng = np.random.default_rng([5, 26])
    wall, motion = random_wall(rng, bumps=1, ovality=3e-3), random_motion(rng, station=0.012, stations=0.3)
    reference = seen(wall, STATIONS, rng, u=2.5e-4, modes=(2e-4,))
    found = register(seen(wall, STATIONS, rng, motion=motion, u=2.5e-4, modes=(2e-4,)), reference)
    true = motion.about(found.motion.pivot)
    assert abs(found.motion.axial - true.axial) < 4 * max(found.u("axial"), 1e-4)
    assert abs(found.motion.shift_x - true.shift_x) < 4 * found.u("shift_x")
