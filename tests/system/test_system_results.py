"""What a result folder holds, as formats.md (section 4) promises it to other programs."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import zarr
from command_line import calibore, profile
from conftest import RADIUS, STEP, small_survey
from PIL import Image

from calibore import __version__
from calibore.scans import open_points, open_profile, read_rings
from calibore.simulation import simulate_scan
from calibore.status import Status

NUMBERS = (7, 8, 300, 301)
TAKES = 2
PROFILE = {
    "station": (("station",), None),
    "axial": (("station",), "m"),
    "clock": (("clock",), "rad"),
    "radius": (("station", "clock"), "m"),
    "axial_position": (("station", "clock"), "m"),
    "u_independent": (("station", "clock"), "m"),
    "u_common": (("station", "clock"), "m"),
    "common_mode": (("mode", "station", "clock"), "m"),
    "status": (("station", "clock"), None),
    "centre_x": (("station",), "m"),
    "centre_y": (("station",), "m"),
    "u_centre_x": (("station",), "m"),
    "u_centre_y": (("station",), "m"),
}
POINTS = {
    "x": "m",
    "y": "m",
    "z": "m",
    "radius": "m",
    "clock": "rad",
    "axial": "m",
    "u_radius": "m",
    "u": "pixel",
    "v": "pixel",
    "station": None,
    "take": None,
    "status": None,
}
EXPORTS = ("text3", "csv", "netcdf", "ply", "las", "laz")


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two takes at four stations with numbers of their own; at the first the line is hidden on the right hand side."""
    folder = simulate_scan(tmp_path_factory.mktemp("results") / "survey", small_survey(takes=TAKES), seed=5)
    for path in sorted(folder.glob("*.png")):
        station, take = (int(word) for word in path.stem.split()[1:])
        path.rename(folder / f"pipe {NUMBERS[station]:03d} {take}.png")
    for path in folder.glob("pipe 007 *.png"):
        pixels = np.array(Image.open(path))
        pixels[60:150, 200:] = 0
        Image.fromarray(pixels).save(path)
    return folder


@pytest.fixture(scope="module")
def out(survey: Path) -> Path:
    """Its result with all exports, without pictures."""
    exports = [word for name in EXPORTS for word in ("--export", name)]
    outcome = profile(survey, *exports)
    assert (outcome.status, outcome.err) == (0, "")
    return survey.parent / "out"


def test_the_profile_has_the_promised_dimensions_units_and_coordinates(out):
    with open_profile(out) as dataset:
        for name, (dimensions, units) in PROFILE.items():
            assert dataset[name].dims == dimensions
            assert dataset[name].attrs.get("units") == units
        assert {"station", "axial", "clock"} <= set(dataset.coords)
        assert dataset["radius"].dtype == np.float64
        assert dataset["status"].dtype == np.uint8
    assert zarr.open_group(out / "profile.zarr", mode="r").metadata.zarr_format == 3


def test_stations_are_the_numbers_in_the_file_names_and_lie_where_the_motion_says(out):
    with open_profile(out) as dataset:
        assert dataset["station"].values.tolist() == list(NUMBERS)
        assert dataset["axial"].values == pytest.approx(STEP * np.array(NUMBERS))
    rings = read_rings(out)
    assert rings["station"].tolist() == list(NUMBERS)
    assert rings["axial_m"] == pytest.approx(STEP * np.array(NUMBERS))


def test_clock_positions_are_400_from_the_crown(out):
    with open_profile(out) as dataset:
        assert np.degrees(dataset["clock"].values) == pytest.approx(np.arange(400) * 0.9, abs=1e-12)


def test_the_status_says_what_its_numbers_mean(out):
    for opened in (open_profile, open_points):
        with opened(out) as dataset:
            attributes = dataset["status"].attrs
            assert list(attributes["flag_values"]) == [int(status) for status in Status]
            assert attributes["flag_meanings"].split() == [status.name.lower() for status in Status]


def test_a_position_has_numbers_exactly_where_its_status_carries_a_value(out):
    with open_profile(out) as dataset:
        valued = dataset["status"].values <= Status.SATURATED
        assert not valued.all()
        assert valued.mean() > 0.9
        for name in ("radius", "axial_position", "u_independent", "u_common"):
            assert np.array_equal(np.isfinite(dataset[name].values), valued)
        assert all(np.array_equal(np.isfinite(mode), valued) for mode in dataset["common_mode"].values)


