"""The pictures of calibrations: labelled in the reader's unit, nothing cut off, showing what was computed."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from calibore.calibration import Comparison, PlannedFlats, difference, plan, wall_uncertainty
from calibore.plotting import calibration_pictures, difference_pictures, plan_pictures, save_picture
from calibore.plotting._calibration_parts import OUTSIDE

sys.path.insert(0, str(Path(__file__).parents[1] / "calibration"))
from made_calibrations import RADIUS, board_calibration, moved, published_head, rig_calibration

ALWAYS = ["projection", "residual_map", "residuals", "correlations", "models"]


@pytest.fixture(scope="module")
def drawn():
    """All pictures in mm, by what they are of."""
    head = published_head()
    changed = difference(head, moved(head, {"camera.k": 80.0}), nominal_radius=RADIUS)
    planned = plan(head, PlannedFlats((0.12, 0.16, 0.2)), nominal_radius=RADIUS)
    return {
        "rig": list(calibration_pictures(rig_calibration(1))),
        "lens": list(calibration_pictures(board_calibration(1))),
        "difference": list(difference_pictures(changed)),
        "plan": list(plan_pictures(planned)),
    }


def _texts(figure):
    return [text.get_text() for text in figure.findobj(Text) if text.get_visible() and text.get_text()]


def _shown_ticks(axis):
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]


def test_every_kind_of_calibration_has_its_pictures(drawn):
    assert [one.name for one in drawn["rig"]] == ["wall", "wall_map", *ALWAYS]
    assert [one.name for one in drawn["lens"]] == ALWAYS
    assert [one.name for one in drawn["difference"]] == ["directions", "wall_difference", "changes"]
    assert [one.name for one in drawn["plan"]] == ["plan", "ranking"]


def test_every_axis_says_what_it_is_and_in_which_unit(drawn):
    for picture in (one for group in drawn.values() for one in group):
        assert picture.title
        assert picture.caption
        for axes in picture.figure.axes:
            assert axes.get_xlabel() or axes.get_ylabel() or picture.name == "correlations", picture.name
        words = " ".join(_texts(picture.figure))
        assert "[in]" not in words
        assert any(unit in words for unit in ("mm", "px", "%", "per cent")), picture.name


def test_inches_are_shown_where_they_are_asked_for():
    for picture in calibration_pictures(rig_calibration(1), unit="in"):
        assert "[mm]" not in " ".join(_texts(picture.figure))


@pytest.mark.parametrize("group", ["rig", "difference", "plan"])
def test_no_label_is_cut_off(drawn, group):
    for picture in drawn[group]:
        figure = picture.figure
        figure.canvas.draw()
        page = figure.bbox.padded(2)
        for axes in figure.axes:
            ticks = (*_shown_ticks(axes.xaxis), *_shown_ticks(axes.yaxis))
            for text in (axes.xaxis.label, axes.yaxis.label, *ticks, *axes.texts):
                if text.get_text() and text.get_visible():
                    box = text.get_window_extent()
                    assert page.x0 <= box.x0, (picture.name, text.get_text())
                    assert box.x1 <= page.x1, (picture.name, text.get_text())
                    assert page.y0 <= box.y0, (picture.name, text.get_text())


@pytest.mark.parametrize("count", [2, 5])
def test_legends_of_models_are_inside_and_name_only_what_is_drawn(count):
    one = Comparison("nothing moved", 3, 0.2, 1.0, 2.0, float("nan"))
    models = tuple(replace(one, model=f"model {number}", bic=2.0 + number) for number in range(count))
    figure = next(
        picture.figure
        for picture in calibration_pictures(replace(board_calibration(1), models=models))
        if picture.name == "models"
    )
    figure.canvas.draw()
    for legend in figure.legends:
        box = legend.get_window_extent()
        assert figure.bbox.y0 <= box.y0
        assert box.y1 <= figure.bbox.y1
    assert [text.get_text() for legend in figure.legends for text in legend.get_texts()] == [
        "rms of residuals",
        "AICc",
        "BIC",
    ]
    assert "cross-validated" not in " ".join(_texts(figure))


def test_arrows_of_a_difference_stay_inside_the_frame_and_bars_say_how_far_they_were_cut(drawn):
    directions, _, changes = (one.figure for one in drawn["difference"])
    axes = directions.axes[0]
    arrows = axes.collections[0]
    tips = np.stack([arrows.X + arrows.U / arrows.scale, arrows.Y + arrows.V / arrows.scale], axis=1)
    low, high = np.sort([axes.get_xlim(), axes.get_ylim()], axis=1).T
    assert (tips >= low).all()
    assert (tips <= high).all()
    for number, text in enumerate(changes.axes[0].texts):
        assert float(text.get_text()) > 99, number


def test_the_wall_shows_what_was_computed_with_and_without_correlations(drawn):
    rig = rig_calibration(1).rig
    true, alone = drawn["rig"][0].figure.axes[0].lines[:2]
    found = wall_uncertainty(rig, radii=np.asarray(true.get_xdata()) / 1e3)
    np.testing.assert_allclose(true.get_ydata(), 2e3 * found.mean)
    np.testing.assert_allclose(alone.get_ydata(), 2e3 * found.mean_uncorrelated)


def test_what_is_extrapolated_is_marked_and_named(drawn):
    for picture in drawn["rig"][:3]:
        assert any(OUTSIDE in text for text in _texts(picture.figure)), picture.name
    unlimited = replace(board_calibration(1), valid=None)
    for picture in calibration_pictures(unlimited):
        assert not any(OUTSIDE in text for text in _texts(picture.figure))


def test_residuals_of_marks_with_two_coordinates_are_arrows_others_dots(drawn):
    calibration = board_calibration(1)
    (arrows,) = drawn["lens"][1].figure.axes[0].findobj(Quiver)
    seen = calibration.observations
    assert seen.residual.size // 2 == arrows.N
    np.testing.assert_allclose(
        np.sort(np.hypot(arrows.U, arrows.V)), np.sort(np.hypot(*seen.residual.reshape(-1, 2).T))
    )
    one_less = replace(seen, weight=np.r_[0.0, np.ones(seen.weight.size - 1)])
    figure = list(calibration_pictures(replace(calibration, observations=one_less)))[1].figure
    assert not figure.findobj(Quiver)
    assert len(figure.axes[0].collections[0].get_offsets()) == seen.residual.size - 1


def test_parameters_are_named_in_words(drawn):
    words = " ".join(_texts(drawn["rig"][5].figure))
    assert "principal point u (camera)" in words
    assert "camera." not in words


def test_the_correlations_drawn_are_those_of_the_covariance(drawn):
    shown = drawn["rig"][5].figure.axes[0].images[0].get_array()
    np.testing.assert_allclose(shown, rig_calibration(1).covariance.correlations)


def test_the_same_numbers_give_the_same_bytes(tmp_path):
    planned = plan(published_head(), PlannedFlats((0.12, 0.16, 0.2)), nominal_radius=RADIUS)
    files = [
        [save_picture(one.figure, tmp_path / f"{number}.png").read_bytes() for one in plan_pictures(planned)]
        for number in (1, 2)
    ]
    assert files[0] == files[1]


def test_a_calibration_without_evidence_or_camera_still_has_pictures():
    calibration = board_calibration(1)
    seen = calibration.observations
    arrays = ("file", "u", "v", "residual", "sigma", "weight", "group", "jacobian")
    none = replace(seen, **{name: getattr(seen, name)[:0] for name in arrays})
    names = [one.name for one in calibration_pictures(replace(calibration, observations=none))]
    assert names == ["projection", "correlations", "models"]
    bare = replace(calibration, camera=None, rig=None, models=())
    assert [one.name for one in calibration_pictures(bare)] == ["residuals", "correlations"]
