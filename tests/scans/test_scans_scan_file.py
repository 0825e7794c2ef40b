"""scan.toml: what it says is read exactly, and every mistake in it becomes one sentence."""

import re
from pathlib import Path

import numpy as np
import pytest
from tiny_survey import SCAN, make_scan

from calibore.errors import InputError
from calibore.scans import AngularMotion, AxialMotion, read_scan

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
INCH = 0.0254


def test_a_scan_reads_the_same_from_its_folder_and_from_its_file(tmp_path):
    folder = make_scan(tmp_path / "a scan")
    scan = read_scan(folder)
    assert scan == read_scan(folder / "scan.toml") == read_scan(str(folder))
    assert (scan.name, scan.kind, scan.pattern) == ("tiny pipe", "forward-looking", "tiny {station:03d} {take}.png")
    assert scan.folder == folder.resolve()
    assert scan.rig_path == folder.resolve() / "rig.toml"
    assert scan.nominal_radius == pytest.approx(6 * INCH, rel=1e-15)
    assert (scan.search_inner, scan.search_outer, scan.limit_deflection_percent) == (0.5, 1.5, None)


def test_stations_stand_where_the_motion_puts_them(tmp_path):
    motion = read_scan(make_scan(tmp_path)).motion
    assert isinstance(motion, AxialMotion)
    np.testing.assert_allclose(motion.axial([0, 10, 25]), [-INCH, 0, 1.5 * INCH], atol=1e-15)
    np.testing.assert_allclose(AngularMotion(0.0, np.radians(0.9)).clock(400), 2 * np.pi, rtol=1e-15)


def test_optional_keys_are_read(tmp_path):
    text = SCAN.replace('"6 in"\n', '"6 in"\nlimit_deflection = 5\n') + "[search]\ninner = 0.8\nouter = 1.25\n"
    scan = read_scan(make_scan(tmp_path, text))
    assert (scan.limit_deflection_percent, scan.search_inner, scan.search_outer) == (5.0, 0.8, 1.25)


def test_a_video_scan_names_its_files(tmp_path):
    text = re.sub("pattern = .*", 'video = "run.mp4"', re.sub("axial = .*", 'table = "odometry.csv"', SCAN))
    for name in ("run.mp4", "odometry.csv"):
        (tmp_path / name).write_bytes(b"")
    scan = read_scan(make_scan(tmp_path, text))
    assert (scan.video, scan.motion, scan.pattern) == (tmp_path / "run.mp4", tmp_path / "odometry.csv", None)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("plane-12in", "forward-looking"),
        ("field", "forward-looking"),
        ("epochs/A", "forward-looking"),
        ("side-2.4in", "side-facing"),
        ("cone-dual", "forward-looking"),
        ("tactile", "tactile"),
    ],
)
def test_every_kind_of_simulated_scan_is_read(name, kind):
    if not SHARED.is_dir():
        pytest.skip(f"the simulated scans are not at {SHARED}")
    scan = read_scan(SHARED / name)
    assert scan.kind == kind
    assert scan.nominal_radius == pytest.approx((12 if name == "field" else 6) * INCH, rel=1e-12)
    assert (scan.tactile is not None) == (kind == "tactile")


