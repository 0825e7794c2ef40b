"""Mistakes in scan.toml, rig.toml and station tables are named with file, key or line, and remedy."""

from pathlib import Path

import pytest
from command_line import profile
from spoilt import DONE, PARTLY, PICTURE, nothing_was_written, refused, write_key

from calibore.scans import read_rings

MISTAKES = {
    "unknown lens": ("rig.toml", '"sine-law"', '"fisheye"', ("camera.lens = 'fisheye'", "'sine-law'")),
    "unknown configuration": (
        "rig.toml",
        '"perpendicular-plane"',
        '"spiral"',
        ("configuration = 'spiral'", "not known", "perpendicular-plane"),
    ),
    "missing key": ("rig.toml", r"^k = 192.*\n", "", ("key camera.k is missing", "add it")),
    "missing radius": ("scan.toml", "^nominal_radius.*\n", "", ("key pipe.nominal_radius is missing", "add it")),
    "unknown key": ("scan.toml", r"\[motion\]", "[motion]\nspeed = 3", ("key motion.speed", "allowed here: angular")),
    "wrong unit": ("scan.toml", '"0.1524 m"', '"6 kg"', ("pipe.nominal_radius = '6 kg'", 'such as "150 mm"')),
    "no unit": ("scan.toml", '"0.1524 m"', "6", ("pipe.nominal_radius = 6", "no unit", '"6 mm"')),
    "decimal comma": ("scan.toml", '"0.1524 m"', '"152,4 mm"', ('"152,4 mm" is not a length', "decimal point")),
    "negative radius": ("scan.toml", '"0.1524 m"', '"-6 in"', ("nominal_radius = '-6 in'", "greater than 0")),
    "negative baseline": ("rig.toml", '"0.33274 m"', '"-13 in"', ("laser.baseline = '-13 in'", "greater than 0")),
    "NaN radius": ("scan.toml", '"0.1524 m"', '"nan m"', ("pipe.nominal_radius = nan", "finite")),
    "NaN k": ("rig.toml", "^k = 192.*$", "k = nan", ("camera.k = nan", "finite")),
    "infinite k": ("rig.toml", "^k = 192.*$", "k = inf", ("camera.k = inf", "finite")),
    "text for a number": ("rig.toml", "^k = 192.*$", 'k = "192"', ("camera.k = '192'", "a number without quotes")),
    "one coordinate": ("rig.toml", r"\[160.0, 120.0\]", "[160.0]", ("camera.principal_point[1] is missing",)),
    "three coordinates": (
        "rig.toml",
        r"\[160.0, 120.0\]",
        "[160.0, 120.0, 0.0]",
        ("camera.principal_point", "it must have at most 2 items, not 3"),
    ),
    "number for a table": ("scan.toml", r'\[pipe\]\n.*"0.1524 m"', "pipe = 3", ("key pipe = 3", "it must be a table")),
    "broken TOML": ("scan.toml", r"\[pipe\]", "[pipe", ("is not valid TOML", "line 5", "Correct that line")),
    "broken TOML of the rig": ("rig.toml", r"\[camera\]", "camera]", ("is not valid TOML", "line 4", "Correct that")),
    "format of a later version": ("scan.toml", "scan/1", "scan/2", ("format = 'calibore-scan/2'", '"calibore-scan/1"')),
    "rig that is not there": (
        "scan.toml",
        '"rig.toml"',
        '"ring.toml"',
        ('rig = "ring.toml"', "names no existing file"),
    ),
    "unknown field": ("scan.toml", "{take}", "{stop}", ("images.pattern", "field {stop} is not known", "allowed")),
    "unknown channel": ("rig.toml", '"red"', '"purple"', ("laser.channel = 'purple'", "'red'")),
    "step zero": ("scan.toml", 'step = "0.05 m"', 'step = "0 m"', ("motion.axial.step = '0 m'", "give the distance")),
}


