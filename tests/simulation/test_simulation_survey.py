"""Simulated scan folders are read by the program's own readers, and carry their truth."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.errors import OutputError
from calibore.geometry import Pose
from calibore.images import read_image
from calibore.lasers import Plane
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.rigs import Laser, Rig, project_ring, read_rig
from calibore.scans import AxialMotion, read_scan
from calibore.simulation import (
    Dent,
    LineLight,
    PipeWall,
    Station,
    Survey,
    demo_survey,
    draw_rig,
    lit_line,
    random_pose,
    random_rig,
    random_wall,
    simulate_scan,
)
from calibore.simulation._files import write_png

INCH = 0.0254
CAMERA = Camera(240, 180, Lens("sine-law", 135.0, 90.0), (120.5, 89.0))
SMALL = Survey(
    name='a "small" pipe',
    rig=Rig("perpendicular-plane", CAMERA, (Laser(Plane(0.33, 0.01, -0.002), "red"),)),
    wall=PipeWall(6 * INCH, (Dent(0.005, 1.0, 0.1, 0.2, 0.05),)),
    stations=(Station(0), Station(4, takes=2), Station(12, line=LineLight(shadows=((2.0, 0.5),)))),
    origin=-0.3,
    step=0.01,
    pose=Pose.from_roll_pitch_yaw(0.02, translation=(0.002, 0.001, 0.0)),
)


def test_the_folder_is_a_scan_that_the_readers_accept(tmp_path):
    counted = []
    folder = simulate_scan(tmp_path / "scan", SMALL, seed=1, progress=lambda done, total: counted.append((done, total)))
    scan = read_scan(folder)
    assert scan.name == SMALL.name
    assert scan.nominal_radius == pytest.approx(6 * INCH, abs=1e-12)
    assert scan.motion == AxialMotion(-0.3, 0.01)
    assert counted == [(1, 4), (2, 4), (3, 4), (4, 4)]
    names = {"pipe 000 0.png", "pipe 004 0.png", "pipe 004 1.png", "pipe 012 0.png"}
    assert {path.name for path in folder.iterdir()} == {*names, "rig.toml", "scan.toml", "truth.npz"}
    assert {read_image(folder / name).shape for name in names} == {(180, 240, 3)}
    rig = read_rig(scan.rig_path)
    assert (rig.camera, rig.lasers) == (CAMERA, SMALL.rig.lasers)


def test_truth_has_the_shapes_that_scoring_expects(tmp_path):
    folder = simulate_scan(tmp_path / "scan", SMALL, seed=1)
    with np.load(folder / "truth.npz") as truth:
        assert truth["stop"].tolist() == [0, 4, 12]
        for key in ("ring_rig_R", "ring_rig_H", "ring_rig_visible", "ring_rig_signal"):
            assert truth[key].shape == (3, 1, 400)
        assert truth["ring_rig_visible"].dtype == bool
        radius, visible = truth["ring_rig_R"][:, 0], truth["ring_rig_visible"][:, 0]
        assert np.abs(radius - 6).max() < 0.3  # inches: dent and off-centre rig
        assert visible[:2].all()
        assert 360 < visible[2].sum() < 372  # the strut takes 0.5 rad of 400 positions
        assert truth["true_axial"] == pytest.approx([-0.3, -0.26, -0.18])
        assert truth["pose_t"][:, 2] * INCH == pytest.approx(truth["true_axial"])
        assert truth["pose_R"].shape == (3, 3, 3)
        for key in ("diameter_mean", "diameter_min", "diameter_max"):
            assert truth[f"true_{key}"] == pytest.approx(12 * INCH, rel=0.03)
        assert np.all(truth["true_diameter_min"] < truth["true_diameter_mean"])
        assert truth["true_ovality_range"].shape == truth["true_deflection"].shape == (3,)


def test_the_same_seed_gives_the_same_bytes_and_another_seed_other_images(tmp_path):
    one, same, other = (
        simulate_scan(tmp_path / name, SMALL, seed=seed) for name, seed in (("a", 1), ("b", 1), ("c", 2))
    )
    for path in one.iterdir():
        assert path.read_bytes() == (same / path.name).read_bytes()
    assert (one / "pipe 000 0.png").read_bytes() != (other / "pipe 000 0.png").read_bytes()


def test_takes_differ_but_show_the_same_wall(tmp_path):
    folder = simulate_scan(tmp_path / "scan", SMALL, seed=1)
    one, two = (read_image(folder / f"pipe 004 {take}.png")[:, :, 0].astype(float) for take in (0, 1))
    assert not np.array_equal(one, two)
    bright = one > 60
    assert np.corrcoef(one[bright], two[bright])[0, 1] > 0.5


def test_an_earlier_simulation_is_replaced_but_no_other_folder(tmp_path):
    folder = simulate_scan(tmp_path / "scan", SMALL, seed=1)
    fewer = replace(SMALL, stations=SMALL.stations[:1])
    assert len(list(simulate_scan(folder, fewer, seed=1).iterdir())) == 4
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        simulate_scan(folder, fewer, seed=1)
    assert (folder / "notes.txt").read_text() == "mine"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.doc").write_text("years of work")
    with pytest.raises(OutputError, match="choose an empty or new folder"):
        simulate_scan(tmp_path / "other", fewer, seed=1)


def test_an_interrupted_simulation_leaves_nothing(tmp_path):
    def interrupt(done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_scan(tmp_path / "scan", SMALL, seed=1, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_an_output_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        simulate_scan(tmp_path / "file" / "scan", SMALL, seed=1)
    with pytest.raises(OutputError):
        simulate_scan(tmp_path / "file", SMALL, seed=1)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_png_keeps_every_pixel(tmp_path, dtype):
    image = np.random.default_rng(0).integers(0, np.iinfo(dtype).max, (37, 53, 3), endpoint=True).astype(dtype)
    write_png(tmp_path / "image.png", image)
    read = read_image(tmp_path / "image.png")
    assert read.dtype == dtype
    assert np.array_equal(read, image)


def test_random_rings_fit_their_images_and_use_all_lens_laws():
    rng, laws, baselines = np.random.default_rng(6), set(), []
    for _ in range(40):
        wall = random_wall(rng)
        rig = random_rig(rng, wall.nominal_radius)
        pose, surface = random_pose(rng, rig, wall.nominal_radius), rig.lasers[0].surface
        lit = lit_line(rig, wall, pipe_from_rig=pose, line=LineLight(), psf_sigma=0.9)
        assert np.abs(lit.u - 255.5).max() < 254
        assert np.abs(lit.v - 191.5).max() < 190
        assert lit.visible.mean() > 0.8
        assert np.hypot(surface.tilt_x, surface.tilt_y) <= np.tan(np.radians(1.0)) + 1e-12
        laws.add(rig.camera.lens.law)
        baselines.append(surface.baseline / wall.nominal_radius)
    assert laws == set(LENS_LAWS)
    assert 0.6 <= min(baselines) < 0.8
    assert 2.4 < max(baselines) <= 3.0


def test_true_rigs_scatter_about_the_stated_one_as_stated():
    stated = random_rig(np.random.default_rng(7), 0.2)
    rng = np.random.default_rng(8)
    drawn = [draw_rig(stated, rng) for _ in range(2000)]
    for values, centre, name in (
        ([rig.camera.lens.k for rig in drawn], stated.camera.lens.k, "camera.k"),
        ([rig.lasers[0].surface.baseline for rig in drawn], stated.lasers[0].surface.baseline, "laser.baseline"),
        ([rig.lasers[0].surface.tilt_y for rig in drawn], stated.lasers[0].surface.tilt_y, "laser.tilt_y"),
        (
            [rig.camera.principal_point[1] for rig in drawn],
            stated.camera.principal_point[1],
            "camera.principal_point_v",
        ),
    ):
        u = float(stated.covariance.restricted([name]).u[0])
        assert np.std(values) == pytest.approx(u, rel=0.06)
        assert np.mean(values) == pytest.approx(centre, abs=0.1 * u)


def test_the_demonstration_pipe_grows_oval_and_its_ring_fits_the_image():
    survey = demo_survey(seed=1)
    assert survey.rig is not survey.stated
    for station in (survey.stations[0], survey.stations[-1]):
        _, lit = survey.line_at(station)
        assert lit.visible.mean() > 0.95
    clock, u, v = project_ring(survey.stated, 6 * INCH, 400)
    assert np.isfinite([clock, u, v]).all()
    ovality = [np.ptp(survey.wall.radius(n * survey.step, np.linspace(0, np.pi / 2 * 4, 400))) for n in (3, 9)]
    assert ovality[1] > 2 * ovality[0]
