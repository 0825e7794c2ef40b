"""The experiment in small: two instruments, few stations; the steps are those of the whole."""

import json
from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError, OutputError
from calibore.experiment import DRIFTED, EXACT, FRESH, IN_SITU, INCH, PLANS, TABLE_8_2, UNSTATED, Plan, run_experiment
from calibore.reports import write_experiment

SMALL = Plan(
    name="small",
    rings=6,
    ring_step=1.6 * INCH,
    takes=1,
    angles=12,
    stops=3,
    stop_step=1.2 * INCH,
    side_takes=1,
    touched=(50, 200),
    section=3,
    target_takes=1,
    flat_every=6,
    instruments=("plane-12in", "side-2.4in"),
)


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("laboratory") / "experiment"


@pytest.fixture(scope="module")
def found(place):
    counted: list[tuple[int, int]] = []
    outcome = run_experiment(place, SMALL, progress=lambda done, total: counted.append((done, total)))
    assert counted[-1][0] == counted[-1][1]
    assert [done for done, _ in counted] == sorted(done for done, _ in counted)
    return outcome


@pytest.mark.slow
def test_with_an_exact_rig_file_errors_are_as_large_as_predicted(found):
    # 2400 points of 6 rings, 900 of a head: neighbours share noise, so that a third may be missing or left over
    for laser in found.lasers:
        assert 0.8 < laser.on_plain_wall.relative < 1.25
        assert laser.by_truth[EXACT].inside > 0.9
        assert laser.missed < 0.01


@pytest.mark.slow
def test_a_change_that_nobody_states_breaks_the_intervals_and_a_stated_one_does_not(found):
    for laser in found.lasers:
        # one calibration: its error is that of all points, of a head three times as large as their noise
        assert laser.by_truth[FRESH].inside > 0.8
        assert laser.by_truth[UNSTATED].inside < 0.1
        assert laser.by_truth[DRIFTED].inside > 0.9
        assert laser.by_truth[UNSTATED].rms == pytest.approx(laser.by_truth[DRIFTED].rms, rel=0.02)


@pytest.mark.slow
def test_registration_finds_how_the_rig_stood_and_what_it_had_changed_by(found):
    plane = found.of_kind("plane")[0]
    wanted, moved = TABLE_8_2["plane-12in"], plane.registration
    assert abs(np.degrees(moved.motion.roll) - wanted.roll) < 4 * np.degrees(moved.u("roll"))
    assert abs(moved.motion.shift_x / INCH - wanted.shift_x) < 0.003
    assert abs(-moved.motion.shift_y / INCH - wanted.shift_y) < 0.003
    assert abs(plane.scale.value - wanted.scale) < 4 * plane.scale.u
    assert plane.scale.u < 0.001


@pytest.mark.slow
def test_what_is_done_is_not_done_again_and_the_answer_is_the_same(found, place):
    before = {path: path.stat().st_mtime_ns for path in place.rglob("*.toml")}
    again = run_experiment(place, SMALL)
    assert {path: path.stat().st_mtime_ns for path in place.rglob("*.toml")} == before
    for one, two in zip(found.lasers, again.lasers, strict=True):
        np.testing.assert_array_equal(one.by_touch[EXACT].value, two.by_touch[EXACT].value)
    assert not list(place.rglob("plane-12in *.png"))
    assert (IN_SITU, "side-2.4in") in again.calibrations


@pytest.mark.slow
def test_the_page_shows_tables_figures_and_an_answer(found, place):
    facts = write_experiment(found, place)
    assert json.loads((place / "experiment.json").read_text(encoding="utf-8")) == facts
    page = (place / "experiment.html").read_text(encoding="utf-8")
    for words in ("Table 6.1", "Table 7.1", "Table 8.1", "Table 8.2", "Table 8.3", "Figure 6.22", "Figure 8.14"):
        assert words in page
    assert "nan" not in json.dumps(facts["tables"]).lower()
    assert facts["answer"][0].startswith(("Yes", "No"))


@pytest.mark.slow
def test_another_plan_leaves_the_folder_alone(found, place):
    with pytest.raises(OutputError, match="another name, rings"):
        run_experiment(place, PLANS["reduced"])


def test_a_folder_that_holds_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work")
    with pytest.raises(OutputError, match="something else"):
        run_experiment(tmp_path, SMALL)
    assert (tmp_path / "thesis.txt").read_text() == "years of work"


def test_a_plan_without_anything_to_do_is_refused():
    with pytest.raises(InputError, match="at least one"):
        Plan(**{**SMALL.__dict__, "rings": 0})
