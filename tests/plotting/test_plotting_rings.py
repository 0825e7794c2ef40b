"""Ring quantities along the pipe, the worst places, and the detected line."""

import numpy as np
import pytest
from synthetic_pipes import RADIUS, synthetic_profile, synthetic_rings

from calibore.errors import InputError
from calibore.plotting import (
    clock_text,
    detected_line,
    diameter_along,
    governing_ovality,
    ovality_along,
    worst_stations,
)
from calibore.plotting._line import OFFSET
from calibore.status import MEANING, Status


def _pipe(axial):
    profile = synthetic_profile(axial, missing=0.0)
    return profile, synthetic_rings(profile)


@pytest.mark.parametrize("count", [1, 10, 100, 5000])
def test_every_station_is_drawn_with_its_95_percent_band(count):
    profile = synthetic_profile(np.arange(count) * 0.01, missing=0.0, clock_count=40)
    rings = synthetic_rings(profile)
    axes = ovality_along(profile, rings, nominal_radius=RADIUS, definitions=("governing",)).axes[0]
    ovality, u = governing_ovality(rings)
    drawn = np.concatenate([line.get_ydata() for line in axes.lines])
    assert np.isin(ovality, drawn).all()
    bars = axes.containers[0].lines[2][0].get_segments() if count <= 60 else axes.collections[0].get_paths()[0].vertices
    ends = np.concatenate(bars)[:, 1] if count <= 60 else bars[:, 1]
    assert ends.max() == pytest.approx((ovality + 2 * u).max(), rel=1e-9)
    assert ends.min() == pytest.approx((ovality - 2 * u).min(), rel=1e-9)


def test_a_single_station_stands_in_the_middle_with_its_own_tick():
    profile, rings = _pipe([0.3])
    for draw in (ovality_along, diameter_along):
        axes = draw(profile, rings, nominal_radius=RADIUS).axes[0]
        assert list(axes.get_xticks()) == [300.0]
        assert np.mean(axes.get_xlim()) == pytest.approx(300.0)


def test_no_line_bridges_a_stretch_without_stations():
    profile, rings = _pipe([0.0, 0.01, 0.02, 0.5, 0.51])
    axes = ovality_along(profile, rings, nominal_radius=RADIUS).axes[0]
    connecting = [line for line in axes.lines if len(line.get_xdata()) > 5]
    assert len(connecting) == 2
    assert all(np.isnan(line.get_ydata()[3]) for line in connecting)


def test_a_limit_far_away_is_named_rather_than_allowed_to_flatten_the_picture():
    profile, rings = _pipe(np.arange(10) * 0.01)
    for limit, inside in ((5.0, True), (500.0, False)):
        figure = ovality_along(profile, rings, nominal_radius=RADIUS, limit=limit)
        words = [text.get_text() for text in figure.legends[0].get_texts()]
        assert (f"limit {limit:g} %" in words) == inside
        assert (figure.axes[0].get_ylim()[1] > limit) == inside


def test_stations_without_a_value_are_marked_not_left_out():
    profile, rings = _pipe(np.arange(10) * 0.01)
    for name in rings:
        if name.startswith("ovality"):
            rings[name][3:5] = np.nan
    figure = ovality_along(profile, rings, nominal_radius=RADIUS)
    assert "no value (2 stations)" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_governing_ovality_is_the_larger_form_with_its_own_uncertainty():
    nan = np.nan
    rings = {
        "station": np.arange(4),
        "ovality_f1216_max_percent": np.array([1.0, 3.0, nan, nan]),
        "ovality_f1216_min_percent": np.array([2.0, 1.0, 4.0, nan]),
        "u_ovality_f1216_max_percent": np.array([0.1, 0.2, nan, nan]),
        "u_ovality_f1216_min_percent": np.array([0.3, 0.4, 0.5, nan]),
    }
    ovality, u = governing_ovality(rings)
    np.testing.assert_array_equal(ovality, [2.0, 3.0, 4.0, nan])
    np.testing.assert_array_equal(u, [0.3, 0.2, 0.5, nan])


