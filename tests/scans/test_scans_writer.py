"""The result folder: what went in comes out, twice the same bytes, in flat memory."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray
from tiny_survey import make_scan, ring, row, verify, write

from calibore.errors import InputError
from calibore.scans import ResultWriter, open_points, open_profile, read_rings, read_scan
from calibore.status import Status

GRID = ("radius", "axial_position", "u_independent")
STATIONS = 70  # more than two chunks of stations, and not a multiple of them


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    return make_scan(tmp_path_factory.mktemp("folder") / "scan")


@pytest.fixture(scope="module")
def result(scan):
    write(scan.parent / "long", scan, stations=STATIONS, points=1900)
    return scan.parent / "long"


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_the_profile_comes_out_as_it_went_in(result):
    profile = open_profile(result)
    rings = [ring(station, points=1900)[0] for station in range(STATIONS)]
    for name in (*GRID, "status"):
        assert profile[name].dims == ("station", "clock")
    for name in GRID:
        expected = np.array([np.where(np.isnan(r.radius), np.nan, getattr(r, name)) for r in rings])
        assert np.array_equal(profile[name], expected, equal_nan=True), name
    assert np.array_equal(profile["status"], [r.status for r in rings])
    assert profile["status"].dtype == np.uint8
    for name in ("station", "axial", "centre_x", "centre_y", "u_centre_x", "u_centre_y", "time_s", "roll"):
        assert profile[name].dims == ("station",)
        assert np.array_equal(profile[name], [getattr(r, name) for r in rings], equal_nan=True), name
    assert np.array_equal(profile["clock"], rings[0].clock)
    assert set(profile.coords) == {"station", "axial", "clock"}


def test_the_common_part_can_be_propagated_from_the_file(result):
    profile = xarray.open_zarr(result / "profile.zarr")
    assert profile["common_mode"].dims == ("mode", "station", "clock")
    squares = (profile["common_mode"] ** 2).sum("mode", skipna=False)
    np.testing.assert_allclose(profile["u_common"] ** 2, squares, rtol=1e-14)  # rounding of one root


def test_statuses_are_explained_in_the_file(result):
    for opened in (open_profile(result), open_points(result)):
        flags = opened["status"].attrs
        assert dict(zip(flags["flag_meanings"].split(), flags["flag_values"], strict=True)) == {
            status.name.lower(): status.value for status in Status
        }
    assert all("long_name" in variable.attrs for variable in open_profile(result).variables.values())


def test_points_come_out_as_they_went_in_but_for_single_precision(result):
    points = open_points(result)
    clouds = [ring(station, points=1900)[1] for station in range(STATIONS)]
    assert points.sizes == {"point": STATIONS * 1900}
    for name in ("x", "y", "z", "radius", "clock", "axial", "u_radius", "u", "v", "take", "status"):
        values, expected = points[name].values, np.concatenate([getattr(cloud, name) for cloud in clouds])
        rounding = np.finfo(np.float32).eps / 2 if values.dtype == np.float32 else 0
        np.testing.assert_allclose(values, expected, rtol=rounding, atol=0, err_msg=name)
    assert np.array_equal(points["station"], np.repeat(np.arange(STATIONS), 1900))


def test_a_kilometre_down_the_pipe_positions_still_have_all_their_digits(result):
    assert {open_points(result)[name].dtype for name in ("z", "axial")} == {np.dtype("float64")}


def test_ring_quantities_keep_every_digit(result):
    rings = read_rings(result)
    rows = [row(ring(station, points=1900)[0]) for station in range(STATIONS)]
    assert list(rings) == ["station", "axial_m", "mean_diameter", "u_mean_diameter", "flags"]
    assert rings["station"].dtype == np.int64
    for name in ("mean_diameter", "u_mean_diameter", "flags"):
        assert rings[name].tolist() == [entry[name] for entry in rows]


def test_the_summary_says_what_is_there_and_is_strict_json(result, scan):
    def refuse(text):
        raise AssertionError(f"{text} is not JSON")

    summary = json.loads((result / "summary.json").read_text(), parse_constant=refuse)
    assert summary["identity"] == read_scan(scan).identity
    assert summary["files"] == ["points.zarr", "profile.zarr", "rings.csv", "summary.json"]
    assert summary["nothing"] is None


def test_two_runs_write_the_same_bytes(result, scan):
    write(scan.parent / "again", scan, stations=STATIONS, points=1900)
    first, second = contents(result), contents(scan.parent / "again")
    assert first.keys() == second.keys()
    assert [name for name in first if first[name] != second[name]] == []


@pytest.mark.skipif(sys.platform == "win32", reason="peak memory is read through the POSIX module resource")
def test_memory_does_not_grow_with_the_survey(scan, tmp_path):
    script = Path(__file__).with_name("tiny_survey.py")
    arguments = [sys.executable, script, "print_peak_memory", tmp_path / "out", scan, "800"]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    few, many = json.loads(done.stdout)
    # 750 more stations are 100 MB. The allocator keeps 7 MB of freed memory, after 400 stations as after 4800.
    assert many - few < 10e6, (few, many)


def test_pictures_put_into_the_folder_belong_to_the_result(scan, tmp_path):
    with ResultWriter(tmp_path / "out", read_scan(scan)) as writer:
        profile, points = ring(0)
        writer.add(profile, points, row(profile))
        assert open_profile(writer.seal()).sizes["station"] == 1
        (writer.folder / "map.png").write_bytes(b"png")
        (writer.folder / "more").mkdir()
        (writer.folder / "more" / "ring.png").write_bytes(b"png")
        with pytest.raises(RuntimeError, match="sealed"):
            writer.add(profile, points, row(profile))
        writer.finish({})
    assert {"map.png", "more/ring.png"} < set(json.loads((tmp_path / "out" / "summary.json").read_text())["files"])
    write(tmp_path / "out", scan, seed=2)
    assert verify(tmp_path / "out") == 2
    assert not (tmp_path / "out" / "map.png").exists()


@pytest.mark.parametrize("options", [{"modes": 0}, {"points": 0}, {"stations": 1}, {"stations": 32}])
def test_unusual_surveys_are_written_too(scan, tmp_path, options):
    write(tmp_path / "out", scan, **options)
    stations = options.get("stations", 3)
    profile, points = open_profile(tmp_path / "out").load(), open_points(tmp_path / "out").load()
    assert profile.sizes == {"station": stations, "clock": 8, "mode": options.get("modes", 2), "lag": 0}
    assert points.sizes["point"] == stations * options.get("points", 12)
    assert np.isfinite(profile["radius"]).sum() == 7 * stations


@pytest.mark.parametrize(
    ("second", "sentence"),
    [
        (ring(4), "Station 4 follows 5; add stations in ascending order"),
        (ring(5), "Station 5 follows 5"),
        (ring(6, clocks=16), "Station 6 has another clock grid than station 5"),
        (ring(6, modes=3), "Station 6 has 3 common modes, station 5 has 2"),
    ],
)
def test_stations_that_do_not_fit_together_are_refused(scan, tmp_path, second, sentence):
    with ResultWriter(tmp_path / "out", read_scan(scan)) as writer:
        writer.add(*ring(5), {"ovality": 0.1})
        with pytest.raises(ValueError, match=sentence):
            writer.add(*second, {"ovality": 0.1})
    assert list(tmp_path.iterdir()) == []


def test_rows_with_other_columns_are_refused(scan, tmp_path):
    with ResultWriter(tmp_path / "out", read_scan(scan)) as writer:
        writer.add(*ring(1), {"ovality": 0.1})
        with pytest.raises(ValueError, match=r"A row of rings\.csv has columns .*'deflection'.* had .*'ovality'"):
            writer.add(*ring(2), {"deflection": 0.1})


def test_points_of_many_pictures_stand_before_the_rows_made_of_them(scan, tmp_path):
    """A row of a side-facing scan is made of many pictures: their points come first, each with its own station."""
    with ResultWriter(tmp_path / "out", read_scan(scan)) as writer:
        for station in (3, 1, 3):
            writer.add_points(ring(station, points=40)[1], station)
        for number in range(2):
            profile, points = ring(number, points=0)
            writer.add(profile, points, row(profile))
        writer.finish({})
    points = open_points(tmp_path / "out")
    np.testing.assert_array_equal(points["station"], np.repeat([3, 1, 3], 40))
    np.testing.assert_array_equal(open_profile(tmp_path / "out")["station"], [0, 1])


def test_a_result_without_a_station_is_not_written(scan, tmp_path):
    with (
        pytest.raises(ValueError, match="No station was added"),
        ResultWriter(tmp_path / "out", read_scan(scan)) as writer,
    ):
        writer.finish({})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["profile.zarr", "points.zarr", "rings.csv"])
def test_a_folder_that_is_no_result_is_named(result, tmp_path, name):
    opener = {"profile.zarr": open_profile, "points.zarr": open_points, "rings.csv": read_rings}[name]
    with pytest.raises(InputError, match=f"is not a result folder .it has no {name}"):
        opener(tmp_path)
    with pytest.raises(InputError, match="nowhere is not a folder; give the result folder"):
        opener(tmp_path / "nowhere")


def test_a_damaged_or_newer_result_is_named(scan, tmp_path):
    write(tmp_path / "out", scan)
    metadata = tmp_path / "out" / "profile.zarr" / "zarr.json"
    text = metadata.read_text()
    metadata.write_text(text.replace("calibore-profile/1", "calibore-profile/2"))
    with pytest.raises(InputError, match="has the format 'calibore-profile/2'; this version reads"):
        open_profile(tmp_path / "out")
    metadata.write_text(text[:100])
    with pytest.raises(InputError, match=r"profile\.zarr cannot be read"):
        open_profile(tmp_path / "out")
    (tmp_path / "out" / "rings.csv").write_text("a,b\n1\n")
    with pytest.raises(InputError, match=r"rings\.csv cannot be read"):
        read_rings(tmp_path / "out")


def test_importing_the_package_loads_nothing_heavy():
    heavy = ["zarr", "xarray", "pint", "laspy", "h5netcdf"]
    code = f"import sys, calibore.scans; print([m for m in {heavy} if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
