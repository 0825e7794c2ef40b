"""What the tables and figures are drawn from: laws, not looks."""

import numpy as np
import pytest

from calibore.plotting import published_number, published_picture
from calibore.published import PICTURES, Chart, Map, Region
from calibore.published._cone_angles import figure_3_3
from calibore.published._cone_maps import table_3_2
from calibore.published._cone_numbers import parallel_azimuth, touching_azimuth
from calibore.published._cone_profiles import figure_3_19, figure_3_22
from calibore.published._cone_roots import figure_3_10, figure_3_12
from calibore.published._cone_views import View, both_radii, regions, whole_view
from calibore.published._plane_pictures import figure_4_6, table_4_1
from calibore.published._printed import conjugate_solutions
from calibore.published._side_pictures import table_5_1, table_5_2

KNOWN_DEVIATIONS = {
    "figure_3_03": 1,
    "figure_3_04": 1,
    "figure_3_10": 1,
    "figure_3_12": 1,
    "table_3_01": 1,
    "figure_3_22": 1,
    "table_4_02": 1,
    "table_5_02": 1,
    "figure_5_06": 1,
}
"""Pictures with statements of the text that do not hold; each is explained on the page."""


@pytest.fixture(scope="module")
def pictures():
    return [build() for build in PICTURES]


def test_every_picture_of_the_chapters_on_uncertainty_is_there(pictures):
    tables = {f"Table {n}" for n in ("3.1", "3.2", "3.3", "4.1", "4.2", "5.1", "5.2")}
    three = (3, 4, 10, 11, 12, 15, 16, 17, 19, 20, 21, 22, 23)
    figures = {f"Figure 3.{n}" for n in three} | {f"Figure {c}.{n}" for c in (4, 5) for n in (3, 4, 5, 6)}
    assert {published_number(picture.name) for picture in pictures} == tables | figures
    assert len(pictures) == 28


def test_what_the_text_says_holds_but_for_the_known_deviations(pictures):
    false = {one.name: sum(claim.holds is False for claim in one.claims) for one in pictures}
    assert {name: count for name, count in false.items() if count} == KNOWN_DEVIATIONS
    assert all(claim.says and claim.ours for one in pictures for claim in one.claims)


def test_every_curve_has_numbers_inside_its_axes(pictures):
    for picture in pictures:
        for chart in (panel for row in picture.panels for panel in row if isinstance(panel, Chart)):
            for curve in chart.curves:
                low, high = (chart.right_limits if curve.right else chart.y_limits) or (-np.inf, np.inf)
                assert ((curve.y >= low) & (curve.y <= high)).mean() > 0.2, (picture.name, curve.label)


def test_a_map_has_a_value_exactly_where_its_region_says(pictures):
    for picture in pictures:
        for one in (panel for row in picture.panels for panel in row if isinstance(panel, Map)):
            measured = one.regions == Region.MEASURED
            assert np.isfinite(one.values[measured & (one.regions != Region.UNSEEN)]).mean() > 0.999, picture.name
            assert measured.any()


def test_the_conjugate_solutions_are_our_two_meetings():
    rng = np.random.default_rng(1)
    for D, L in zip(rng.uniform(0.15, 0.85, 8), rng.uniform(0.4, 4, 8), strict=True):
        view: View = whole_view(float(D), float(L))
        angles = {"aim": view.cone.aim, "half_angle": view.cone.half_angle}
        both = conjugate_solutions(view.zenith, view.azimuth, baseline=D, **angles)
        near, far = both_radii(view)
        for ours, theirs in ((near, both.second), (far, both.first)):
            seen = np.isfinite(ours) & (both.discriminant > 1e-6)
            assert seen.any()
            assert np.allclose(ours[seen], theirs[seen], rtol=1e-6)
        region = regions(view)
        assert (both.discriminant[region == Region.COMPLEX] < 0).all()
        behind = region == Region.NEGATIVE
        assert ((both.first[behind] < 0) & (both.second[behind] < 0)).all()


def test_the_printed_rule_loses_the_wall_in_the_band_and_nowhere_else():
    chart = figure_3_12().panels[0][2]
    assert isinstance(chart, Chart)
    printed, ours = chart.curves
    touching, parallel = touching_azimuth(0.5, 1.0), parallel_azimuth(0.5, 1.0)
    inside = (printed.x > parallel + 0.05) & (printed.x < touching - 0.05)
    assert (printed.y[inside] > 1.001).all()
    outside = (printed.x < parallel - 0.05) | (printed.x > touching + 0.05)
    assert np.allclose(printed.y[outside], 1.0, atol=1e-9)
    assert np.allclose(ours.y, 1.0, atol=1e-9)


def test_the_composite_is_the_better_of_both_lasers():
    crown, side, composite = figure_3_19().panels[0][0].curves
    assert np.allclose(composite.y, np.fmin(crown.y, side.y), rtol=1e-12)


def test_colour_bars_of_chapter_5_end_where_the_source_prints_its_ends():
    radius = [row[0] for row in table_5_1().panels]
    assert [round(one.low, 2) for one in radius] == [0.62, 0.75, 0.87]
    uncertainty = [row[0] for row in table_5_2().panels]
    assert [(round(one.low, 4), round(one.high, 4)) for one in uncertainty] == [
        (0.0029, 0.0159),
        (0.0018, 0.0068),
        (0.0015, 0.0042),
    ]


@pytest.mark.parametrize(
    "build", [figure_3_3, figure_3_10, figure_3_12, figure_3_22, figure_4_6, table_3_2, table_4_1, table_5_1]
)
def test_no_word_of_a_picture_is_cut_off(build):
    figure = published_picture(build())
    figure.draw_without_rendering()
    inside = figure.bbox
    words = [*figure.texts, *(text for legend in figure.legends for text in legend.get_texts())]
    for axes in figure.axes:
        words += [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts]
    words = [word for word in words if word.get_text().strip()]
    assert len(words) > 4
    for word in words:
        box, name = word.get_window_extent(), word.get_text()
        assert box.x0 >= inside.x0 - 1, name
        assert box.x1 <= inside.x1 + 1, name
        assert box.y0 >= inside.y0 - 1, name
        assert box.y1 <= inside.y1 + 1, name
