"""Every export gives back the numbers of the result, and never leaves half a file."""

import csv
import importlib
from importlib.util import find_spec

import numpy as np
import pytest
import xarray
from tiny_survey import make_scan, write

from calibore.errors import InputError, OutputError
from calibore.scans import _point_clouds as point_clouds
from calibore.scans import export, open_points, open_profile

NAMES = {"text3": "p.txt", "csv": "p.csv", "netcdf": "p.nc", "ply": "p.ply", "las": "p.las", "laz": "p.laz"}
NEEDS = {"netcdf": ("h5py", "h5netcdf"), "las": ("laspy",), "laz": ("laspy", "lazrs")}


def skip_without_packages(format):
    missing = [package for package in NEEDS.get(format, ()) if find_spec(package) is None]
    if missing:
        pytest.skip(f"{format} is not tested: {', '.join(missing)} is not installed")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exports")
    # More than one chunk of stations (32) and of points (65536).
    write(folder / "out", make_scan(folder / "scan"), stations=40, points=1700)
    return folder / "out"


@pytest.fixture(scope="module")
def exported(result):
    """Gives the path of the export in a format, made once."""
    made = {}

    def of(format):
        skip_without_packages(format)
        if format not in made:
            made[format] = export(result, format, result.parent / NAMES[format])
        return made[format]

    return of


def positions(points):
    """The points a point cloud can hold, shape (n, 3) [m], and which they are."""
    xyz = np.column_stack([points[name].values.astype(float) for name in "xyz"])
    placed = np.isfinite(xyz).all(axis=1)
    return xyz[placed], placed


def test_text_has_axial_clock_and_radius_of_every_measured_grid_point(result, exported):
    profile = open_profile(result)
    measured = np.isfinite(profile["radius"].values)
    clock = np.broadcast_to(profile["clock"].values, measured.shape)[measured]
    expected = np.column_stack([profile["axial_position"].values[measured], clock, profile["radius"].values[measured]])
    table = np.loadtxt(exported("text3"), delimiter="\t")
    np.testing.assert_allclose(table, expected, rtol=0, atol=0.5001e-9)  # nine printed decimals


def test_text_in_inches_is_the_dissertations(result, exported, tmp_path):
    inches = np.loadtxt(export(result, "text3", tmp_path / "p.txt", length_unit="in"))
    metres = np.loadtxt(exported("text3"))
    np.testing.assert_allclose(inches * [0.0254, 1, 0.0254], metres, rtol=0, atol=1e-9)


def test_csv_has_every_column_of_every_point(result, exported):
    points = open_points(result)
    with exported("csv").open() as file:
        header, *rows = csv.reader(file)
    assert set(header) == set(points.data_vars)
    table = np.array(rows, dtype=float)
    for name, column in zip(header, table.T, strict=True):
        assert np.array_equal(column.astype(points[name].dtype), points[name], equal_nan=True), name


def test_netcdf_is_the_profile(result, exported):
    path = exported("netcdf")
    h5netcdf = importlib.import_module("h5netcdf")
    profile, copy = open_profile(result).load(), xarray.load_dataset(path, engine="h5netcdf")
    assert copy.sizes == profile.sizes
    assert set(copy.coords) == set(profile.coords)
    for name in profile.variables:
        assert copy[name].dims == profile[name].dims
        assert copy[name].dtype == profile[name].dtype, name
        assert np.array_equal(copy[name], profile[name], equal_nan=profile[name].dtype.kind == "f"), name
        assert copy[name].attrs.get("units") == profile[name].attrs.get("units")
    with h5netcdf.File(path) as file:
        assert file.attrs["Conventions"] == "CF-1.11"
        assert file["status"].attrs["flag_values"].dtype == np.uint8


def test_ply_holds_the_positions_with_uncertainty_and_status(result, exported):
    header, _, body = exported("ply").read_bytes().partition(b"end_header\n")
    kinds = {"double": "<f8", "float": "<f4", "int": "<i4", "uchar": "u1"}
    lines = [line.split() for line in header.decode().splitlines()]
    vertices = np.frombuffer(body, [(line[2], kinds[line[1]]) for line in lines if line[0] == "property"])
    points = open_points(result)
    expected, placed = positions(points)
    assert ["element", "vertex", str(len(expected))] in lines
    assert np.array_equal(np.column_stack([vertices[name] for name in "xyz"]), expected)
    for name in ("u_radius", "radius", "clock", "station", "status"):
        assert np.array_equal(vertices[name], points[name].values[placed]), name