def test_what_is_hidden_is_missing_and_what_is_seen_is_right(out):
    with open_profile(out) as dataset:
        first, others = dataset["radius"].values[0], dataset["radius"].values[1:]
        right = np.abs(np.degrees(dataset["clock"].values) - 90) < 20
        assert np.isnan(first[right]).all()
        assert np.isfinite(others).mean() > 0.99
        assert np.nanmean(dataset["radius"].values, axis=1) == pytest.approx(RADIUS, rel=0.005)


def test_the_common_uncertainty_is_the_root_of_the_sum_of_its_squared_modes(out):
    with open_profile(out) as dataset:
        modes, common = dataset["common_mode"].values, dataset["u_common"].values
        assert np.sqrt(np.sum(modes**2, axis=0)) == pytest.approx(common, rel=1e-12, nan_ok=True)
        assert len(modes) == 2  # baseline and k are stated


def test_the_common_modes_are_what_the_stated_parameters_do_to_the_radius(out):
    """By the baseline D: dR = R / D dD; by k of the sine law: dR = -R / (k cos^2 zenith) dk."""
    with open_profile(out) as dataset:
        radius, depth = dataset["radius"].values, 13.1 * 0.0254
        by_baseline = radius / depth * 0.006 * 0.0254
        by_k = radius / 192 * (1 + (radius / depth) ** 2) * 0.1
        assert np.hypot(by_baseline, by_k) == pytest.approx(dataset["u_common"].values, rel=0.02, nan_ok=True)


def test_points_have_the_promised_columns_and_every_take(out):
    with open_points(out) as points:
        for name, units in POINTS.items():
            assert points[name].dims == ("point",)
            assert points[name].attrs.get("units") == units
        assert sorted(set(points["station"].values)) == list(NUMBERS)
        assert set(points["take"].values) == set(range(TAKES))
        valued = points["status"].values <= Status.SATURATED
        for name in ("x", "y", "z", "radius", "axial", "u_radius", "u", "v"):
            assert np.isfinite(points[name].values[valued]).all()
        assert np.isnan(points["radius"].values[~valued]).all()
        assert np.isfinite(points["clock"].values).all()


def test_points_and_profile_agree(out):
    with open_points(out) as points, open_profile(out) as dataset:
        for row, number in enumerate(NUMBERS):
            here = (points["station"].values == number) & np.isfinite(points["radius"].values)
            mean = float(np.nanmean(dataset["radius"].values[row]))
            assert float(points["radius"].values[here].mean()) == pytest.approx(mean, abs=1e-4)


def test_rings_have_one_row_a_station_and_every_quantity_its_uncertainty(out):
    with (out / "rings.csv").open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert len(rows) == len(NUMBERS)
    assert header[:2] == ["station", "axial_m"]
    plain = {"station", "axial_m", "takes", "points", "fraction", "fraction_directions", "flags"}
    for name in set(header) - plain:
        assert name.startswith("u_") or f"u_{name}" in header
        assert name.endswith(("_m", "_m2", "_rad", "_percent"))
    wanted = {"diameter_mean_m", "diameter_min_m", "diameter_max_m", "ovality_f1216_max_percent", "deflection_percent"}
    assert wanted | {"fraction", "points", "flags", "takes"} <= set(header)
    assert "gap" in rows[0][header.index("flags")].split()


def test_rings_and_profile_agree(out):
    rings = read_rings(out)
    with open_profile(out) as dataset:
        measured = np.isfinite(dataset["radius"].values)
    assert rings["fraction"] == pytest.approx(measured.mean(axis=1))
    lone = measured.sum(axis=1) - rings["points"]
    assert np.all((lone >= 0) & (lone < 5))
    assert rings["takes"].tolist() == [TAKES] * len(NUMBERS)
    deflection = 100 * (1 - rings["diameter_min_m"] / (2 * RADIUS))
    assert rings["deflection_percent"] == pytest.approx(deflection, nan_ok=True)


def test_the_summary_says_what_was_run_and_counts_right(survey, out):
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["format"] == "calibore-result/1"
    assert summary["command"] == "profile"
    assert summary["versions"]["calibore"] == __version__
    assert summary["rig"]["configuration"] == "perpendicular-plane"
    assert summary["counts"]["stations"] == len(NUMBERS)
    assert summary["counts"]["images"] == TAKES * len(NUMBERS)
    assert summary["counts"]["refused_images"] == 0
    with open_profile(out) as dataset:
        statuses = np.bincount(dataset["status"].values.ravel(), minlength=len(Status))
    assert summary["statuses"] == {status.name.lower(): n for status, n in zip(Status, statuses, strict=True) if n}
    assert summary["counts"]["measured"] == statuses[: Status.SATURATED + 1].sum()
    assert 0 <= summary["take_correlation"] <= 1
    assert {row["station"] for row in summary["worst_stations"]} == set(NUMBERS)
    found = {path.relative_to(out).parts[0] for path in out.rglob("*")}
    assert set(summary["files"]) == found


