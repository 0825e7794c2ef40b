"""`calibore compare`: the right question by itself, options that mean what they say, mistakes in one sentence."""

import json
import sys
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "comparison"))
sys.path.append(str(Path(__file__).parents[1] / "system"))
from command_line import calibore
from compared_walls import misread, pair, scaled, write_result

from calibore.cli._compare_options import alignment_of, outlier_rule_of, years_between
from calibore.comparison import mirrored
from calibore.errors import InputError

DONE, UNUSABLE, WRONG_USAGE = 0, 1, 2


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Folders of results: before, after (with a dent), touched, and what cannot be compared with them."""
    folder = tmp_path_factory.mktemp("results")
    after, before = pair(dented=True)
    write_result(folder / "before", before)
    write_result(folder / "after", after)
    write_result(folder / "earlier", replace(before, date=date(2024, 1, 1)))
    write_result(folder / "later", replace(after, date=date(2026, 1, 1)))
    write_result(folder / "touched", pair()[1], tactile=True)
    write_result(folder / "measured", pair()[0])
    write_result(folder / "inches", scaled(before, 25.4))
    write_result(folder / "odometer", misread(before, 25.4))
    write_result(folder / "turned", mirrored(after))
    return folder


@pytest.fixture
def compare(results, tmp_path):
    """The command without pictures, its result in `tmp_path`/out."""

    def run(one, other, *more, out=tmp_path / "out", pictures=False):
        quiet = () if pictures else ("--no-pictures",)
        return calibore("compare", results / one, results / other, "--out", out, *quiet, *more)

    return run


def summary(out):
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


def test_two_epochs_are_asked_for_change_first_before_then_after(compare, tmp_path):
    done = compare("before", "after", "--date-a", "2024-01-01", "--date-b", "2026-01-01", pictures=True)
    assert done.status == DONE, done.err
    assert done.out.startswith("The wall has changed at one place: radius -")
    assert "per year" in done.out
    found = summary(tmp_path / "out")
    assert (found["question"], found["moving"], found["reference"]) == ("change", "after", "before")
    assert found["years"] == pytest.approx(2.0, abs=0.005)
    assert (tmp_path / "out" / "report.html").exists()


def test_days_that_the_scans_know_themselves_make_a_rate(compare, tmp_path):
    assert "per year" in compare("earlier", "later").out
    assert summary(tmp_path / "out")["years"] == pytest.approx(2.0, abs=0.005)
    assert "exchange both" in compare("later", "earlier", out=tmp_path / "again").sentence
    assert "per year" not in compare("earlier", "after", out=tmp_path / "again").out


def test_one_day_alone_makes_no_rate(compare):
    failed = compare("before", "after", "--date-a", "2024-01-01")
    assert failed.status != DONE
    assert failed.sentence.endswith("give --date-b too, or date in the scan.toml of B.")


@pytest.mark.parametrize(("one", "other"), [("measured", "touched"), ("touched", "measured")])
def test_a_tactile_scan_is_the_reference_in_either_order(compare, tmp_path, one, other):
    done = compare(one, other)
    assert done.status == DONE, done.err
    found = summary(tmp_path / "out")
    assert (found["question"], found["moving"], found["reference"]) == ("error", "measured", "touched")
    assert found["errors"]["inside_95"] > 0.9


def test_the_reference_can_be_named(compare, tmp_path):
    assert compare("before", "after", "--reference", "b", "--outliers", "4 sigma").status == DONE
    found = summary(tmp_path / "out")
    assert (found["question"], found["moving"], found["reference"]) == ("error", "before", "after")
    assert found["outlier_rule"] == {"limit_m": None, "sigma": 4.0}


def test_json_is_the_summary_and_nothing_else(compare, tmp_path):
    done = compare("measured", "touched", "--json", "--unit", "in")
    assert json.loads(done.out) == summary(tmp_path / "out")


def test_values_given_by_hand_are_kept(compare, tmp_path):
    assert compare("measured", "touched").status == DONE
    motion = summary(tmp_path / "out")["registration"]["motion"]
    turn = np.degrees(motion["roll"])
    given = f"roll={turn} deg, shift_x={motion['shift_x']} m, shift_y={motion['shift_y']} m, axial={motion['axial']} m"
    assert compare("measured", "touched", "--start", given, "--free", "none").status == DONE
    found = summary(tmp_path / "out")["registration"]
    assert found["u"] == {}
    assert found["motion"]["roll"] == pytest.approx(motion["roll"])


def test_rings_may_move_alone(compare, tmp_path):
    assert compare("measured", "touched", "--per-ring").status == DONE
    assert np.shape(summary(tmp_path / "out")["registration"]["drift"]) == (10, 3)


def test_the_same_folder_twice_differs_by_nothing(compare, tmp_path):
    done = compare("before", "before")
    assert done.status == DONE
    assert done.out.startswith("No significant change")
    assert summary(tmp_path / "out")["errors"]["rms_m"] < 1e-8


@pytest.mark.parametrize(
    ("one", "other", "why"),
    [
        ("inches", "before", "factor of 25.4"),
        ("odometer", "before", "along the pipe differ by a factor of 25.4"),
        ("turned", "before", "against the clock"),
        (".", "before", "neither a result folder"),
        ("nothing", "before", "does not exist"),
    ],
)
def test_what_cannot_be_compared_is_said_and_nothing_overwritten(compare, tmp_path, one, other, why):
    assert compare("measured", "touched").status == DONE
    before = (tmp_path / "out" / "summary.json").read_bytes()
    failed = compare(one, other)
    assert failed.status == UNUSABLE
    assert why in failed.sentence
    assert (tmp_path / "out" / "summary.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--reference", "c"), "a, b or none"),
        (("--free", "roll,pitch"), "pitch"),
        (("--start", "roll 3"), "roll=0.3 deg"),
        (("--start", "roll=3"), "unit"),
        (("--outliers", "wide"), "length"),
        (("--false-alarm", "2"), "between 0 and 1"),
        (("--unit", "furlong"), "furlong"),
        (("--date-a", "2024-01-01", "--date-b", "2023-01-01"), "not later than"),
        (("--date-a", "soon", "--date-b", "2023-01-01"), "no date"),
        (("--reference", "a", "--date-a", "2024-01-01", "--date-b", "2025-01-01"), "rate of change"),
        (("--free", "none", "--per-ring"), "per-ring"),
    ],
)
def test_wrong_options_are_told_before_anything_is_read(compare, options, why):
    failed = compare("before", "after", *options)
    assert failed.status == WRONG_USAGE
    assert why in failed.sentence


def test_the_result_is_not_put_where_its_inputs_are(compare, results):
    assert "choose another --out" in compare("before", "after", out=results).sentence
    assert (results / "before" / "profile.zarr").exists()


def test_options_become_arguments_in_si():
    given = alignment_of("roll, axial", "roll=90 deg, axial=2 mm, scale=1.01", search=True, per_ring=False)
    assert given["free"] == ("roll", "axial")
    start = given["start"]
    assert (start.roll, start.axial, start.scale) == pytest.approx((np.pi / 2, 0.002, 1.01))
    assert not alignment_of("none", "", search=True, per_ring=False)["search"]
    assert outlier_rule_of("0.15 in").limit == pytest.approx(0.00381)
    assert years_between(date(2024, 1, 1), date(2025, 1, 1)) == pytest.approx(1.002, abs=1e-3)
    with pytest.raises(InputError, match="positive"):
        alignment_of("rigid", "scale=0", search=True, per_ring=False)