@pytest.mark.parametrize("format", ["las", "laz"])
def test_las_holds_the_positions_to_a_micrometre_with_uncertainty_and_status(result, exported, format):
    path = exported(format)
    cloud = importlib.import_module("laspy").read(path)
    points = open_points(result)
    expected, placed = positions(points)
    assert max(cloud.header.scales) <= 1e-6
    np.testing.assert_allclose(cloud.xyz, expected, rtol=0, atol=0.501e-6)  # half of one step
    for name in ("u_radius", "radius", "clock", "station", "status"):
        assert np.array_equal(cloud[name], points[name].values[placed]), name
    assert cloud.header.are_points_compressed == (format == "laz")


@pytest.mark.parametrize("length", [0.1, 100.0, 4000.0, 5000.0, 90_000.0])
def test_las_steps_stay_fine_and_reach_both_ends_of_the_pipe(length):
    scales, offsets = point_clouds._las_grid(np.array([-1.0, -1.0, 10.0]), np.array([1.0, 1.0, 10.0 + length]))
    ends = (np.array([10.0, 10.0 + length]) - offsets[2]) / scales[2]
    assert np.all(np.abs(ends) < 2**31)
    assert scales[2] <= max(1e-6, 10.1 * length / 2**32)


@pytest.mark.parametrize("format", NAMES)
def test_two_exports_are_the_same_bytes(result, exported, tmp_path, format):
    first = exported(format)
    assert export(result, format, tmp_path / first.name).read_bytes() == first.read_bytes()


@pytest.mark.parametrize("format", NAMES)
def test_an_interrupted_export_leaves_the_old_file(result, tmp_path, monkeypatch, format):
    skip_without_packages(format)
    (tmp_path / "p").write_text("old")

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("calibore.scans._exports.os.replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        export(result, format, tmp_path / "p")
    assert (tmp_path / "p").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["p"]


def test_an_export_that_cannot_be_written_is_told(result, tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("x")
    for destination in (tmp_path / "folder", tmp_path / "file" / "p.csv"):
        with pytest.raises(OutputError, match="cannot be written"):
            export(result, "csv", destination)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize(
    ("format", "package"), [(format, package) for format, packages in NEEDS.items() for package in packages]
)
def test_a_missing_package_is_named_with_what_to_install(result, tmp_path, monkeypatch, format, package):
    find = importlib.import_module

    def without(name, *more):
        if name == package:
            raise ImportError(name)
        return find(name, *more)

    for needed in NEEDS[format]:
        if needed != package and find_spec(needed) is None:
            pytest.skip(f"{needed} is not installed either")
    monkeypatch.setattr(importlib, "import_module", without)
    sentence = rf'"{format}" needs the package {package}; install it with: pip install "calibore.export'
    with pytest.raises(InputError, match=sentence):
        export(result, format, tmp_path / "p")
    assert list(tmp_path.iterdir()) == []


def test_unknown_formats_units_and_folders_are_named(result, tmp_path):
    with pytest.raises(InputError, match='"stl" is not known; allowed: csv, las, laz, netcdf, ply, text3'):
        export(result, "stl", tmp_path / "p")
    with pytest.raises(InputError, match='"ply" is always in metres'):
        export(result, "ply", tmp_path / "p", length_unit="in")
    with pytest.raises(InputError, match=r"1 furlongsss. is not a length"):
        export(result, "text3", tmp_path / "p", length_unit="furlongsss")
    with pytest.raises(InputError, match="is not a result folder"):
        export(tmp_path, "ply", tmp_path / "p")


@pytest.mark.parametrize("format", NAMES)
def test_a_result_without_points_or_modes_is_exported_too(tmp_path, format):
    skip_without_packages(format)
    write(tmp_path / "out", make_scan(tmp_path / "scan"), stations=1, points=0, modes=0)
    assert export(tmp_path / "out", format, tmp_path / "p").exists()
