"""A specification gives the survey it describes, and a mistake in it one sentence."""

import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.scans import Profile
from calibore.simulation import (
    ConicalProtrusion,
    Corrugation,
    Crack,
    MeasuredWall,
    PipeWall,
    Wander,
    read_survey,
    simulate_scan,
)

EXAMPLES = Path(__file__).parents[2] / "examples"
INCH = 0.0254
RIG = (EXAMPLES / "test-pipe-rig.toml").read_text(encoding="utf-8")
SMALL = RIG.replace("1024", "240").replace("768", "180").replace("571.0", "134").replace("[512.0, 384.0]", "[120, 90]")
SPEC = """
format = "calibore-simulation/1"
name = "small"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
parts = [{ kind = "corrugation", amplitude = "1 mm", pitch = "40 mm" }]
[motion]
axial = { origin = "-13.1 in", step = "10 mm", stations = 2 }
"""


def _written(folder, text=SPEC, rig=SMALL):
    (folder / "rig.toml").write_text(rig, encoding="utf-8")
    (folder / "spec.toml").write_text(text, encoding="utf-8")
    return folder / "spec.toml"


def test_the_example_describes_the_test_pipe_of_the_dissertation():
    survey, seed = read_survey(EXAMPLES / "test-pipe.toml")
    assert seed == 1
    assert len(survey.stations) == 10
    assert survey.stated is not None
    assert survey.rig.lasers[0].surface != survey.stated.lasers[0].surface  # drawn
    wall = survey.wall
    assert wall.radius(4 * INCH, np.radians(32)) == pytest.approx(4.8 * INCH, abs=0.03 * INCH)
    assert wall.radius(9 * INCH, np.pi) == pytest.approx(5.2 * INCH, abs=1e-5)
    assert wall.radius(4 * INCH, np.radians(102.5)) > 6.08 * INCH  # in the crack


@pytest.mark.slow
def test_a_simulated_scan_is_measured_as_well_as_is_stated(tmp_path):
    from calibore.profiling import profile_scan
    from calibore.scans import open_profile

    survey, seed = read_survey(_written(tmp_path, SPEC.replace('"small"', '"small"\ndrawn = true')))
    scan = simulate_scan(tmp_path / "scan", survey, seed=seed)
    profile_scan(scan, tmp_path / "out")
    found = open_profile(tmp_path / "out")
    with np.load(scan / "truth.npz") as truth:
        error = np.asarray(found["radius"]) - truth["ring_rig_R"][:, 0] * INCH
    u = np.hypot(np.asarray(found["u_independent"]), np.asarray(found["u_common"]))
    inside = np.abs(error) <= 1.96 * u
    assert np.mean(inside[np.isfinite(error)]) > 0.85


def test_the_same_seed_gives_the_same_scan_and_another_one_another(tmp_path):
    spec, pictures = _written(tmp_path), []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        survey, chosen = read_survey(spec, seed=seed)
        simulate_scan(tmp_path / name, survey, seed=chosen)
        pictures.append((tmp_path / name / "pipe 000 0.png").read_bytes())
    assert pictures[0] == pictures[1] != pictures[2]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (('"corrugation"', '"wave"'), r"key pipe\.parts\[0\].*wave"),
        (('pitch = "40 mm"', "pitch = 40"), r"pitch = 40 is wrong: 40 has no unit"),
        (('pitch = "40 mm"', 'pitch = "0 mm"'), r"pitch of a corrugation must be positive"),
        (('amplitude = "1 mm"', 'amplitude = "0.3 m"'), r"beyond the axis of a pipe"),
        (('"rig.toml"', '"no.toml"'), r"no\.toml does not exist"),
        (("stations = 2", "stations = 0"), r"key motion\.axial\.stations = 0 is wrong"),
        (('name = "small"', 'name = "small"\ntakes = 2'), r"key takes is not known; allowed here"),
        (('name = "small"', 'name = "small"\ndrawn = true\ntrue_rig = "rig.toml"'), r"not both"),
        (("[motion]", '[motion]\nangular = { step = "10 deg", stops = 3 }'), r"side-facing head needs motion\.angular"),
        (('"6 in"', '"-6 in"'), r"nominal_radius .* must be greater than 0"),
    ],
)
def test_a_mistake_is_named_in_one_sentence(tmp_path, wrong, said):
    assert wrong[0] in SPEC
    with pytest.raises(InputError, match=said):
        read_survey(_written(tmp_path, SPEC.replace(*wrong)))


