"""Pictures of comparisons show what was found, whichever the question, and the same each time."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "comparison"))
from compared_walls import found, pair

from calibore.comparison import compared
from calibore.plotting import comparison_pictures, save_picture

NAMES = ["difference", "significance", "registration", "histogram", "radius", "rings"]


@pytest.fixture(scope="module", params=[True, False], ids=["change", "error"])
def drawn(request):
    return request.param, {one.name: one for one in comparison_pictures(found(epochs=request.param), unit="in")}


def texts(figure):
    return " ".join(
        [one.get_text() for one in figure.texts]
        + [axes.get_ylabel() + axes.get_xlabel() + " ".join(t.get_text() for t in axes.texts) for axes in figure.axes]
    )


def test_every_picture_is_there_with_title_caption_and_units(drawn):
    _, pictures = drawn
    assert list(pictures) == NAMES
    for one in pictures.values():
        assert one.title
        assert one.caption
    for name in ("difference", "registration", "histogram", "radius", "rings"):
        assert "[in]" in texts(pictures[name].figure)


def test_regions_are_numbered_on_the_map_of_change_only(drawn):
    epochs, pictures = drawn
    for name in ("difference", "significance"):
        numbers = [t.get_text() for t in pictures[name].figure.axes[0].texts]
        assert numbers == (["1"] if epochs else [])


def test_colours_of_a_map_are_symmetrical(drawn):
    _, pictures = drawn
    for name in ("difference", "significance"):
        low, high = pictures[name].figure.axes[-1].get_ylim()
        assert low == pytest.approx(-high)


def test_the_registration_shows_what_it_took_away(drawn):
    """Before, rings differ by the shift; after, by noise."""
    _, pictures = drawn
    right = pictures["registration"].figure.axes[3]
    before, after = (np.nanstd(line.get_ydata()) for line in right.lines[:2])
    assert before > 3 * after


def test_the_same_comparison_gives_the_same_picture(tmp_path):
    made = []
    for n in range(2):
        pictures = comparison_pictures(found(epochs=True))
        made.append([save_picture(next(pictures).figure, tmp_path / f"{n}.png").read_bytes() for _ in range(2)])
    assert made[0] == made[1]


def test_a_single_ring_can_be_shown():
    after, before = pair()
    one = compared(after.rings(slice(4, 5)), before, epochs=True, free=("roll", "shift_x", "shift_y", "axial"))
    assert [picture.name for picture in comparison_pictures(one)] == NAMES[:-1]
