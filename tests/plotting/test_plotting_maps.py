"""What the unrolled maps, the sections and the shaded view say about the wall."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.image import PcolorImage
from synthetic_pipes import RADIUS, bump, synthetic_profile, synthetic_rings

from calibore.geometry import clock_of
from calibore.plotting import deviation_map, shaded_view, uncertainty_map, worst_sections
from calibore.plotting._figures import MISSING_GREY, UPPER_COLOUR
from calibore.plotting._maps import robust_limit
from calibore.plotting._sections import exaggeration_for
from calibore.plotting._solid import View
from calibore.plotting._stations import block_extremes, block_starts

CLOCK_STEP = np.radians(0.9)
PLACES = {"12 h": (0.0, -1.0), "3 h": (1.0, 0.0), "6 h": (0.0, 1.0), "9 h": (-1.0, 0.0)}


def _round_pipe(*, stations: int = 5, depth: float = 0.0, at: float = 0.0):
    """A round pipe with a bump outwards of `depth` [m] at clock `at` [rad]."""
    profile = synthetic_profile(np.arange(stations) * 0.01, missing=0.0)
    clock = profile["clock"].values
    wall = RADIUS + depth * bump(clock, 0.0, at=at, along=0.0, width=0.1, length=1.0)
    profile["radius"][:] = np.tile(wall, (stations, 1))
    return profile


def _image(figure) -> PcolorImage:
    return next(image for image in figure.axes[0].images if isinstance(image, PcolorImage))


def _map(profile, **options):
    return deviation_map(profile, synthetic_rings(profile), nominal_radius=RADIUS, **options)


def _pixel(figure, x: float, y: float) -> np.ndarray:
    """Colour 0..1 of the picture at data position (x, y) of its first axes."""
    if figure.stale:
        figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())
    column, row = figure.axes[0].transData.transform((x, y))
    return picture[picture.shape[0] - 1 - int(row), int(column), :3] / 255


@pytest.mark.parametrize("hour", PLACES)
def test_a_bump_appears_at_the_tick_of_its_clock_position(hour):
    x, y = PLACES[hour]
    figure = _map(_round_pipe(depth=0.004, at=float(clock_of(x, y))))
    axes = figure.axes[0]
    ticks = [
        place
        for place, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
        if label.get_text() == hour
    ]
    reddest = {tick: _pixel(figure, 20.0, np.clip(tick, -3.05, 3.05)) for tick in axes.get_yticks()}
    for tick, colour in reddest.items():
        assert (colour[0] - colour[2] > 0.2) == (tick in ticks)
    assert len(ticks) == (2 if hour == "6 h" else 1)


def test_the_crown_is_in_the_middle_and_three_o_clock_above_it():
    axes = _map(_round_pipe()).axes[0]
    low, high = axes.get_ylim()
    places = dict(zip([label.get_text() for label in axes.get_yticklabels()], axes.get_yticks(), strict=True))
    assert places["12 h"] == pytest.approx((low + high) / 2, abs=1e-12)
    assert low < places["9 h"] < places["12 h"] < places["3 h"] < high


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-5, 10), st.floats(-10, 10))
def test_colour_limits_are_symmetric_about_zero_and_hold_nine_points_in_ten(seed, spread, shift):
    values = np.random.default_rng(seed).standard_t(2, 2000) * spread + shift
    limit = robust_limit(values)
    assert np.mean(np.abs(values) <= limit) >= 0.9


def test_the_colour_bar_of_every_deviation_is_symmetric():
    profile = _round_pipe(depth=0.004)
    for draw in (deviation_map, shaded_view):
        for options in ({}, {"limit": 0.003}):
            figure = draw(profile, synthetic_rings(profile), nominal_radius=RADIUS, **options)
            low, high = figure.axes[-1].get_ylim()
            assert low == pytest.approx(-high, rel=1e-12)
            assert not options or high == pytest.approx(3.0)


def test_missing_points_are_grey_and_said_to_be_missing():
    profile = _round_pipe()
    profile["radius"][2, 90:110] = np.nan
    figure = _map(profile)
    assert _pixel(figure, 20.0, np.pi / 2) == pytest.approx(to_rgb(MISSING_GREY), abs=0.01)
    assert _pixel(figure, 20.0, -np.pi / 2) != pytest.approx(to_rgb(MISSING_GREY), abs=0.1)
    (legend,) = figure.legends
    assert "grey: not measured (1.0 % of points)" in [text.get_text() for text in legend.get_texts()]


def test_a_stretch_without_stations_is_hatched_not_coloured():
    profile = _round_pipe(depth=0.004).assign_coords(axial=("station", [0, 0.01, 0.02, 0.1, 0.11]))
    figure = _map(profile)
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "hatched: no station here" in words
    grey_or_white = np.ptp(_pixel(figure, 60.0, 0.0))
    assert grey_or_white < 0.01


def test_a_round_pipe_seen_from_off_its_centre_has_no_deviation():
    generator = np.random.default_rng(4)
    for _ in range(10):
        centre = generator.uniform(-0.03, 0.03, 2)
        profile = _round_pipe()
        clock = profile["clock"].values
        along = centre[0] * np.sin(clock) - centre[1] * np.cos(clock)
        profile["radius"][:] = along + np.sqrt(RADIUS**2 - centre @ centre + along**2)
        profile["centre_x"][:], profile["centre_y"][:] = centre
        cells = _image(_map(profile)).get_array()
        assert np.abs(cells).max() < 1e-9  # mm: rounding of metres near 0.15


def test_uncertainty_map_shows_twice_the_root_sum_of_squares():
    profile = _round_pipe()
    figure = uncertainty_map(profile, synthetic_rings(profile), nominal_radius=RADIUS)
    expected = 2e3 * np.hypot(profile["u_independent"].values, profile["u_common"].values)
    shown = _image(figure).get_array()
    assert shown.max() == pytest.approx(expected.max(), rel=1e-12)
    assert shown.min() == pytest.approx(expected.min(), rel=1e-12)


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 3000), st.integers(1, 900), st.integers(0, 2**32 - 1))
def test_thinning_keeps_every_extreme(count, most, seed):
    generator = np.random.default_rng(seed)
    values = generator.normal(size=(count, 3))
    values[generator.random(values.shape) < 0.2] = np.nan
    starts = block_starts(count, most)
    thin = block_extremes(values, starts)
    assert len(starts) == min(count, most)
    assert np.nanmax(np.abs(thin), initial=0) == np.nanmax(np.abs(values), initial=0)
    assert np.isin(thin[np.isfinite(thin)], values).all()


def test_stations_at_one_position_share_a_column_that_shows_their_extreme():
    profile = synthetic_profile([0.0, 0.0, 0.01, 0.01, 0.01, 0.02, 0.02], missing=0.0)
    profile["radius"][:] = RADIUS
    profile["radius"][3, 100], profile["radius"][6, 300] = RADIUS + 0.004, RADIUS - 0.003
    cells = _image(_map(profile)).get_array()
    assert cells.shape[1] == 3
    assert (cells.max(), cells.min()) == (pytest.approx(4.0), pytest.approx(-3.0))


def test_a_dent_in_one_of_five_thousand_stations_is_still_in_the_map_which_says_that_it_is_thinned():
    profile = synthetic_profile(np.arange(5000) * 0.1, missing=0.0, clock_count=40)
    profile["radius"][3777, 11] = RADIUS - 0.07
    figure = _map(profile)
    assert _image(figure).get_array().min() == pytest.approx(-70.0)
    assert any("5000 stations thinned to 900 columns" in text.get_text() for text in figure.texts)


@settings(max_examples=50, deadline=None)
@given(st.floats(1e-6, 0.2), st.floats(0.02, 2.0))
@example(largest=0.0998616158337094, radius=1.59375)
def test_exaggeration_is_the_largest_round_factor_that_fits(largest, radius):
    deviation = np.linspace(-largest, largest, 101)
    factor = exaggeration_for(deviation, radius)
    assert str(factor).rstrip("0") in ("1", "2", "5")
    inner = np.percentile(np.abs(deviation), 95)
    assert factor == 1 or (factor * inner <= 0.3001 * radius and factor * largest <= 0.7001 * radius)
    assert factor == 1000 or 2.5 * factor * inner > 0.2999 * radius or 2.5 * factor * largest > 0.6999 * radius


def test_sections_look_along_travel_with_three_o_clock_on_the_right():
    generator = np.random.default_rng(7)
    for at in generator.uniform(0, 2 * np.pi, 8):
        profile = _round_pipe(stations=1, depth=0.006, at=at)
        figure = worst_sections(profile, synthetic_rings(profile), nominal_radius=RADIUS)
        line = next(line for line in figure.axes[0].lines if line.get_color() == UPPER_COLOUR)
        x, y = line.get_data()
        furthest = np.argmax(np.hypot(x, y))
        seen = np.mod(np.arctan2(x[furthest], y[furthest]), 2 * np.pi)
        assert np.angle(np.exp(1j * (seen - at))) == pytest.approx(0, abs=CLOCK_STEP)
        factor = int(figure.texts[0].get_text().split("enlarged ")[1].removesuffix("x"))
        assert factor > 1
        assert np.hypot(x, y).max() == pytest.approx(1 + factor * 0.006 / RADIUS, abs=2e-3)


def test_the_two_halves_of_the_shaded_view_show_every_clock_position_once():
    clock = np.linspace(0, 2 * np.pi, 999)
    outward = np.stack([np.sin(clock), -np.cos(clock), 0 * clock], axis=1)
    seen = [outward @ View.of(side).towards < 0 for side in (1, -1)]
    assert (seen[0] ^ seen[1]).mean() > 0.998
    nine, three = (int(np.argmin(np.abs(clock - at))) for at in (1.5 * np.pi, 0.5 * np.pi))
    assert seen[0][nine]
    assert seen[1][three]


def test_travel_runs_to_the_right_seen_from_the_three_o_clock_side():
    for side, direction in ((1, 1), (-1, -1)):
        start, end = View.of(side).page(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
        assert np.sign(end[0] - start[0]) == direction
    crown, invert = View.of(1).page(np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]))
    assert crown[1] > invert[1]
