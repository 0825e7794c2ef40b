"""Thresholds by window size, and doubt on flanks: what makes a wide shallow change found and a steep edge none."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from registration_walls import STILL, random_motion, random_wall, seen

from calibore.comparison import changes, difference
from calibore.comparison._chance import _maps, thresholds
from calibore.comparison._difference import _on_flanks
from calibore.comparison._smoothing import Smoother, windows_of

CLOSE = np.arange(0, 0.08, 0.006)


@pytest.fixture(scope="module")
def unchanged():
    rng = np.random.default_rng(8)
    wall = random_wall(rng, length=0.08, bumps=3)
    motion = random_motion(rng, station=0.006, stations=0.5, roll=0.03, shift=0.01)
    before = seen(wall, CLOSE, rng, positions=200, u=1e-4, modes=(3e-4,))
    after = seen(wall, CLOSE, rng, motion=motion, positions=200, u=1e-4, modes=(3e-4,))
    return difference(after, before, start=STILL, search=False)


def test_windows_that_are_fewer_need_less(unchanged):
    smoother, windows = Smoother.of(unchanged), windows_of(unchanged)
    limits = thresholds(unchanged, smoother, windows, false_alarm=0.05, rng=np.random.default_rng(1))
    small, large = windows[0], windows[-1]
    assert small.rings * small.clocks < large.rings * large.clocks
    assert limits[large] < 0.95 * limits[small]
    assert changes(unchanged).threshold == pytest.approx(max(limits.values()), rel=0.05)  # of other drawn maps


def test_drawn_maps_of_an_unchanged_pipe_exceed_the_thresholds_as_often_as_stated(unchanged):
    """200 maps that the thresholds have not seen, 10 alarms expected at 5 %."""
    smoother, windows = Smoother.of(unchanged), windows_of(unchanged)
    limits = thresholds(unchanged, smoother, windows, false_alarm=0.05, rng=np.random.default_rng(2))
    scales, drawn = {one: smoother.u(one) * limits[one] for one in windows}, _maps(unchanged, smoother)
    rng, alarms = np.random.default_rng(3), 0
    for _ in range(200):
        field = drawn(rng)
        alarms += any(np.nanmax(np.abs(smoother.mean(field, one)) / u) > 1 for one, u in scales.items())
    assert 2 <= alarms <= 21  # outside in less than 1 of 400 tests of either side


def test_the_fit_takes_its_part_of_the_noise_away_from_drawn_maps(unchanged):
    """A calibration error or a shift of the whole pipe is no part of what is left."""
    registration = unchanged.registration
    rng, drawn = np.random.default_rng(4), _maps(unchanged, Smoother.of(unchanged))
    ring, position = registration.cloud.ring, registration.cloud.position
    weight = registration.weights / registration.gaps.total
    used = weight > 0
    for column in registration.table.T:
        along = column[used] * weight[used]
        expected = np.sqrt(np.sum(column[used] ** 2 * weight[used]))  # of noise that no fit has seen
        found = [np.sum(along * drawn(rng)[ring, position][used]) / expected for _ in range(5)]
        assert np.sqrt(np.mean(np.square(found))) < 0.3


def test_rings_between_the_same_two_share_their_noise():
    """Where every ring falls half between two, a third of the noise is the reference's, half of that shared."""
    rng = np.random.default_rng(9)
    wall = random_wall(rng, length=0.08, bumps=1)
    for between, shared in ((0.0, 0.0), (0.5, 1 / 6)):
        before, after = (seen(wall, CLOSE + place, rng, u=1e-4) for place in (0.0, 0.006 * between))
        one = difference(after, before, free=("roll", "shift_x", "shift_y"), start=STILL, search=False)
        assert Smoother.of(one).across == pytest.approx(shared, abs=0.05)  # of 5000 points, u 0.015


def test_what_is_missed_has_no_notch_where_a_bend_turns():
    missed = np.zeros((2, 40))
    missed[0, [9, 10, 12, 13]] = 1.0, 2.0, 1.5, 1.0
    missed[0, [20, 23]] = 1.0  # edges of a narrow plateau, which is measured
    missed[1, 20] = np.nan
    closed = _on_flanks(missed)
    np.testing.assert_array_equal(closed[0, 9:14], [1.0, 2.0, 1.5, 1.5, 1.0])
    assert closed[0].sum() == pytest.approx(9.0)
    assert np.isnan(closed[1, 20])
    assert np.nansum(closed[1]) == 0


def test_the_peer_s_blocks_give_the_peer_s_numbers():
    """M3C2-EP through our driver sees a step of a round pipe, and states its noise as it does."""
    if importlib.util.find_spec("py4dgeo") is None:
        pytest.skip("py4dgeo is not installed: pip install -e .[peers]")
    sys.path.append(str(Path(__file__).parents[2]))
    from benchmarks.epochs import Epochs
    from benchmarks.peers import m3c2

    epochs = Epochs(0)
    patch = epochs.patch(0.015)
    worn = difference(epochs.after(patch, 1e-3), epochs.before, start=epochs.motion, search=False)
    clouds = m3c2.Clouds.of(worn, epochs.before, freed=True)
    within = patch.holds(*clouds.after[:2])
    for peer in (m3c2.plain, m3c2.propagated):
        found = peer(clouds, cylinder=0.008, within=within)
        assert np.isfinite(found.distance).all()
        assert 0.3e-3 < found.distance.max() < 1.2e-3
