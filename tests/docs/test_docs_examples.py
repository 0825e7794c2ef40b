"""The scripts in examples/ do what they say."""

import re
import runpy
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from markdown_pages import ROOT

from calibore.calibration import calibrate, read_calibration
from calibore.images import read_image
from calibore.profiling import profile_scan
from calibore.simulation import demo_survey, simulate_scan

SCRIPT = ROOT / "examples" / "read_a_result.py"
PHOTOGRAPHER = ROOT / "examples" / "photograph_a_target.py"


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Stations 5 and 8 of the demonstration pipe, the worst of all its rings among them, and their truth."""
    folder = tmp_path_factory.mktemp("example")
    survey = demo_survey(seed=1)
    survey = replace(survey, stations=tuple(replace(survey.stations[i], takes=1) for i in (5, 8)))
    profile_scan(simulate_scan(folder / "scan", survey, seed=1), folder / "out")
    with np.load(folder / "scan" / "truth.npz") as truth:
        return folder / "out", dict(truth)


def run(*arguments, script=SCRIPT):
    return subprocess.run([sys.executable, script, *arguments], capture_output=True, text=True, check=False, timeout=60)


def test_the_worst_station_is_named_with_intervals_that_hold_the_truth(result):
    out, truth = result
    done = run(out)
    assert done.returncode == 0, done.stderr
    sentence = re.fullmatch(
        r"Worst station 8 at \d+\.\d{3} m: "
        r"ovality \S+ % \((\S+) to (\S+) %\), deflection \S+ % \((\S+) to (\S+) %\)\.\n",
        done.stdout,
    )
    assert sentence, done.stdout
    low, high, *deflection = map(float, sentence.groups())
    assert low < max(truth["true_ovality_f1216_max"][1], truth["true_ovality_f1216_min"][1]) < high
    assert deflection[0] < truth["true_deflection"][1] < deflection[1]


def test_without_a_result_it_says_how_it_is_called():
    done = run()
    assert done.returncode != 0
    assert "read_a_result.py RESULT" in done.stderr


def photographed(folder, kind, **settings):
    """As the script photographs it, with some of its settings changed to take fewer pictures."""
    script = runpy.run_path(str(PHOTOGRAPHER))
    script[kind].__globals__.update(settings)
    folder.mkdir()
    script[kind](folder, np.random.default_rng(1))
    return script


@pytest.mark.slow
def test_the_gauges_that_the_example_photographs_calibrate_its_rig(tmp_path):
    done = run(tmp_path / "gauges", "gauges", script=PHOTOGRAPHER)
    assert done.returncode == 0, done.stderr
    said = re.fullmatch(r"True values: baseline (\S+) mm, tilt x (\S+), tilt y (\S+)\n", done.stdout)
    assert said, done.stdout
    words = ("calibrate", "rig", tmp_path / "gauges", "--out", tmp_path / "rig.toml")
    done = subprocess.run([sys.executable, "-m", "calibore", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = read_calibration(tmp_path / "rig.toml")
    truth = np.array([float(said[1]) * 1e-3, float(said[2]), float(said[3])])
    names = ("laser.baseline", "laser.tilt_x", "laser.tilt_y")
    off = np.array([found.values[name] for name in names]) - truth
    assert np.abs(off / found.covariance.restricted(names).u).max() < 3.2


@pytest.mark.slow
def test_the_rings_that_the_example_photographs_calibrate_its_lens(tmp_path):
    camera = photographed(tmp_path / "rings", "rings", DISTANCES=(0.12,))["CAMERA"]
    found = calibrate("lens", tmp_path / "rings")
    assert found.rig.camera.lens.law == camera.lens.law
    names = ("camera.k", "camera.principal_point_u", "camera.principal_point_v")
    off = np.array([found.values[name] for name in names]) - (camera.lens.k, *camera.principal_point)
    assert np.abs(off / found.covariance.restricted(names).u).max() < 3.2


def test_the_boards_that_the_example_photographs_are_found(tmp_path):
    pytest.importorskip("cv2")
    from calibore.targets import find_board

    script = photographed(tmp_path / "board", "chessboard", COUNT=3)
    for number in range(3):
        image = read_image(tmp_path / "board" / f"board {number}.png")
        assert find_board(image, kind="chessboard", corners=script["CORNERS"]).u.size == 35


def test_a_kind_that_the_photographer_does_not_know_is_answered_with_what_it_knows(tmp_path):
    script = runpy.run_path(str(PHOTOGRAPHER))
    for words in ([], ["--help"], [str(tmp_path / "out"), "tea-leaves"], [str(tmp_path / "out"), "rings", "more"]):
        with pytest.raises(SystemExit, match=r"photograph_a_target.py FOLDER \[KIND\]"):
            script["main"](words)
    assert not (tmp_path / "out").exists()
