"""Specifications of targets and of scans by touch: what they say is made, and a mistake is named with its key."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from calibore.calibration import calibrate
from calibore.cli import app
from calibore.errors import InputError
from calibore.rigs import read_rig, write_rig
from calibore.simulation import (
    BoardTarget,
    GaugeTarget,
    PinTarget,
    ProbeTarget,
    RangeTarget,
    RingTarget,
    Survey,
    TactileSurvey,
    random_rig,
    read_subject,
    simulate,
)

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "how-to" / "simulate.md").read_text(encoding="utf-8")
INCH = 0.0254
HEAD = 'format = "calibore-simulation/1"\nname = "made"\nseed = 7\n'
CAMERA = """format = "calibore-rig/1"
[camera]
width = 640
height = 480
lens = "equidistant"
k = 300.0
principal_point = [325.0, 236.0]
"""
TARGETS = {
    "rings": 'rig = "plane.toml"\n[target]\nkind = "concentric-rings"\nring_spacing = "20 mm"\nrings = 8\n',
    "range": 'rig = "head.toml"\n[target]\nkind = "range"\nindices = [30, 40, 50]\nstep = "5 mm"\n',
    "gauges": 'rig = "plane.toml"\n[target]\nkind = "ring-gauge"\ngauges = [{ diameter = "300 mm" }]\nu = "0.01 mm"\n',
    "pins": """[target]
kind = "two-pin"
camera = "lens.toml"
pupil = "31 mm"
slides = ["15 mm", "30 mm"]
turns = ["-6 deg", "6 deg"]
near = { x = "0.5 mm", z = "127 mm", radius = "0.8 mm", top = "-1 mm", bottom = "80 mm" }
far = { x = "-0.8 mm", z = "560 mm", radius = "2.3 mm", top = "-90 mm", bottom = "6 mm" }
""",
    "board": '[target]\nkind = "chessboard"\ncamera = "lens.toml"\ncorners = [7, 5]\nsquare = "24 mm"\nboards = 3\n',
    "probe": """[target]