def test_two_takes_of_one_speckle_pattern_are_worth_less_than_two(survey, out, tmp_path):
    for path in survey.glob("* 0.png"):
        (tmp_path / "single").mkdir(exist_ok=True)
        (tmp_path / "single" / path.name).write_bytes(path.read_bytes())
    for name in ("scan.toml", "rig.toml"):
        (tmp_path / "single" / name).write_bytes((survey / name).read_bytes())
    assert profile(tmp_path / "single").status == 0
    with open_profile(out) as both, open_profile(tmp_path / "out") as single:
        gain = np.nanmedian(both["u_independent"].values / single["u_independent"].values)
    assert 1 / np.sqrt(2) + 0.05 < gain < 1


def test_a_station_with_fewer_takes_than_the_others_is_mentioned(survey, tmp_path):
    folder = tmp_path / "survey"
    folder.mkdir()
    for path in survey.iterdir():
        if path.name != "pipe 300 1.png":
            (folder / path.name).write_bytes(path.read_bytes())
    outcome = profile(folder)
    assert outcome.status == 0
    assert "1 station has fewer than the usual 2 takes: 300." in outcome.err


def test_a_take_that_cannot_be_read_is_named_and_its_station_measured_with_the_other(survey, tmp_path):
    folder = tmp_path / "survey"
    folder.mkdir()
    for path in survey.iterdir():
        (folder / path.name).write_bytes(path.read_bytes() if path.name != "pipe 300 1.png" else b"")
    outcome = profile(folder)
    assert outcome.status == 3
    assert outcome.err == (
        "Warning: 1 image could not be used: pipe 300 1.png (it is empty (0 bytes); copy or save it again, or remove "
        "it).\n"
    )
    rings = read_rings(tmp_path / "out")
    assert rings["station"].tolist() == list(NUMBERS)
    assert rings["takes"].tolist() == [2, 2, 1, 2]


# Exports


def test_the_text_export_holds_axial_clock_and_radius_of_every_measured_position(out):
    table = np.loadtxt(out / "profile.txt")
    with open_profile(out) as dataset:
        radius = dataset["radius"].values
        measured = np.isfinite(radius)
        expected = [dataset["axial_position"].values[measured], radius[measured]]
        clock = np.broadcast_to(dataset["clock"].values, radius.shape)[measured]
    assert table[:, 0] == pytest.approx(expected[0], abs=1e-9)
    assert table[:, 1] == pytest.approx(clock, abs=1e-9)
    assert table[:, 2] == pytest.approx(expected[1], abs=1e-9)


def test_the_other_exports_hold_as_many_points_as_were_measured(out):
    import laspy

    with open_points(out) as points:
        total, measured = points.sizes["point"], int(np.isfinite(points["x"].values).sum())
    assert (out / "points.csv").read_text(encoding="ascii").count("\n") == total + 1
    assert f"element vertex {measured}\n".encode() in (out / "points.ply").read_bytes()[:400]
    for name in ("points.las", "points.laz"):
        with laspy.open(out / name) as file:
            assert file.header.point_count == measured
            assert "u_radius" in list(file.header.point_format.extra_dimension_names)


def test_the_netcdf_export_is_the_profile(out):
    import xarray

    with xarray.open_dataset(out / "profile.nc", engine="h5netcdf") as copy, open_profile(out) as dataset:
        assert copy["radius"].dims == ("station", "clock")
        for name in PROFILE:
            assert np.array_equal(copy[name].values, dataset[name].values, equal_nan=copy[name].dtype.kind == "f")


def test_an_export_made_later_is_the_same_as_one_made_at_once(out, tmp_path):
    outcome = calibore("export", out, "ply", "--to", tmp_path / "später.ply")
    assert outcome.status == 0
    assert outcome.out == f"Wrote {tmp_path / 'später.ply'}\n"
    assert (tmp_path / "später.ply").read_bytes() == (out / "points.ply").read_bytes()
