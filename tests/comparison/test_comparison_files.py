"""Two inputs that cannot be compared are told so in a sentence; what can be is written whole and finite."""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

sys.path.append(str(Path(__file__).parent))
from compared_walls import DENT, STATIONS, found, only_where, pair, scaled, write_result
from registration_walls import Wall, random_wall, seen

from calibore.comparison import (
    compared,
    difference_dataset,
    is_tactile_result,
    kind_of,
    mirrored,
    numbers,
    write_arrays,
)
from calibore.errors import InputError
from calibore.registration import Motion

NAMES = ("later", "earlier")


def sentence(moving, reference, **options):
    with pytest.raises(InputError) as caught:
        compared(moving, reference, **{"epochs": False, "names": NAMES, **options})
    return str(caught.value)


@pytest.mark.parametrize("factor", [25.4, 12, 0.3048, 1000, 10])
@pytest.mark.parametrize("inverse", [False, True])
def test_wrong_units_are_named_by_their_factor(factor, inverse):
    after, before = pair()
    said = sentence(scaled(after, 1 / factor if inverse else factor), before)
    assert f"factor of {max(factor, 1 / factor):.4g}" in said
    assert "units" in said


def test_a_pipe_of_another_size_is_another_pipe():
    after, before = pair()
    assert "different pipes" in sentence(scaled(after, 1.5), before)


@pytest.mark.parametrize("seed", range(3))
def test_a_clock_that_runs_the_other_way_is_named(seed):
    after, before = pair(seed)
    assert not compared(after, before, epochs=False, names=NAMES).warnings
    assert "later runs against the clock of earlier" in sentence(mirrored(after), before)


def test_mirroring_twice_changes_nothing():
    profile, _ = pair()
    twice = mirrored(mirrored(profile))
    np.testing.assert_allclose(twice.clock, profile.clock, atol=1e-12)
    np.testing.assert_array_equal(twice.radius, profile.radius)
    np.testing.assert_array_equal(twice.common_mode, profile.common_mode)


@pytest.mark.parametrize("seed", range(3))
def test_different_pipes_are_told_from_one_that_is_seen_twice(seed):
    rng = np.random.default_rng([71, seed])
    other = seen(random_wall(rng, length=0.1), STATIONS, rng, positions=200, modes=(3e-4,))
    assert "different pipes" in sentence(other, pair(seed)[1])


def test_a_wall_that_has_changed_nearly_everywhere_is_warned_of_and_not_refused():
    rng = np.random.default_rng(4)
    still = Wall(0.15, np.zeros((0, 3)), np.zeros((0, 5)))
    worn = replace(still, bumps=np.array([[0.05, 1.0, -0.004, 0.03, 0.5], [0.08, 3.0, -0.004, 0.03, 0.5]]))
    before, after = (seen(wall, STATIONS, rng, positions=200) for wall in (still, worn))
    found = compared(after, before, epochs=True)
    assert "nearly everywhere" in found.warnings[0]


def test_a_round_pipe_does_not_tell_its_roll():
    rng = np.random.default_rng(5)
    still = Wall(0.15, np.zeros((0, 3)), np.zeros((0, 5)))
    one, other = (seen(still, STATIONS, rng, positions=200) for _ in range(2))
    warnings = compared(one, other, epochs=False).warnings
    assert "roll" in warnings[-1]


def test_no_overlap_says_what_either_covers():
    after, before = pair()
    away = replace(after, axial=after.axial + 5, axial_position=after.axial_position + 5)
    said = sentence(away, before)
    assert "do not overlap" in said
    assert "earlier has points from" in said
    assert "5000" in said


@pytest.mark.parametrize("along", [True, False])
def test_points_that_are_missing_wherever_the_other_has_some_are_told(along):
    after, before = pair()
    if along:
        first, second = after.axial[:, None] < 0.045, before.axial[:, None] > 0.075
    else:
        first, second = after.clock[None] < 2.5, before.clock[None] > 3.5
    said = sentence(only_where(after, first), only_where(before, second))
    assert ("do not overlap" if along else "hardly a point") in said


def test_the_same_profile_twice_is_fine_and_shows_nothing():
    _, before = pair()
    same = compared(before, before, epochs=True)
    assert np.nanmax(np.abs(same.value)) < 1e-8
    assert same.changes is not None
    assert not same.changes.regions
    assert not same.warnings


def test_with_nothing_free_only_what_is_given_counts():
    after, before = pair()
    known = found(epochs=False).registration.motion
    given = compared(after, before, epochs=False, free=(), start=known, search=False)
    assert given.registration.names == ()
    assert given.agreement.overall.rms == pytest.approx(found(epochs=False).agreement.overall.rms, rel=0.05)
    off = compared(after, before, epochs=False, free=(), start=Motion(), search=False)
    assert off.agreement.overall.rms > 3 * given.agreement.overall.rms
    assert "The motion that was given" in off.warnings[0]


@pytest.mark.parametrize("epochs", [True, False])
def test_what_is_written_is_what_was_found(epochs, tmp_path):
    one = found(epochs=epochs)
    write_arrays(one, tmp_path)
    with xarray.open_zarr(tmp_path / "difference.zarr", chunks=None) as stored:
        assert stored.attrs["format"] == "calibore-difference/1"
        assert stored["difference"].dims == ("station", "clock")
        np.testing.assert_array_equal(stored["difference"], one.difference.value)
        total = stored["u_independent"] ** 2 + stored["missed"] ** 2 + (stored["modes"] ** 2).sum("mode")
        np.testing.assert_allclose(stored["u"], np.sqrt(total), rtol=1e-6)
        assert ("region" in stored) == epochs
        assert set(stored.variables) == set(difference_dataset(one).variables)
    with (tmp_path / "rings.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(one.rings)
    overall = np.average([float(row["rms_m"]) ** 2 for row in rows], weights=[int(row["points"]) for row in rows])
    known = np.isfinite(one.value) & np.isfinite(one.u)
    assert np.sqrt(overall) == pytest.approx(float(np.sqrt(np.mean(one.value[known] ** 2))), rel=1e-6)


def test_a_region_of_change_comes_with_its_rate():
    plain = numbers(found(epochs=True))
    region = plain["regions"][0]
    assert region["depth_m"]["value"] == pytest.approx(-DENT[2], rel=0.25)
    assert region["per_year"]["depth_m"]["value"] == pytest.approx(region["depth_m"]["value"] / 2)
    assert region["per_year"]["depth_m"]["u"] == pytest.approx(region["depth_m"]["u"] / 2)
    assert "regions" not in numbers(found(epochs=False))


def test_a_folder_is_a_result_a_scan_or_refused(tmp_path):
    result = write_result(tmp_path / "result", pair()[0], tactile=True)
    (tmp_path / "scan").mkdir()
    (tmp_path / "scan" / "scan.toml").touch()
    assert [kind_of(result), kind_of(tmp_path / "scan")] == ["result", "scan"]
    assert is_tactile_result(result)
    assert not is_tactile_result(tmp_path)
    for folder, why in ((tmp_path, "neither"), (tmp_path / "nothing", "does not exist")):
        with pytest.raises(InputError, match=why):
            kind_of(folder)


def test_numbers_are_plain_once_written():
    from calibore.reports._calibration_page import plain_numbers

    for epochs in (True, False):
        text = json.dumps(plain_numbers(numbers(found(epochs=epochs))), allow_nan=False)
        assert json.loads(text)["question"] == ("change" if epochs else "error")