@pytest.mark.parametrize("mistake", MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_in_a_file_is_named_with_file_key_and_remedy(scan, mistake):
    name, pattern, replacement, words = mistake
    write_key(scan / name, pattern, replacement)
    refused(profile(scan), str(scan / name), *words)
    assert nothing_was_written(scan)


@pytest.mark.parametrize(
    ("name", "pattern", "replacement"),
    [
        ("scan.toml", '"0.1524 m"', '"600 m"'),
        ("scan.toml", '"0.1524 m"', '"6 um"'),
        ("rig.toml", r"\[160.0, 120.0\]", "[16000.0, 120.0]"),
    ],
    ids=["radius far too large", "radius far too small", "principal point far outside"],
)
def test_a_pipe_that_this_camera_could_not_see_is_refused_before_its_images_are_read(scan, name, pattern, replacement):
    write_key(scan / name, pattern, replacement)
    sentence = refused(profile(scan), str(scan), "scan.toml", "rig file", "320 x 240 px", "check nominal_radius")
    assert "pipe 000" not in sentence


def test_a_laser_that_is_never_lit_in_the_images_given_is_told_so(scan):
    write_key(scan / "rig.toml", '^channel = "red"', 'channel = "red"\ntakes = [7]')
    refused(profile(scan), PICTURE.format(0), "laser.takes", "does not name this take", "correct one of them")


def test_a_tactile_scan_without_a_probe_is_told_how_to_get_one(scan):
    tables = '[tactile]\nsignal = "scan.toml"\nbias = "scan.toml"\ntip_radius = "1 mm"'
    write_key(scan / "scan.toml", r"\[images\]\npattern.*$", tables)
    write_key(scan / "scan.toml", "^rig = .*\n", "")
    refused(profile(scan), str(scan), "names no probe", "calibore calibrate probe")


def test_a_file_that_is_not_text_is_told_so(scan):
    (scan / "rig.toml").write_bytes(b"\xff\xfe\x00")
    refused(profile(scan), str(scan / "rig.toml"), "0xff", "not UTF-8", "saved as UTF-8")


# Station tables


def with_table(scan: Path, rows: str) -> Path:
    text = (scan / "scan.toml").read_text(encoding="utf-8")
    head = text[: text.index("[motion]")]
    (scan / "scan.toml").write_text(head + '[motion]\ntable = "stations.csv"\n', encoding="utf-8")
    (scan / "stations.csv").write_text(rows, encoding="utf-8")
    return scan


def test_stations_that_the_table_lacks_are_left_out_counted_and_named(scan):
    outcome = profile(with_table(scan, "station,axial_m\n0,0\n1,0.05\n"))
    assert outcome.status == PARTLY
    assert "motion.table has no row for 2 stations, whose images were left out: 2, 3." in outcome.err
    assert read_rings(scan.parent / "out")["station"].tolist() == [0, 1]


def test_a_table_of_other_stations_leaves_nothing_to_measure(scan):
    refused(profile(with_table(scan, "station,axial_m\n10,0\n")), "none of its 4 images", "motion.table", "0, 1, 2, 3")


def test_stations_of_the_table_that_have_no_image_are_mentioned(scan):
    outcome = profile(with_table(scan, "station,axial_m\n" + "".join(f"{n},{n}\n" for n in range(6))))
    assert outcome.status == DONE
    assert "2 stations without an image, but motion.table has a row for them: 4, 5." in outcome.err


TABLES = {
    "empty": ("", ("column station is missing",)),
    "header only": ("station,axial_m\n", ("has a header but no rows", "add one row")),
    "text": ("station,axial_m\n0,zero\n", ("line 2", 'axial_m = "zero"', "correct that cell")),
    "NaN": ("station,axial_m\n0,nan\n", ("line 2", 'axial_m = "nan"', "finite")),
    "twice": ("station,axial_m\n0,1\n0,2\n", ("line 3", "station 0 is there twice")),
    "degrees": ("station,axial_m,roll_deg\n0,1,2\n", ("column roll_deg", "write roll_rad")),
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES.keys())
def test_a_mistake_in_the_table_is_named_with_its_line_and_column(scan, table):
    rows, words = table
    refused(profile(with_table(scan, rows)), str(scan / "stations.csv"), *words)