def test_a_carriage_wanders_by_what_is_stated_and_stays_where_it_was():
    wander = Wander(roll=0.01, tilt=0.002, shift=1e-3, axial=5e-4, seed=3)
    poses = [wander.at(station) for station in range(400)]
    shift = np.array([pose.translation for pose in poses])
    np.testing.assert_allclose(shift.std(axis=0), [1e-3, 1e-3, 5e-4], rtol=0.12)
    roll = np.array([np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0]) for pose in poses])
    assert roll.std() == pytest.approx(0.01, rel=0.12)
    assert np.array_equal(wander.at(7).rotation, poses[7].rotation)
    with pytest.raises(InputError, match="must not be negative"):
        Wander(roll=-1.0)


def test_no_part_stands_further_than_it_says():
    rng = np.random.default_rng(2)
    parts = [
        ConicalProtrusion(0.03, 0.04, 0.002, 1.0, 0.1),
        Crack(0.002, 0.003, (0.0, 0.2), (6.2, 0.1)),
        Corrugation(0.002, 0.04, 0.01),
    ]
    axial, clock = rng.uniform(-0.1, 0.3, 20_000), rng.uniform(0, 2 * np.pi, 20_000)
    for part in parts:
        radius = PipeWall(0.15, (part,)).radius(axial, clock)
        assert radius.min() >= 0.15 - part.reach(0.15) - 1e-12
        assert radius.max() <= 0.15 + part.recess(0.15) + 1e-12
        assert np.ptp(radius) > 0.9 * max(part.reach(0.15), part.recess(0.15))


def test_a_crack_runs_the_short_way_round():
    wall = PipeWall(0.15, (Crack(0.002, 0.003, (0.0, 0.2), (6.2, 0.1)),))
    middle = np.mod((6.2 + 0.1 + 2 * np.pi) / 2, 2 * np.pi)
    assert wall.radius(0.1, middle) == pytest.approx(0.153)
    assert wall.radius(0.1, np.pi) == 0.15


def test_a_measured_wall_is_what_was_measured_gaps_filled():
    true = PipeWall(0.15, (Corrugation(0.002, 0.08), ConicalProtrusion(0.01, 0.05, 0.04, 3.0, 0.1, edge=0.01)))
    axial, clock = np.arange(0, 0.2, 0.005), np.arange(200) * 2 * np.pi / 200
    z, c = np.meshgrid(axial, clock, indexing="ij")
    radius = true.radius(z, c)
    radius[5, 20:24] = np.nan
    shape = {"u_independent": np.zeros(z.shape), "common_mode": np.zeros((0, *z.shape))}
    shape |= {"axial_position": z, "correlation": np.zeros((40, 1)), "status": np.zeros(z.shape, dtype=np.uint8)}
    profile = Profile(axial=axial, clock=clock, radius=radius, **shape)
    assert {one.name for one in fields(Profile)} >= set(shape)
    part = MeasuredWall(profile)
    wall = PipeWall(0.15, (part,))
    np.testing.assert_allclose(wall.radius(z, c), true.radius(z, c), atol=2e-5)
    assert wall.radius(0.05, 6.28) == pytest.approx(float(true.radius(0.05, 6.28)), abs=2e-5)
    assert wall.clearance == pytest.approx(float(np.nanmin(radius)))


def test_the_command_makes_a_scan_that_can_be_profiled(tmp_path):
    spec = _written(tmp_path)
    run = [sys.executable, "-m", "calibore", "simulate", str(spec), "--out", str(tmp_path / "scan")]
    done = subprocess.run(run, capture_output=True, text=True, check=True)
    assert "Simulated 2 images at 2 stops" in done.stdout
    assert (tmp_path / "scan" / "truth.npz").is_file()
    spec.write_text(SPEC.replace('"1 mm"', "1"), encoding="utf-8")
    failed = subprocess.run(run, capture_output=True, text=True, check=False)
    assert failed.returncode == 1
    assert re.search(r"amplitude = 1 is wrong", failed.stderr)
    assert (tmp_path / "scan" / "scan.toml").is_file()
