"""The scripts in examples/ do what they say."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from markdown_pages import ROOT

from calibore.profiling import profile_scan
from calibore.simulation import demo_survey, simulate_scan

SCRIPT = ROOT / "examples" / "read_a_result.py"


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    """Stations 5 and 8 of the demonstration pipe, the worst of all its rings among them, and their truth."""
    folder = tmp_path_factory.mktemp("example")
    survey = demo_survey(seed=1)
    survey = replace(survey, stations=tuple(replace(survey.stations[i], takes=1) for i in (5, 8)))
    profile_scan(simulate_scan(folder / "scan", survey, seed=1), folder / "out")
    with np.load(folder / "scan" / "truth.npz") as truth:
        return folder / "out", dict(truth)


def run(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False, timeout=60)


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
