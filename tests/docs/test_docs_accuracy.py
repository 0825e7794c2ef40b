"""The accuracy table of the README is what the scoring script says of this version."""

import importlib.util
from pathlib import Path

import pytest
from markdown_pages import ROOT

from calibore.profiling import profile_scan

SHARED = Path(__file__).parents[2].parent / "shared"
ROWS = [
    [cell.replace("*", "").strip().removesuffix(" in").removesuffix(" %") for cell in line.strip("|").split("|")]
    for line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    if line.startswith(("| plane-", "| field"))
]


@pytest.mark.parametrize(("name", "rms", "inside"), [(row[0].split()[0], row[-2], row[-1]) for row in ROWS])
def test_the_readme_states_the_measured_accuracy(name, rms, inside, tmp_path):
    scan = SHARED / "data" / "simulated" / name
    if not scan.exists():
        pytest.skip(f"the simulated surveys beside the repository (shared/data/simulated/{name}) are absent")
    profile_scan(scan, tmp_path / "out")
    specification = importlib.util.spec_from_file_location("score", SHARED / "tools" / "score.py")
    assert specification is not None
    assert specification.loader is not None
    score = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(score)
    found = score.score_ring(tmp_path / "out", scan / "truth.npz")
    assert found["rms_in"] == pytest.approx(float(rms), abs=0.00011)  # a unit of the last printed digit
    assert found["cover95_pct"] == pytest.approx(float(inside), abs=0.51)  # some points of hundreds lie on the verge
