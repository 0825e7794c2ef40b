"""Where walls do not match, a registration slides along them: it says so itself, and only then."""

from dataclasses import replace

import numpy as np
import pytest
from registration_walls import random_motion, random_wall, seen

from calibore.errors import InputError
from calibore.registration import AstrayError, Motion, gaps, register
from calibore.registration._surface import Surface

STATION, SPARSE, RADIUS = 0.005, 0.022, 0.15
NOISE = 2.0
"""Times the stated noise: what fits so well may lie anywhere."""


def _pair(seed, *, same, motion=None):
    rng = np.random.default_rng([5, seed])
    wall = random_wall(rng)
    other = wall if same else random_wall(rng)
    motion = motion or random_motion(rng, station=STATION)
    reference = seen(wall, np.arange(0, 0.25, STATION), rng, u=3e-5, modes=(2e-4,))
    return seen(other, np.arange(0.02, 0.24, SPARSE), rng, motion=motion, u=8e-5, modes=(5e-4,)), reference


@pytest.mark.slow
def test_pipes_that_share_no_shape_are_refused_or_lie_where_they_were_looked_for():
    refused = []
    for seed in range(6):
        moving, reference = _pair(seed, same=False)
        try:
            found = register(moving, reference)
        except AstrayError as error:
            refused.append(str(error))
            continue
        before = gaps(found.cloud, Surface(reference), Motion()).residual
        kept = np.isfinite(found.gaps.residual).sum() / np.isfinite(before).sum()
        far = np.abs([found.motion.roll, found.motion.shift_x, found.motion.shift_y, found.motion.axial])
        free = np.array([2 * found.u(name) for name in ("roll", "shift_x", "shift_y", "axial")])
        near = far < 1.25 * np.array([np.radians(10), 0.05 * RADIUS, 0.05 * RADIUS, 2 * SPARSE]) + free
        told = np.array([name not in found.untold for name in ("roll", "shift_x", "shift_y", "axial")])
        assert found.scatter < NOISE or (near[told].all() and kept > 0.5)
    assert len(refused) >= 2
    assert all("times their noise" in said and "of one pipe" in said for said in refused)


@pytest.mark.parametrize(
    "motion", [Motion(roll=np.radians(16)), Motion(axial=2.8 * SPARSE), Motion(shift_x=0.08 * RADIUS)], ids=str
)
def test_one_pipe_further_off_than_promised_is_found_where_it_fits(motion):
    moving, reference = _pair(3, same=True, motion=motion)
    found = register(moving, reference, start=replace(motion, roll=0.7 * motion.roll, axial=0.7 * motion.axial))
    assert found.scatter < NOISE
    direct = register(moving, reference)
    assert direct.scatter < NOISE
    assert direct.motion.values == pytest.approx(found.motion.values, abs=1e-4)


def test_a_motion_beyond_what_was_searched_is_named():
    moving, reference = _pair(4, same=False)
    with pytest.raises(InputError, match="deg from its start"):
        register(moving, reference)
