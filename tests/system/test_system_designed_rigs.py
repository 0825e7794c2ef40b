"""A rig that the designer recommends, written as a file, measures a simulated pipe as well as its result says."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.design import HONEST, Study
from calibore.geometry import Pose
from calibore.profiling import profile_scan
from calibore.rigs import read_rig, write_rig
from calibore.scans import open_profile
from calibore.simulation import Ovality, PipeWall, Sensor, Station, Survey, draw_rig, simulate_scan

RADIUS = 0.15
INCH = 0.0254


@pytest.mark.parametrize(
    "study",
    [
        Study("perpendicular-plane", RADIUS, maximum_radius=1.5, lens="equisolid-angle"),
        Study("single-cone", RADIUS),
        Study("dual-cone", RADIUS),
        Study("coaxial-cone", RADIUS, maximum_radius=1.5),
        Study("reversed-cone", RADIUS, maximum_radius=1.5, lens="sine-law"),
    ],
    ids=lambda study: study.configuration,
)
def test_a_designed_rig_is_written_simulated_and_profiled_within_its_uncertainty(study, tmp_path):
    study = replace(study, inputs=HONEST, width=640, height=480)
    write_rig(study.rig(), tmp_path / "rig.toml")
    stated = read_rig(tmp_path / "rig.toml")
    takes = max((take for laser in stated.lasers for take in laser.takes or (0,)), default=0) + 1
    wall = PipeWall(RADIUS, (Ovality((1.0, 1.0), axial=(-1.0, 1.0)),))
    survey = Survey(
        "designed",
        draw_rig(stated, np.random.default_rng(1)),
        wall,
        tuple(Station(number, takes=takes) for number in range(3)),
        0.0,
        0.01,
        Pose.identity(),
        sensor=Sensor(speckle_contrast=0.3),
        stated=stated,
    )
    summary = profile_scan(simulate_scan(tmp_path / "scan", survey, seed=2), tmp_path / "result")
    assert summary["counts"]["refused_images"] == 0
    profile, truth = open_profile(tmp_path / "result"), np.load(tmp_path / "scan" / "truth.npz")
    true = np.where(truth["ring_rig_visible"], truth["ring_rig_R"], np.nan) * INCH
    error = profile["radius"].values - np.nanmean(true, axis=1)  # of a straight pipe, whichever laser lights it
    u = np.hypot(profile["u_independent"].values, profile["u_common"].values)
    measured = np.isfinite(error)
    assert measured.mean() > 0.9
    assert (np.abs(error) <= 1.96 * u)[measured].mean() > 0.9
    assert np.sqrt(np.mean((error / u)[measured] ** 2)) < 1.3
