"""Whatever is wrong with a scan: one sentence that says what, where and what to do, and the right exit status."""

import json
import os
import re
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from command_line import Outcome, calibore, outcome_of, profile, started, stray_files
from PIL import Image

from calibore.scans import open_profile, read_rings
from calibore.simulation import Sensor

DONE, UNUSABLE, WRONG_USAGE, PARTLY = 0, 1, 2, 3
PICTURE = "pipe {:03d} 0.png"
NOBODY = 65534


def images(scan: Path) -> list[Path]:
    return sorted(scan.glob("*.png"))


def replace(path: Path, pixels: np.ndarray | bytes) -> None:
    """Another picture, or any bytes, under the name of this one (which may be a link)."""
    path.unlink()
    if isinstance(pixels, bytes):
        path.write_bytes(pixels)
    else:
        Image.fromarray(pixels).save(path)


def write_key(path: Path, pattern: str, replacement: str) -> None:
    text, count = re.subn(pattern, lambda _: replacement, path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert count == 1
    path.write_text(text, encoding="utf-8")


def refused(outcome: Outcome, *words: str, status: int = UNUSABLE) -> str:
    """The command failed with `status` and one sentence that contains all `words`."""
    assert outcome.status == status, outcome
    for word in words:
        assert word in outcome.sentence
    assert outcome.sentence.endswith(".")
    return outcome.sentence


def nothing_was_written(scan: Path) -> bool:
    return not (scan.parent / "out").exists() and not stray_files(scan.parent / "out")


# What there is to read


def test_a_scan_that_does_not_exist_is_named(tmp_path):
    refused(profile(tmp_path / "nowhere"), str(tmp_path / "nowhere"), "does not exist", "give a scan folder")


def test_an_empty_folder_is_told_to_need_a_scan_file(tmp_path):
    (tmp_path / "empty").mkdir()
    refused(profile(tmp_path / "empty"), str(tmp_path / "empty"), "has no scan.toml", "give a folder that holds one")


def test_a_picture_given_as_scan_is_told_to_be_no_text(scan):
    refused(profile(images(scan)[0]), PICTURE.format(0), "not UTF-8 text", "give a TOML file")


def test_a_name_too_long_for_the_system_is_no_crash(tmp_path):
    refused(profile(tmp_path / ("x" * 300)), "xxx", "too long", "check that path")


def test_a_folder_without_images_is_told_the_pattern_and_what_is_there(scan):
    for image in images(scan):
        image.unlink()
    refused(profile(scan), str(scan), "pipe {station:03d} {take}.png", '"rig.toml"', "Write the pattern as")
    assert nothing_was_written(scan)


def test_images_of_another_name_are_told_the_pattern_and_one_of_their_names(scan):
    for image in images(scan):
        image.rename(image.with_name(image.name.replace("pipe", "tube")))
    refused(profile(scan), "pipe {station:03d} {take}.png", '"tube 000 0.png"', "Write the pattern as")


# Images


SPOILT_FILES = {
    "truncated": (lambda whole: whole[:2000], "truncated"),
    "empty": (lambda whole: b"", "empty (0 bytes)"),
    "text": (lambda whole: b"this is no picture", "not a PNG, JPEG, TIFF, BMP, PGM or PPM"),
    "header only": (lambda whole: whole[:30], "truncated"),
    "bits flipped": (lambda whole: whole[:1000] + bytes(255 - b for b in whole[1000:1100]) + whole[1100:], "corrupt"),
}


@pytest.mark.parametrize("spoil", SPOILT_FILES.values(), ids=SPOILT_FILES.keys())
def test_one_spoilt_image_is_skipped_counted_and_named_and_the_others_are_measured(scan, spoil):
    change, why = spoil
    image = images(scan)[1]
    replace(image, change(image.read_bytes()))
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert outcome.out.startswith("3 stations from 3 images")
    assert outcome.err.startswith(f"Warning: 1 image could not be used: {image.name} (")
    assert why in outcome.err
    assert "copy or save it again, or remove it" in outcome.err
    assert outcome.err.count("\n") == 1
    assert read_rings(scan.parent / "out")["station"].tolist() == [0, 2, 3]
    summary = json.loads((scan.parent / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["counts"] | {"stations": 3, "images": 3, "refused_images": 1} == summary["counts"]
    assert [one["image"] for one in summary["skipped"]] == [image.name]


@pytest.mark.parametrize("spoil", SPOILT_FILES.values(), ids=SPOILT_FILES.keys())
def test_where_every_image_is_spoilt_nothing_is_written_and_the_first_is_named(scan, spoil):
    change, why = spoil
    for image in images(scan):
        replace(image, change(image.read_bytes()))
    refused(profile(scan), str(scan), "none of its 4 images", PICTURE.format(0), why, "copy or save it again")
    assert nothing_was_written(scan)


def flat(value: int) -> np.ndarray:
    return np.full((240, 320, 3), value, np.uint8)


def noise() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)


def sensor_noise() -> np.ndarray:
    """What the camera sees with the laser off."""
    return np.asarray(Sensor().read_out(np.zeros((240, 320, 3)), np.random.default_rng(2)))


def lamp(colour: tuple[float, float, float] = (1.0, 0.9, 0.8)) -> np.ndarray:
    """A lamp's blob where the ring would be."""
    row, column = np.mgrid[:240, :320]
    blob = 400 * np.exp(-((column - 225) ** 2 + (row - 100) ** 2) / (2 * 15**2))
    return np.clip(blob[..., np.newaxis] * colour + sensor_noise(), 0, 255).astype(np.uint8)


WITHOUT_RING = {
    "black": (flat(0), "every red value is 0 of 255"),
    "grey": (flat(90), "every red value is 90 of 255"),
    "saturated": (flat(255), "every red value is 255 of 255"),
    "noise": (noise(), "red values 0 to 255 of 255"),
    "laser off": (sensor_noise(), "of 255"),
    "white lamp": (lamp(), "to 255 of 255"),
    "red lamp": (lamp((1.0, 0.1, 0.1)), "to 255 of 255"),
}


@pytest.mark.parametrize("picture", WITHOUT_RING.values(), ids=WITHOUT_RING.keys())
def test_pictures_without_a_ring_are_told_so_with_their_brightness_and_what_to_check(scan, picture):
    pixels, brightness = picture
    for image in images(scan):
        replace(image, pixels)
    sentence = refused(profile(scan), "none of its 4 images", PICTURE.format(0), "no laser ring", brightness)
    assert "check exposure, laser.channel and pipe.nominal_radius" in sentence
    assert re.search(r"looked for \d+ to \d+ px from column 160, row 120", sentence)
    assert nothing_was_written(scan)


@pytest.mark.parametrize("picture", WITHOUT_RING.values(), ids=WITHOUT_RING.keys())
def test_one_picture_without_a_ring_costs_only_its_station(scan, picture):
    pixels, brightness = picture
    replace(images(scan)[2], pixels)
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert f"1 image could not be used: {PICTURE.format(2)} (there is no laser ring" in outcome.err
    assert brightness in outcome.err
    assert read_rings(scan.parent / "out")["station"].tolist() == [0, 1, 3]


def test_images_of_another_size_than_the_rigs_are_told_both_sizes(scan):
    for image in images(scan):
        replace(image, np.zeros((100, 120, 3), np.uint8))
    refused(profile(scan), PICTURE.format(0), "120 x 100 px", "320 x 240 px", "use the rig file of the camera")


def test_one_image_of_another_size_is_skipped_and_named(scan):
    replace(images(scan)[3], np.zeros((480, 640, 3), np.uint8))
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert f"{PICTURE.format(3)} (it is 640 x 480 px but the rig's camera has 320 x 240 px" in outcome.err


def test_images_refused_for_one_reason_are_named_together(scan):
    for image in images(scan)[1:]:
        replace(image, b"")
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert "3 images could not be used: pipe 001 0.png, pipe 002 0.png, pipe 003 0.png (it is empty" in outcome.err


@pytest.mark.parametrize("options", [("--pictures",), ("--no-pictures", "--json")], ids=" ".join)
def test_a_line_seen_on_a_third_of_the_ring_is_measured_but_not_judged(scan, options):
    row, column = np.mgrid[:240, :320]
    hidden = np.mod(np.degrees(np.arctan2(column - 160, 120 - row)), 360) > 120
    for image in images(scan):
        pixels = np.array(Image.open(image))
        pixels[hidden] = 3
        replace(image, pixels)
    outcome = calibore("profile", scan, "--out", scan.parent / "out", *options)
    assert outcome.status == DONE
    assert "Less than 50 % of the ring was measured at 4 stations: 0, 1, 2, 3." in outcome.err
    if "--json" in options:
        summary = json.loads(outcome.out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
        assert summary["worst_stations"][0]["deflection_percent"] is None
    else:
        assert "nan" not in outcome.out
        assert (scan.parent / "out" / "report.html").exists()


def test_with_json_the_warnings_go_to_standard_error_and_the_result_stays_machine_readable(scan):
    replace(images(scan)[0], b"")
    outcome = profile(scan, "--json")
    assert outcome.status == PARTLY
    summary = json.loads(outcome.out)
    assert summary["counts"]["refused_images"] == 1
    assert summary["skipped"][0]["image"] == PICTURE.format(0)
    assert PICTURE.format(0) in outcome.err


def test_with_json_a_failure_leaves_standard_output_empty(scan):
    for image in images(scan):
        replace(image, b"")
    refused(profile(scan, "--json"), PICTURE.format(0))


def test_a_folder_named_like_an_image_is_no_image(scan):
    image = images(scan)[1]
    image.unlink()
    image.mkdir()
    outcome = profile(scan)
    assert outcome.status == DONE
    assert outcome.out.startswith("3 stations from 3 images")


def test_a_missing_station_in_a_regular_numbering_is_mentioned_and_no_failure(scan):
    for number in range(4, 8):
        shutil.copy(images(scan)[0], scan / PICTURE.format(number))
    images(scan)[5].unlink()
    outcome = profile(scan)
    assert outcome.status == DONE
    assert "1 station without an image, but the numbering of the others has gaps there: 5." in outcome.err


def test_an_unreadable_image_is_not_also_a_missing_station(scan):
    for number in range(4, 8):
        shutil.copy(images(scan)[0], scan / PICTURE.format(number))
    replace(images(scan)[5], b"")
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert "without an image" not in outcome.err


# scan.toml and rig.toml


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


# Where the result shall go


def test_a_folder_with_other_files_is_never_replaced(scan, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "diary.txt").write_text("mine")
    refused(profile(scan), str(tmp_path / "out"), '"diary.txt"', "choose an empty or new folder")
    assert (tmp_path / "out" / "diary.txt").read_text() == "mine"
    assert os.listdir(tmp_path / "out") == ["diary.txt"]


def test_the_result_of_another_scan_is_never_replaced(scan, tmp_path):
    assert profile(scan).status == DONE
    before = (tmp_path / "out" / "summary.json").read_bytes()
    write_key(scan / "scan.toml", '"small pipe"', '"another pipe"')
    refused(profile(scan), str(tmp_path / "out"), 'another scan ("small pipe")', "choose another folder")
    assert (tmp_path / "out" / "summary.json").read_bytes() == before


def test_a_result_to_which_somebody_added_files_is_never_replaced(scan, tmp_path):
    assert profile(scan).status == DONE
    (tmp_path / "out" / "notes.txt").write_text("mine")
    refused(profile(scan), str(tmp_path / "out"), "holds notes.txt", "move it away or choose another folder")
    assert (tmp_path / "out" / "notes.txt").exists()


def test_the_scan_folder_itself_is_never_replaced(scan):
    before = sorted(os.listdir(scan))
    refused(profile(scan, out=scan), str(scan), "choose an empty or new folder")
    refused(profile(scan, out=scan.parent), str(scan.parent), "choose an empty or new folder")
    assert sorted(os.listdir(scan)) == before


def test_a_result_inside_the_scan_folder_does_not_touch_the_scan(scan):
    before = sorted(os.listdir(scan))
    for _ in range(2):
        assert profile(scan, out=scan / "result").status == DONE
    assert sorted(os.listdir(scan)) == sorted([*before, "result"])


def test_a_file_in_the_way_is_named(scan):
    refused(profile(scan, out=scan / "scan.toml"), "scan.toml is a file", "choose another name")
    refused(profile(scan, out=scan / "scan.toml" / "out"), "is not a folder", "choose another place")


@contextmanager
def as_nobody() -> Iterator[None]:
    """Root may write everywhere; for the time of this block it is somebody who may not."""
    if os.getuid() != 0:
        yield
        return
    os.setresuid(NOBODY, NOBODY, 0)
    try:
        yield
    finally:
        os.setresuid(0, 0, 0)


@pytest.mark.skipif(not hasattr(os, "setresuid"), reason="needs POSIX users")
def test_a_folder_without_permission_to_write_is_named(rendered):
    assert profile(rendered, "--estimator", "none").status == WRONG_USAGE  # imports what nobody may not read
    with TemporaryDirectory() as name:
        place = Path(name)
        shutil.copytree(rendered, place / "small")
        for path in (*place.rglob("*"), place):
            path.chmod(0o755)
        closed = place / "closed"
        closed.mkdir(mode=0o555)
        with as_nobody():
            outcome = profile(place / "small", out=closed / "out")
        refused(outcome, str(closed / "out"), "cannot be written", "choose a folder that you may write to")
        assert os.listdir(closed) == []


@pytest.mark.skipif(not hasattr(os, "setresuid"), reason="needs POSIX users")
@pytest.mark.parametrize("name", ["scan.toml", "rig.toml", "pipe 002 0.png"])
def test_a_file_without_permission_to_read_is_named(rendered, name):
    assert profile(rendered, "--estimator", "none").status == WRONG_USAGE
    with TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copytree(rendered, place / "small")
        for path in (*place.rglob("*"), place):
            path.chmod(0o777)
        (place / "small" / name).chmod(0)
        with as_nobody():
            outcome = profile(place / "small")
        if name.endswith("toml"):
            refused(outcome, name, "cannot be read", "ermission")
        else:
            assert outcome.status == PARTLY
            assert f"{name} (it cannot be read (Permission denied)" in outcome.err


@contextmanager
def small_disk(limit: int) -> Iterator[None]:
    """No file may grow beyond `limit` bytes."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


LIMITS = (3_000, 20_000, 60_000)
"""Bytes per file, reached by rings.csv and metadata, by an array, by a picture."""


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX resource limits")
@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("old", [False, True], ids=["nothing there", "old result there"])
def test_a_full_disk_is_told_and_leaves_what_was_there(scan, tmp_path, limit, old):
    out = tmp_path / "out"
    if old:
        assert profile(scan).status == DONE
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}

    with small_disk(limit):
        outcome = calibore("profile", scan, "--out", out)
    refused(outcome, str(out), "the disk is full or a size limit is reached", "Free some space or choose a folder")
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert out.exists() == old
    assert not stray_files(out)


# The command line


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
    assert "Usage: calibore" in outcome.err
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