kind = "probe"
probe = { slope = "133 mm", intercept = "116 mm", noise = "0.015 mm", stroke = [0.02, 0.65] }
contacts = [["152 mm", "143 mm"], ["151 mm", "141 mm"]]
wrong = ["0 mm", "0.5 mm"]
stated = { u_contact = "0.03 mm" }
""",
}
KINDS = dict(zip(TARGETS, (RingTarget, RangeTarget, GaugeTarget, PinTarget, BoardTarget, ProbeTarget), strict=True))
TOUCH = """
[pipe]
nominal_radius = "6 in"
[tactile]
tip_radius = "0.0625 in"
probe = { slope = "5.24 in", intercept = "4.57 in", noise = "0.0006 in", stroke = [0.02, 0.65] }
sticking = { probability = 0.5 }
[motion]
axial = { origin = "0 in", step = "0.1 in", stations = 3 }
angular = { stops = 40 }
"""


@pytest.fixture(scope="module")
def rigs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rigs")
    write_rig(random_rig(np.random.default_rng(1), 0.15, kind="side-facing"), folder / "head.toml")
    rig = read_rig(ROOT / "examples" / "test-pipe-rig.toml")
    write_rig(rig, folder / "plane.toml")
    (folder / "lens.toml").write_text(CAMERA)
    return folder


def read(folder, text, *, seed=None):
    (folder / "spec.toml").write_text(HEAD + text, encoding="utf-8")
    return read_subject(folder / "spec.toml", seed=seed)


@pytest.mark.parametrize("name", TARGETS)
def test_every_kind_of_target_is_read_as_its_own(rigs, name):
    target, seed = read(rigs, TARGETS[name])
    assert isinstance(target, KINDS[name])
    if name in ("range", "gauges"):
        thick, _ = read(rigs, TARGETS[name] + '[line]\nsigma = "0.4 mm"\n[sensor]\nbits = 16\n')
        assert isinstance(thick, RangeTarget | GaugeTarget)
        assert (thick.line.sigma, thick.sensor.bits) == (pytest.approx(0.0004), 16)
    assert seed == 7
    assert read(rigs, TARGETS[name], seed=8)[1] == 8


def test_what_is_written_of_a_probe_is_what_is_calibrated(rigs, tmp_path):
    target, seed = read(rigs, TARGETS["probe"])
    folder = simulate(tmp_path / "probe", target, seed=seed)
    said = tomllib.loads((folder / "target.toml").read_text())
    assert said["u_contact"] == "0.03 mm"
    assert np.load(folder / "truth.npz")["wrong"] == pytest.approx([0, 0.0005])
    assert calibrate("probe", folder).values["probe.slope"] == pytest.approx(0.133, rel=1e-3)


def test_a_true_rig_is_drawn_from_what_its_file_states(rigs):
    plain, _ = read(rigs, TARGETS["rings"])
    drawn, _ = read(rigs, "drawn = true\n" + TARGETS["rings"])
    assert isinstance(plain, RingTarget)
    assert isinstance(drawn, RingTarget)
    assert plain.plane.baseline == plain.nominal_baseline == drawn.nominal_baseline
    assert 0 < abs(drawn.plane.baseline - plain.plane.baseline) < 0.01
    assert drawn.camera.lens.k != plain.camera.lens.k


def test_a_scan_by_touch_is_read_and_made(rigs, tmp_path):
    touch, seed = read(rigs, TOUCH)
    assert isinstance(touch, TactileSurvey)
    assert touch.tip_radius == pytest.approx(INCH / 16)
    assert (touch.stations, touch.stops, touch.sticking.probability) == (3, 40, 0.5)
    folder = simulate(tmp_path / "scan", touch, seed=seed)
    assert np.loadtxt(folder / "signal.csv", delimiter=",").shape == (3, 40)
    with_file = TOUCH.replace("[tactile]", '[tactile]\nstated = "probe.toml"')
    (rigs / "probe.toml").write_text('format = "calibore-rig/1"\n[probe]\nslope = "133 mm"\nintercept = "116 mm"\n')
    stated, _ = read(rigs, with_file)
    assert isinstance(stated, TactileSurvey)
    assert stated.stated is not None
    assert stated.stated.slope == pytest.approx(0.133)


def test_the_examples_of_the_page_are_specifications(tmp_path):
    found = re.findall(r"```toml\n(format = .*?)```", PAGE, flags=re.DOTALL)
    kinds = set()
    for number, text in enumerate(found):
        (tmp_path / "rig.toml").write_text((ROOT / "examples" / "test-pipe-rig.toml").read_text())
        (tmp_path / f"{number}.toml").write_text(text.replace("examples/test-pipe-rig.toml", "rig.toml"))
        kinds.add(type(read_subject(tmp_path / f"{number}.toml")[0]))
    assert kinds == {Survey, TactileSurvey, RingTarget}


@pytest.mark.parametrize(
    ("text", "wrong", "said"),
    [
        (TARGETS["rings"], ('"concentric-rings"', '"triangle"'), r"key target\.kind = 'triangle' is wrong: .*'range'"),
        (TARGETS["rings"], ("rings = 8", "ring = 8"), r"key target\.rings is missing.*1 more mistake"),
        (TARGETS["rings"], ('"plane.toml"', '"head.toml"'), r"spec\.toml: rings lie in a plane.*side-facing rig"),
        (
            TARGETS["rings"],
            ('"20 mm"', '"20 mm"\nink_width = "30 mm"'),
            r"spec\.toml: Lines .* thinner than their",
        ),
        (TARGETS["rings"], ('rig = "plane.toml"\n', ""), r"key rig is missing"),
        (TARGETS["range"], ('"head.toml"', '"plane.toml"'), r"kind range is for side-facing heads; plane\.toml"),
        (TARGETS["range"], ("30", "-30"), r"key target\.indices\[0\] = -30 is wrong"),
        (TARGETS["gauges"], ('"300 mm"', '"0 mm"'), r"key target\.gauges\[0\]\.diameter = '0 mm' is wrong"),
        (TARGETS["pins"], ('"lens.toml"', '"no.toml"'), r"no\.toml does not exist"),
        (TARGETS["board"], ("boards = 3", "boards = 0"), r"key target\.boards = 0 is wrong"),
        (TARGETS["probe"], ('"0 mm", ', ""), r"as many stops and wrong as contacts: 2, got 0 and 1"),
        (TOUCH, ('"0.0625 in"', '"7 in"'), r"ball's radius must be positive and small in the pipe"),
        (TOUCH, ("probability = 0.5", "probability = 5"), r"key tactile\.sticking\.probability = 5 is wrong"),
        (TOUCH, ("[motion]", "[target]\n[motion]"), r"gives both \[tactile\] and \[target\]"),
        (TOUCH, ("[tactile]", 'rig = "plane.toml"\n[tactile]'), r"key pipe\.rig is not known"),
    ],
)
def test_a_mistake_is_named_in_one_sentence(rigs, text, wrong, said):
    assert wrong[0] in text
    with pytest.raises(InputError, match=said):
        read(rigs, text.replace(*wrong))


def test_the_command_makes_both_and_says_what_to_do_with_them(rigs, tmp_path):
    for text, made, use in (
        (TOUCH, "Simulated 120 readings of 3 rings", "calibore profile"),
        (TARGETS["probe"], "Simulated the tables of a probe", "calibore calibrate probe"),
    ):
        (rigs / "spec.toml").write_text(HEAD + text)
        arguments = ["simulate", str(rigs / "spec.toml"), "--out", str(tmp_path / use)]
        done = CliRunner().invoke(app, arguments)
        assert made in done.output
        assert use in done.output
        again = CliRunner().invoke(app, [*arguments, "--json"])
        assert json.loads(again.output)["seed"] == 7
