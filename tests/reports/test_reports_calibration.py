"""Pages of calibrations and of differences: whole or not there, needing nothing but themselves."""

import json
import re
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from calibore.calibration import InputFile, PlannedBoard, PlannedFlats, difference, plan
from calibore.errors import InputError, OutputError
from calibore.plotting import plain_text
from calibore.reports import write_calibration_page, write_difference_page, write_plan_page

sys.path.insert(0, str(Path(__file__).parents[1] / "calibration"))
from made_calibrations import INCH, RADIUS, board_calibration, known, moved, plane_rig, published_head, rig_calibration


class _Outline(HTMLParser):
    def __init__(self, page):
        super().__init__()
        self.tags, self.words = [], []
        self.feed(re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL))

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("pages") / "calibration"
    said = replace(rig_calibration(1), warnings=("Only two tilts: photograph <more>.",))
    refused = InputFile("board 99.png", "0" * 64, "blurred by 5 px")
    lit = InputFile("board 98.png", "0" * 64, set_aside="with room light")
    assert write_calibration_page(replace(said, files=(*said.files, refused, lit)), out) == out / "calibration.html"
    return out


def test_the_page_needs_nothing_but_itself(folder):
    page = (folder / "calibration.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://|url\(|@import", page)
    outline = _Outline(page)
    assert not {tag for tag, _ in outline.tags} & {"script", "link", "iframe", "object"}
    images = [attributes for tag, attributes in outline.tags if tag == "img"]
    assert len(images) == 7
    assert all(one["src"].startswith("data:image/png;base64,") and one["alt"] for one in images)


def test_the_page_says_what_a_reader_must_not_miss(folder):
    text = _Outline((folder / "calibration.html").read_text(encoding="utf-8")).text
    for words in (
        "Only two tilts: photograph <more>.",
        "From 14 of 16 files",
        "board 99.png",
        "blurred by 5 px",
        "Half against half",
        "if correlations were ignored",
        "describes this lens best",
        "principal point u (camera)",
        "stereographic",
        "radius 106.7 to 190.5 mm",
    ):
        assert words in text


def test_beside_the_page_stand_pictures_and_numbers(folder):
    plain = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))
    assert sorted(path.name for path in folder.iterdir()) == plain["files"]
    calibration = rig_calibration(1)
    np.testing.assert_allclose(plain["covariance"]["matrix"], calibration.covariance.matrix, rtol=1e-8)
    assert plain["parameters"]["camera.k"] == pytest.approx(calibration.values["camera.k"])
    assert plain["halves"]["parts"] == ["pictures", 7, 7]
    assert len(plain["wall"]["radius"]) == len(plain["wall"]["u"])


def test_a_second_run_replaces_the_first_and_nothing_else(tmp_path):
    out, lens = tmp_path / "page", board_calibration(1)
    found = difference(lens, lens)
    write_difference_page(found, out)
    first = (out / "difference.html").read_bytes()
    write_difference_page(found, out)
    assert (out / "difference.html").read_bytes() == first
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        write_difference_page(found, out)
    assert (out / "notes.txt").exists()


def test_a_page_that_cannot_be_finished_leaves_nothing(tmp_path):
    with pytest.raises(InputError, match="miles"):
        write_calibration_page(board_calibration(1), tmp_path / "page", unit="miles")
    assert not list(tmp_path.iterdir())


def test_without_evidence_the_page_says_so(tmp_path):
    calibration = board_calibration(1)
    seen = calibration.observations
    arrays = ("file", "u", "v", "residual", "sigma", "weight", "group", "jacobian")
    none = replace(seen, **{name: getattr(seen, name)[:0] for name in arrays})
    page = write_calibration_page(replace(calibration, observations=none), tmp_path / "page")
    assert "no evidence of a camera to part into halves" in _Outline(page.read_text(encoding="utf-8")).text


def test_the_page_of_a_difference_answers_and_names_what_changed(tmp_path):
    head = published_head()
    found = difference(head, moved(head, {"camera.k": 0.0258 * 3183.099}), nominal_radius=RADIUS)
    page = write_difference_page(found, tmp_path / "page", unit="in")
    assert page == tmp_path / "page" / "difference.html"
    text = _Outline(page.read_text(encoding="utf-8")).text
    for words in ("This is not the same camera as before", "+2.58 %", "p < 0.001", "6 in", "k (camera)", "3265.223"):
        assert words in text
    plain = json.loads((page.parent / "difference.json").read_text(encoding="utf-8"))
    assert plain["changes"][0]["name"] == "camera.k"
    assert plain["wall"]["mean"][0] is None  # 0.6 nominal radii are outside the picture
    assert sorted(path.name for path in page.parent.iterdir()) == plain["files"]


def test_the_page_of_a_plan_names_the_best_picture_and_ranks_the_others(tmp_path):
    found = plan(published_head(), PlannedFlats(tuple(np.arange(4, 13) * 0.5 * INCH)), nominal_radius=RADIUS)
    page = write_plan_page(found, tmp_path / "page", unit="in")
    assert page == tmp_path / "page" / "plan.html"
    outline = _Outline(page.read_text(encoding="utf-8"))
    first = found.steps[0].shot.said("in")
    assert f"The best next picture of the target: {first}. It brings u of the radius" in outline.text
    assert f"1. {first} {plain_text(found.steps[0].u / INCH)} in" in outline.text
    assert sum(tag == "img" for tag, _ in outline.tags) == 2
    assert outline.text.count("leaning") == 0
    rows = sum(tag == "tr" for tag, _ in outline.tags)
    assert rows == 2 + len(found.steps) + len(found.ranking)
    plain = json.loads((page.parent / "plan.json").read_text(encoding="utf-8"))
    assert [one["u"] for one in plain["ranking"]] == sorted(one["u"] for one in plain["ranking"])
    assert plain["steps"][0]["distance"] == pytest.approx(found.steps[0].shot.distance)
    assert sorted(path.name for path in page.parent.iterdir()) == plain["files"]


def test_a_plan_of_a_target_that_tells_nothing_more_says_so(tmp_path):
    board, words = PlannedBoard(9, 7, 0.02), "More pictures of this target hardly help"
    for size, told in ((1e-4, True), (1.0, False)):
        found = plan(known(plane_rig(), size=size), board, nominal_radius=RADIUS, count=1)
        assert (words in found.advice("in")) == told
        if told:
            assert words in _Outline(write_plan_page(found, tmp_path / "page").read_text(encoding="utf-8")).text
            assert "(no less)" in found.advice()


@pytest.mark.parametrize(
    ("value", "digits", "said"),
    [(7.9999e-5, 3, "0.0000800"), (620.0, 3, "620"), (1234.5, 3, "1230"), (-0.1, 2, "-0.10"), (1e-13, 3, "0")],
)
def test_numbers_are_written_without_exponents(value, digits, said):
    assert plain_text(value, digits) == said
