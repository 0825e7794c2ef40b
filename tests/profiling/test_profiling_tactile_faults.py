"""Stuck pins and readings off the tip are told from the wall by geometry, whatever the pipe."""

import numpy as np
import pytest
from tactile_walls import INCH, NOMINAL, TURN, Pipe, random_pipe, scanned

from calibore.profiling._tactile._faults import faults, scatter
from calibore.profiling._tactile._neighbours import Grid
from calibore.profiling._tactile._tip import touch
from calibore.status import Status

NOISE = 0.0006 * INCH
TIP = INCH / 16


def judged(made, *, tip_radius=TIP):
    return faults(made.reading, Grid(made.clock, made.axial, tip_radius), noise=NOISE)


CASES = {
    "as the dissertation's": {},
    "half as many stops": {"stops": 200},
    "a ball wider than the steps": {"tip_radius": INCH / 8},
    "rings further apart": {"step": 0.2 * INCH},
    "a rough wall": {"rough": 0.001 * INCH},
    "a pin that never sticks": {"stick": 0.0},
    "a small ball": {"tip_radius": INCH / 32},
}


@pytest.mark.parametrize("case", CASES)
def test_nearly_all_bad_readings_are_flagged_and_few_good_ones(case):
    """Walls with an upright rail, an opening, a cone, a dent at random places; limits are the issue's."""
    bad, good = [], []
    for seed in range(2):
        rng = np.random.default_rng(1000 * list(CASES).index(case) + seed)
        made = scanned(random_pipe(rng), rng, rings=20, **CASES[case])
        flagged = judged(made, tip_radius=CASES[case].get("tip_radius", TIP)) != Status.OK
        bad.append(flagged[made.bad])
        good.append(flagged[~made.bad])
    assert np.concatenate(bad).size > 50
    assert np.concatenate(bad).mean() >= 0.95
    assert np.concatenate(good).mean() <= 0.03


def test_what_is_not_flagged_is_the_wall():
    """Over random sharp walls: rms below twice the noise, intervals that hold, where readings as they are fail."""
    errors, z, raw = [], [], []
    for seed in range(3):
        rng = np.random.default_rng(50 + seed)
        made = scanned(random_pipe(rng), rng, rings=30)
        grid, status = Grid(made.clock, made.axial, TIP), judged(made)
        usual = scatter(np.where(status == Status.OK, made.reading, np.nan), grid, noise=NOISE)
        reading = np.where(status == Status.STUCK, np.nan, made.reading)
        found = touch(reading, grid, good=status == Status.OK, noise=NOISE, usual=usual)
        kept = np.isfinite(found.radius)
        errors.append((found.radius - made.wall)[kept])
        raw.append((made.reading - made.wall)[kept])
        z.append(errors[-1] / found.u[kept])
    rms = np.sqrt(np.mean(np.concatenate(errors) ** 2))
    assert rms < 2 * NOISE
    assert np.sqrt(np.mean(np.concatenate(raw) ** 2)) > 1.5 * rms
    assert 0.93 < np.mean(np.abs(np.concatenate(z)) < 1.96) < 0.97


@pytest.mark.parametrize("seed", range(2))
def test_smooth_walls_are_left_alone(seed):
    rng = np.random.default_rng(seed)
    made = scanned(random_pipe(rng, sharp=False), rng)
    assert (judged(made) != Status.OK).mean() < 2e-4


def test_a_pin_far_out_between_two_level_neighbours_is_stuck():
    clock, axial = np.arange(400) * TURN / 400, np.arange(9) * 0.1 * INCH
    reading = NOMINAL + NOISE * np.random.default_rng(1).standard_normal((9, 400))
    reading[4, 100] += 3 * TIP
    reading[4, 200] += 0.3 * TIP
    status = faults(reading, Grid(clock, axial, TIP), noise=NOISE)
    assert status[4, 100] == Status.STUCK
    assert status[4, 200] == Status.OFF_TIP
    assert np.count_nonzero(status) == 2


def test_the_floor_beside_a_rail_is_kept_and_the_edge_of_the_rail_is_not():
    rail = ("rail", {"at": np.pi, "height": 0.8 * INCH, "width": 1.01 * INCH})
    rng = np.random.default_rng(2)
    made = scanned(Pipe(parts=(rail,)), rng, stick=0.0, rings=10)
    status = judged(made)
    assert made.off_tip.any()
    assert (status[made.off_tip] == Status.OFF_TIP).all()
    floor = ~made.off_tip & (made.wall == made.wall.max())
    assert (status[floor] == Status.OK).all()
    assert (np.count_nonzero(status[~made.off_tip] != Status.OK)) <= 2 * len(status)


def test_a_seam_across_the_ring_changes_nothing():
    """Whatever lies at clock 0 is judged as elsewhere."""
    rng = np.random.default_rng(9)
    made = scanned(random_pipe(rng), rng, rings=20)
    grid = Grid(made.clock, made.axial, TIP)
    for turn in (37, 200):
        assert np.array_equal(
            faults(np.roll(made.reading, turn, 1), grid, noise=NOISE),
            np.roll(faults(made.reading, grid, noise=NOISE), turn, 1),
        )


def test_neighbours_out_of_the_balls_reach_tell_nothing():
    rng = np.random.default_rng(3)
    reading = NOMINAL + 0.02 * rng.standard_normal((5, 24))
    assert not faults(reading, Grid(np.arange(24) * TURN / 24, np.arange(5) * 1.0, TIP), noise=NOISE).any()


def test_missing_readings_are_no_faults():
    clock, axial = np.arange(400) * TURN / 400, np.arange(9) * 0.1 * INCH
    reading = np.full((9, 400), NOMINAL)
    reading[2] = reading[5, 10:40] = np.nan
    assert not faults(reading, Grid(clock, axial, TIP), noise=NOISE).any()
    assert not faults(np.full((9, 400), np.nan), Grid(clock, axial, TIP), noise=NOISE).any()
