"""Positions along the pipe in wrong units are named by their factor; scans that differ in length are not accused."""

from dataclasses import replace

import numpy as np
import pytest
from compared_walls import DENT, STATIONS, misread, pair
from registration_walls import Wall, random_motion, random_wall, seen

from calibore.comparison import compared
from calibore.errors import InputError

NAMES = ("later", "earlier")
FOOT = 0.3048


def said_of(moving, reference, **options):
    try:
        return compared(moving, reference, **{"epochs": True, "names": NAMES, **options}).warnings
    except InputError as error:
        return (str(error),)


def named(factor, moving, reference):
    said = said_of(moving, reference)[0]
    return f"along the pipe differ by a factor of {max(factor, 1 / factor):.4g}" in said and "units" in said


@pytest.mark.parametrize("factor", [25.4, 1 / 25.4, 10, 1 / 1000, FOOT])
def test_the_factor_is_named_whichever_of_the_two_is_wrong(factor):
    after, before = pair()
    assert named(factor, misread(after, factor), before)
    assert named(factor, after, misread(before, factor))


@pytest.mark.parametrize("seed", range(4))
def test_it_is_named_for_any_wall_and_though_it_has_changed(seed):
    factor = [25.4, 1 / FOOT, 1 / 25.4, 10][seed]
    after, before = pair(seed + 20, dented=True)
    assert named(factor, misread(after, factor), before)


def test_it_is_named_where_the_rig_looks_ahead_and_where_scans_differ_in_length_and_step():
    rng = np.random.default_rng(12)
    wall = random_wall(rng, length=0.1)
    reference = seen(wall, np.arange(0, 0.1, 0.005), rng, positions=200)
    moving = seen(wall, np.arange(0.02, 0.09, 0.008), rng, positions=200, motion=random_motion(rng, stations=0.5))
    assert named(25.4, misread(moving, 25.4, ahead=0.3), reference)
    assert named(25.4, moving, misread(reference, 25.4, ahead=0.3))


@pytest.mark.parametrize(("ratio", "dented"), [(2.54, True), (10, True), (10, False)])
def test_scans_whose_lengths_differ_by_such_a_factor_are_not_accused(ratio, dented):
    """A piece of the pipe, seen again with the same number of rings."""
    rng = np.random.default_rng([13, dented])
    wall = random_wall(rng, length=0.1)
    dent = np.concatenate([wall.bumps, [DENT * [1, 1, 1, 0.5, 1]]])
    later = replace(wall, bumps=dent) if dented else wall
    before = seen(wall, STATIONS, rng, positions=200)
    after = seen(later, 0.04 + STATIONS / ratio, rng, positions=200)
    for one, other in ((after, before), (before, after)):
        found = compared(one, other, epochs=True, names=NAMES)
        assert not any("factor" in said for said in found.warnings)
        assert abs(found.registration.motion.axial) < 0.003


def test_scans_that_overlap_partly_are_not_accused():
    rng = np.random.default_rng(14)
    wall = random_wall(rng, length=0.3)
    long, short = (seen(wall, places, rng, positions=200) for places in (np.arange(0, 0.25, 0.01), 0.2 + STATIONS))
    for one, other in ((short, long), (long, short)):
        assert not compared(one, other, epochs=True, names=NAMES).warnings


@pytest.mark.parametrize("seed", range(2))
def test_other_pipes_of_other_lengths_are_other_pipes(seed):
    rng = np.random.default_rng([15, seed])
    other = seen(random_wall(rng, length=1.0), 10 * STATIONS, rng, positions=200)
    said = said_of(other, pair()[1])[0]
    assert "factor" not in said


def test_a_pipe_alike_all_along_tells_nothing_of_the_scale_along_it():
    rng = np.random.default_rng(16)
    wall = Wall(0.15, np.array([[2.0, 5e-4, 1.0]]), np.zeros((0, 5)))
    before, after = (seen(wall, STATIONS, rng, positions=200) for _ in range(2))
    assert not any("factor" in said for said in said_of(misread(after, 0.1), before))