MISTAKES = {
    "other format": (
        '"calibore-scan/1"',
        '"calibore-scan/2"',
        r"format = 'calibore-scan/2' is wrong: .*reads .* \"calibore-scan/1\"",
    ),
    "no format": ('format = "calibore-scan/1"', "", "key format is missing; add it"),
    "no name": ('name = "tiny pipe"', "", "key name is missing; add it"),
    "empty name": ('"tiny pipe"', '""', "key name = '' is wrong"),
    "no rig": ('rig = "rig.toml"', "", "key rig is missing; add the rig file"),
    "rig not there": ("rig.toml", "other.toml", 'rig = "other.toml" names no existing file; paths are relative to'),
    "no pipe": ('[pipe]\nnominal_radius = "6 in"\n', "", "key pipe is missing"),
    "no radius": ('nominal_radius = "6 in"', "", "key pipe.nominal_radius is missing"),
    "negative radius": (
        '"6 in"',
        '"-6 in"',
        r"pipe.nominal_radius = .* is wrong: it is -0.1524 m but must be greater than 0",
    ),
    "a pipe beyond all pipes": (
        '"6 in"',
        '"2e5 m"',
        r"it is 200000 m, but no radius, tip or step is longer than 1000 m",
    ),
    "zero radius": ('"6 in"', '"0 mm"', "must be greater than 0"),
    "NaN radius": ('"6 in"', '"nan in"', "pipe.nominal_radius = .* is wrong"),
    "bare NaN": ('"6 in"', "nan", "pipe.nominal_radius = nan is wrong: .*unit"),
    "no unit": ('"6 in"', "6", "pipe.nominal_radius = 6 is wrong: 6 has no unit"),
    "unit in text missing": ('"6 in"', '"6"', "pipe.nominal_radius = '6' is wrong: .*has no unit"),
    "unit of something else": ('"6 in"', '"6 deg"', 'is not a length such as "150 mm"'),
    "unit unknown": ('"6 in"', '"6 blobs"', "is not a length"),
    "unknown key": (
        'name = "tiny pipe"',
        'name = "x"\nnames = "y"',
        "key names is not known; allowed here: .*name, pipe, rig",
    ),
    "unknown key in pipe": (
        '"6 in"',
        '"6 in"\nradius = 3',
        "key pipe.radius is not known; allowed here: limit_deflection, limit_ovality, nominal_radius",
    ),
    "unknown key in axial": ('step = "0.1 in"', 'stop = "0.1 in"', "motion.axial"),
    "no step": (', step = "0.1 in"', "", "key motion.axial.step is missing"),
    "step zero": ('step = "0.1 in"', 'step = "0 in"', "motion.axial.step = .* is wrong: a step of 0"),
    "step without unit": ('step = "0.1 in"', "step = 0.1", "motion.axial.step = 0.1 is wrong: 0.1 has no unit"),
    "no motion": ("[motion]", "[motions]", "key motion is missing"),
    "neither motion": (re.compile("axial = .*"), "", "gives neither axial nor table; give exactly one"),
    "both motions": ("[motion]", '[motion]\ntable = "t.csv"', "gives both axial and table; give exactly one"),
    "table not there": (re.compile("axial = .*"), 'table = "t.csv"', 'motion.table = "t.csv" names no existing file'),
    "no images": (
        re.compile(r"\[images\]\npattern.*\n"),
        "",
        "names no data; give exactly one of images.pattern, images.video, images.stream",
    ),
    "pattern and video": (
        "[images]",
        '[images]\nvideo = "a.mp4"',
        "names images.pattern and images.video; give exactly one",
    ),
    "pattern and tactile": (
        "[motion]",
        '[tactile]\nsignal = "s"\nbias = "b"\ntip_radius = "1 mm"\n[motion]',
        r"names images.pattern and \[tactile\]",
    ),
    "video not there": (re.compile("pattern = .*"), 'video = "a.mp4"', 'images.video = "a.mp4" names no existing file'),
    "pattern without station": ("{station:03d} ", "", "has no field for the station"),
    "pattern with unknown field": ("{take}", "{shot}", "field {shot} is not known; allowed: station, angular, take"),
    "pattern with broken field": ("{take}", "{take", "images.pattern = .* is wrong: .*Write fields such as"),
    "pattern with wrong format": ("{station:03d}", "{station:03q}", "images.pattern = .* is wrong: .*Write fields"),
    "angular only in pattern": ("{take}", "{angular:03d} {take}", r"\[motion\] gives no angular"),
    "angular only in motion": (
        "[motion]",
        '[motion]\nangular = { origin = "0 deg", step = "0.9 deg" }',
        "the pattern has no field {angular}",
    ),
    "limit as text": ('"6 in"', '"6 in"\nlimit_deflection = "5 %"', "pipe.limit_deflection = '5 %' is wrong"),
    "limit negative": ('"6 in"', '"6 in"\nlimit_deflection = -5', "pipe.limit_deflection = -5 is wrong"),
    "inner beyond the wall": (
        "[motion]",
        "[search]\ninner = 1.2\n[motion]",
        "search.inner = 1.2 is wrong: .*less than 1",
    ),
    "outer inside the wall": (
        "[motion]",
        "[search]\nouter = 0.9\n[motion]",
        "search.outer = 0.9 is wrong: .*greater than 1",
    ),
    "broken TOML": ('name = "tiny pipe"', 'name = "tiny pipe', "is not valid TOML: .*line 2"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_file_key_and_remedy(tmp_path, mistake):
    old, new, sentence = MISTAKES[mistake]
    text = old.sub(new, SCAN) if isinstance(old, re.Pattern) else SCAN.replace(old, new, 1)
    assert text != SCAN
    with pytest.raises(InputError, match=sentence) as caught:
        read_scan(make_scan(tmp_path, text))
    message = str(caught.value)
    assert "scan.toml" in message
    assert "\n" not in message
    assert message.rstrip(")").endswith(".")


def test_a_folder_without_scan_file_and_a_path_that_is_not_there_are_named(tmp_path):
    with pytest.raises(InputError, match=r"has no scan\.toml; give a folder that holds one"):
        read_scan(tmp_path)
    with pytest.raises(InputError, match=r"nowhere does not exist; give a scan folder or its scan\.toml"):
        read_scan(tmp_path / "nowhere")
    (tmp_path / "scan.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"cannot be read .*UTF-8"):
        read_scan(tmp_path)


def test_identity_survives_corrections_and_moving_but_not_another_scan(tmp_path):
    first = read_scan(make_scan(tmp_path / "1" / "survey")).identity
    corrected = SCAN.replace("6 in", "155 mm").replace("0.1 in", "2.5 mm") + "# noted\n"
    assert read_scan(make_scan(tmp_path / "2" / "survey", corrected)).identity == first
    others = [
        make_scan(tmp_path / "other"),
        make_scan(tmp_path / "3" / "survey", SCAN.replace("tiny pipe", "tiny pipe B")),
        make_scan(tmp_path / "4" / "survey", SCAN.replace("tiny {", "small {")),
    ]
    assert len({first, *(read_scan(folder).identity for folder in others)}) == 4