def test_worst_stations_are_sorted_distinct_and_apart_as_far_as_the_pipe_allows():
    generator = np.random.default_rng(3)
    for _ in range(50):
        count = int(generator.integers(1, 40))
        ovality = np.where(generator.random(count) < 0.2, np.nan, generator.random(count))
        axial = np.sort(generator.uniform(0, 3, count))
        rings = {"station": np.arange(count), "axial_m": axial, "ovality_f1216_max_percent": ovality}
        chosen = worst_stations(rings, count=3, apart=0.3)
        assert len(chosen) == len(set(chosen)) == min(3, int(np.isfinite(ovality).sum()))
        assert list(ovality[chosen]) == sorted(ovality[chosen], reverse=True)
        if chosen:
            assert ovality[chosen[0]] == np.nanmax(ovality)
        if len(chosen) > 1 and not abs(axial[chosen[0]] - axial[chosen[1]]) >= 0.3:
            near = np.abs(axial - axial[chosen[0]]) < 0.3
            assert (~np.isfinite(ovality[~near])).sum() + len(chosen) > (~near).sum()


@pytest.mark.parametrize(
    ("clock", "text"),
    [
        (0.0, "12:00 h"),
        (np.pi / 2, "3:00 h"),
        (np.pi, "6:00 h"),
        (-np.pi / 2, "9:00 h"),
        (6.2831, "12:00 h"),
        (0.4, "12:46 h"),
    ],
)
def test_clock_positions_read_as_on_a_clock(clock, text):
    assert clock_text(clock) == text


def _ring_image():
    azimuth = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    u, v = 160 + 80 * np.cos(azimuth), 120 + 80 * np.sin(azimuth)
    rows, columns = np.mgrid[:240, :320]
    distance = np.hypot(columns - 160, rows - 120) - 80
    return (200 * np.exp(-(distance**2) / 8)).astype(np.uint8), u, v


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [None, 3])
def test_points_are_drawn_where_they_were_found_and_missing_rays_outside_the_ring(depth, channels):
    image, u, v = _ring_image()
    image = image.astype(depth) * (257 if depth is np.uint16 else 1)
    image = np.repeat(image[:, :, None], channels, axis=2) if channels else image
    status = np.zeros(300, np.uint8)
    status[20:40], status[290:300], status[0:5] = Status.NO_PEAK, Status.MULTIPLE, Status.MULTIPLE
    missing = status > Status.SATURATED
    seen_u, seen_v = np.where(missing, np.nan, u), np.where(missing, np.nan, v)
    main = detected_line(image, seen_u, seen_v, status).axes[0]
    lines = {str(line.get_label()).split(" (")[0]: line.get_xydata() for line in main.lines}
    np.testing.assert_allclose(lines[MEANING[Status.OK]], np.stack([u, v], axis=1)[~missing])
    for code, count in ((Status.NO_PEAK, 20), (Status.MULTIPLE, 15)):
        places = lines[MEANING[code]]
        assert len(places) == count
        offset = np.stack([160 + OFFSET * (u - 160), 120 + OFFSET * (v - 120)], axis=1)[status == code]
        # The centre is the mean of the points seen, which the gaps move by a few pixels.
        assert np.abs(places - offset).max() < 10
        assert np.hypot(*(places - [160, 120]).T).min() > 80


def test_each_status_has_its_own_mark():
    image, u, v = _ring_image()
    status = np.arange(300) % 3
    main = detected_line(image, u, v, status).axes[0]
    assert len({(line.get_marker(), line.get_color()) for line in main.lines}) == 3


@pytest.mark.parametrize("known", [0, 1, 300])
def test_an_image_with_no_one_or_all_points_is_drawn(known):
    image, u, v = _ring_image()
    status = np.where(np.arange(300) < known, Status.OK, Status.NO_PEAK)
    u[known:], v[known:] = np.nan, np.nan
    figure = detected_line(image, u, v, status)
    figure.canvas.draw()
    assert f"{known} of 300 rays" in figure.texts[1].get_text()


def test_lists_of_unequal_length_are_refused():
    image, u, v = _ring_image()
    with pytest.raises(InputError, match="one length"):
        detected_line(image, u, v[:-1], np.zeros(300))
    with pytest.raises(InputError, match="An image must be"):
        detected_line(np.zeros(5), u, v, np.zeros(300))
