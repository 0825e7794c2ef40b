"""Wrong command lines, and failures that a repaired scan gets over."""

from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import calibore, outcome_of, profile, started
from spoilt import DONE, PARTLY, WRONG_USAGE, images, nothing_was_written, refused, replace, write_key

from calibore.scans import open_profile

WRONG = {
    "estimator": (("--estimator", "best"), ('Estimator "best"', "zero-crossing")),
    "unit": (("--unit", "furlong"), ('Unit "furlong"', '"mm" or "in"')),
    "export format": (("--export", "docx"), ('Export format "docx"', "netcdf")),
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG.keys())
def test_a_wrong_option_value_is_wrong_usage_and_told_the_right_ones(scan, wrong):
    options, words = wrong
    refused(profile(scan, *options), *words, status=WRONG_USAGE)
    assert nothing_was_written(scan)


@pytest.mark.parametrize(
    "arguments",
    [("profile",), ("profile", "scan"), ("profile", "scan", "--out", "out", "--workers", "0"), ("measure",), ()],
    ids=["no scan", "no out", "no workers", "no such verb", "nothing"],
)
def test_a_command_line_that_cannot_be_meant_is_wrong_usage(arguments: tuple[str, ...]):
    outcome = calibore(*arguments)
    assert outcome.status == WRONG_USAGE
    assert outcome.out == ""
    assert outcome.err.startswith("Usage: ")
    assert "Traceback" not in outcome.err


def test_an_export_says_what_is_wrong_with_its_result_and_format(scan, tmp_path):
    refused(calibore("export", tmp_path / "nowhere", "ply"), str(tmp_path / "nowhere"), "give the result folder")
    refused(calibore("export", scan, "ply"), str(scan), "is not a result folder", "`calibore profile` wrote")
    refused(calibore("export", scan, "docx"), 'Export format "docx"', "allowed: csv", status=WRONG_USAGE)


def test_no_failure_shows_a_traceback_in_a_process_of_its_own_either(scan):
    write_key(scan / "rig.toml", '"sine-law"', '"fisheye"')
    outcome = outcome_of(started("profile", scan, "--out", scan.parent / "out"))
    refused(outcome, "camera.lens = 'fisheye'")


@pytest.fixture
def spoil() -> Callable[[Path], None]:
    return lambda path: replace(path, b"")


def test_a_scan_repaired_after_a_refusal_replaces_its_own_partial_result(scan, spoil):
    image = images(scan)[1]
    whole = image.read_bytes()
    spoil(image)
    assert profile(scan).status == PARTLY
    image.write_bytes(whole)
    assert profile(scan).status == DONE
    with open_profile(scan.parent / "out") as dataset:
        assert dataset["station"].values.tolist() == [0, 1, 2, 3]
