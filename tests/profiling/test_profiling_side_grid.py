"""The grid of a side-facing scan: where its positions lie, and how columns become one."""

import numpy as np
import pytest
from numpy.typing import NDArray

from calibore.profiling._side._clocks import ClockGrid
from calibore.profiling._side._column import Column
from calibore.profiling._side._merge import merged
from calibore.profiling._side._wall import Wall
from calibore.scans import AngularMotion
from calibore.status import Status

Array = NDArray[np.float64]


def column(first: int, radius: Array, u: Array | float, *, mode: float = 0.0, offset: float = 0.0) -> Column:
    shape = np.broadcast_to(np.asarray(u, dtype=float), radius.shape)
    gone = np.where(np.isfinite(radius), 0.0, np.nan)
    status = np.where(np.isfinite(radius), Status.OK, Status.NO_PEAK).astype(np.uint8)
    modes = np.full((1, radius.size), mode)
    return Column(first, radius, shape + gone, modes + gone, offset + gone, 0 * modes + gone, status, np.array([0.3]))


@pytest.mark.parametrize("degrees", [0.9, -0.9, 0.45, 1.0, 7.2, 360 / 17])
def test_stops_lie_on_the_grid_whatever_their_step(degrees: float) -> None:
    motion = AngularMotion(np.radians(13.37), np.radians(degrees))
    grid = ClockGrid.of(motion)
    stops = np.arange(round(360 / abs(degrees)))
    clocks = motion.clock(stops)
    positions = [grid.nearest(float(clock)) for clock in clocks]
    assert sorted(positions) == list(range(grid.count))
    away = [float(grid.offset(clock, position)) for clock, position in zip(clocks, positions, strict=True)]
    np.testing.assert_allclose(away, 0, atol=1e-9)
    assert 0 <= grid.clocks[0] < grid.step
    assert grid.clocks[-1] < 2 * np.pi


@pytest.mark.parametrize("degrees", [0.7, 50.0, 120.0])
def test_a_step_that_divides_no_turn_gets_the_usual_grid(degrees: float) -> None:
    grid = ClockGrid.of(AngularMotion(0.1, np.radians(degrees)))
    assert (grid.first, grid.count) == (0.0, 400)
    clock = np.random.default_rng(1).uniform(-20, 20, 50)
    away = [float(grid.offset(one, grid.nearest(one))) for one in clock]
    assert np.abs(away).max() <= grid.step / 2 + 1e-12


def test_overlapping_columns_are_averaged_with_least_variance() -> None:
    rng = np.random.default_rng(2)
    n, u = 4000, np.array([1e-4, 2e-4, 3e-4])
    columns = [column(0, 0.15 + one * rng.normal(size=n), one) for one in u]
    one = merged(columns)
    expected = 1 / np.sqrt(np.sum(1 / u**2))
    np.testing.assert_allclose(one.u[one.status == Status.OK], expected, rtol=1e-6)
    assert np.std(one.radius) == pytest.approx(expected, rel=0.05)  # 4000 numbers, a rare one left out
    assert np.mean(one.status == Status.RESOLVED) < 0.005


def test_what_all_columns_share_is_not_averaged_away() -> None:
    flat = np.full(20, 0.1)
    one = merged([column(0, flat, 1e-5, mode=1e-3) for _ in range(5)])
    np.testing.assert_allclose(one.modes, 1e-3)


def test_a_stop_that_saw_another_piece_of_wall_is_left_out_and_told() -> None:
    flat = np.full(30, 0.1)
    step = flat.copy()
    step[10:15] -= 0.005
    one = merged([column(0, flat, 1e-5), column(0, step, 1e-5), column(0, flat, 1e-5)])
    np.testing.assert_allclose(one.radius, 0.1)
    np.testing.assert_array_equal(np.flatnonzero(one.status == Status.RESOLVED), np.arange(10, 15))


@pytest.mark.parametrize("seed", range(5))
def test_merging_measures_where_any_column_does_and_nowhere_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    columns = []
    for _ in range(rng.integers(2, 9)):
        radius = np.where(rng.uniform(size=rng.integers(5, 60)) < 0.3, np.nan, 0.2)
        columns.append(column(int(rng.integers(-50, 50)), radius, 1e-4))
    one = merged(columns)
    seen = {part.first + i for part in columns for i in np.flatnonzero(np.isfinite(part.radius))}
    assert seen == {one.first + i for i in np.flatnonzero(np.isfinite(one.radius))}
    value = np.isfinite(one.radius)
    assert (np.isfinite(one.u) == value).all()
    np.testing.assert_allclose(one.radius[value], 0.2)
    assert (one.status[value] == Status.OK).all()
    assert (one.status[~value] >= Status.NO_PEAK).all()


def test_columns_beside_the_grid_are_moved_along_the_walls_slope() -> None:
    """A head off the axis of a round pipe, its sheet a third of a step beside where the head points."""
    grid = ClockGrid(0.0, 400)
    beside, shift = grid.step / 3, 0.01
    wall = Wall(grid, 0.001)
    for position, clock in enumerate(grid.clocks):
        radius = 0.15 + shift * np.cos(clock + beside)
        wall.columns[position] = column(7, np.full(3, radius), 1e-5, offset=beside)
    rows = list(wall.rows())
    np.testing.assert_allclose([axial for axial, _ in rows], [0.007, 0.008, 0.009])
    expected = 0.15 + shift * np.cos(grid.clocks)
    # the median of eight differences bends with the wall by a step or two
    np.testing.assert_allclose(rows[0][1].radius, expected, atol=0.01 * shift * grid.step)
    assert np.abs(expected - (0.15 + shift * np.cos(grid.clocks + beside))).max() > 0.3 * shift * grid.step


def test_positions_without_a_picture_say_so() -> None:
    wall = Wall(ClockGrid(0.0, 400), 0.001, {5: column(0, np.full(4, 0.1), 1e-5)})
    _, ring = next(iter(wall.rows()))
    assert ring.status[5] == Status.OK
    assert (np.delete(ring.status, 5) == Status.NO_IMAGE).all()
    assert np.isnan(np.delete(ring.radius, 5)).all()
    assert wall.visited == pytest.approx(1 / 400)
