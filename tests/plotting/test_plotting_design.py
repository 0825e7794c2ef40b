"""The pictures of a design: labelled in the reader's unit, nothing cut off, the same every time."""

from itertools import islice

import numpy as np
import pytest
from matplotlib.text import Text

from calibore.design import KINDS, Region, Study, analyse
from calibore.plotting import design_pictures, limit_text, parameter_words, save_picture, save_vector
from calibore.plotting._design_maps import SHADES
from calibore.plotting._lengths import length_unit

RADIUS = 0.1524
FEW = ("single-cone", "side-facing", "rotating-spot", "spot-array")


@pytest.fixture(scope="module")
def designs():
    return {name: analyse(Study(name, RADIUS, beams=2)) for name in FEW}


@pytest.fixture(scope="module")
def drawn(designs):
    """All pictures of every design, in mm."""
    return {name: list(design_pictures(design)) for name, design in designs.items()}


def _texts(figure):
    """Every word drawn: labels of axes and colour bars, titles, legends."""
    return [text.get_text() for text in figure.findobj(Text) if text.get_visible()]


def _shown_ticks(axis):
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]


@pytest.mark.parametrize(("configuration", "unit"), [(name, "mm") for name in FEW] + [("rotating-spot", "in")])
def test_every_axis_says_what_it_is_and_in_which_unit(designs, drawn, configuration, unit):
    other = {"mm": "[in]", "in": "[mm]"}[unit]
    for picture in drawn[configuration] if unit == "mm" else design_pictures(designs[configuration], unit=unit):
        assert picture.title
        assert picture.caption
        for axes in picture.figure.axes:
            words = axes.get_xlabel() + axes.get_ylabel()
            shared = not axes.get_xlabel() or not axes.get_ylabel()
            assert words or shared
            assert other not in words
        assert any(f"[{unit}]" in text or "%" in text for text in _texts(picture.figure)), picture.name


@pytest.mark.parametrize("configuration", ["single-cone", "side-facing"])
def test_no_label_is_cut_off(drawn, configuration):
    for picture in drawn[configuration]:
        figure = picture.figure
        figure.canvas.draw()
        page = figure.bbox.padded(2)
        for axes in figure.axes:
            for text in (axes.xaxis.label, axes.yaxis.label, *_shown_ticks(axes.xaxis), *_shown_ticks(axes.yaxis)):
                if text.get_text() and text.get_visible():
                    box = text.get_window_extent()
                    assert page.x0 <= box.x0, (picture.name, text.get_text())
                    assert box.x1 <= page.x1, (picture.name, text.get_text())
                    assert page.y0 <= box.y0, (picture.name, text.get_text())


def test_every_region_of_a_map_is_in_its_legend_and_no_other(designs, drawn):
    design, picture = designs["single-cone"], drawn["single-cone"][0]
    words = " ".join(_texts(picture.figure))
    for region, (_, _, meaning) in SHADES.items():
        assert (meaning in words) == (design.maps[0].fraction(region) > 0)
    assert "nominal radius" in words


def test_regions_differ_without_colour():
    looks = [(face == "none", hatch, face) for face, hatch, _ in SHADES.values()]
    assert len({(filled, hatch) for filled, hatch, _ in looks}) == len(looks)
    assert set(SHADES) == set(Region) - {Region.MEASURED}


def test_the_same_design_gives_the_same_bytes(designs, tmp_path):
    files = []
    for number in (1, 2):
        for picture in islice(design_pictures(designs["rotating-spot"]), 4):
            png = save_picture(picture.figure, tmp_path / f"{picture.name}_{number}.png")
            svg = save_vector(picture.figure, tmp_path / f"{picture.name}_{number}.svg")
            files.append((png.read_bytes(), svg.read_bytes()))
    half = len(files) // 2
    assert files[:half] == files[half:]


def test_a_map_shows_what_was_predicted(designs, drawn):
    design, figure = designs["side-facing"], drawn["side-facing"][0].figure
    shown = figure.axes[0].images[0].get_array()
    np.testing.assert_allclose(shown, design.maps[0].prediction.radius * 1e3, rtol=1e-12)


def test_numbers_are_told_as_people_say_them():
    scale = length_unit("in")
    assert limit_text(0.00254, "m", scale) == "0.1 in"
    assert limit_text(np.radians(0.5), "rad", scale) == "0.5 deg"
    assert limit_text(0.25, "px", scale) == "0.25 px"
    assert limit_text(None, "m", scale) == "any"
    assert parameter_words("laser.half_angle") == "half angle (laser)"
    assert set(FEW) <= set(KINDS)
