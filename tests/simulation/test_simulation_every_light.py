"""Lines of every kind of laser light: where they are, how bright, what a perfect measurement would find of them."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose, xy_of
from calibore.images import read_image
from calibore.lasers import GRAZING_SINE, Beam, Cone
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing, read_rig, triangulate
from calibore.scans import read_scan
from calibore.simulation import (
    RIG_KINDS,
    Dent,
    LineLight,
    Ovality,
    PipeWall,
    Rail,
    Sensor,
    Station,
    Survey,
    draw_rig,
    head_pose,
    line_image,
    lit_line,
    photograph,
    photograph_all,
    random_pose,
    random_rig,
    random_wall,
    simulate_scan,
    true_ring,
    true_rows,
)

R0 = 0.15
CONES = ("single-cone", "dual-cone", "coaxial-cone", "asymmetric-cone", "reversed-cone")
SIDEWAYS = ("side-facing", "rotating-spot")
LINE = LineLight(sigma=0.003 * R0)
CAMERA = Camera(512, 384, Lens("equidistant", 280.0, 192.0), (256.0, 190.0))
CONE = Rig("single-cone", CAMERA, (Laser(Cone.for_ring(0.5 * R0, 1.5 * R0, R0), "red"),))


def scenes(kind, seed, count=2):
    """(lit line, rig, wall, pose, laser) of random rigs of this kind in random pipes."""
    for number in range(count):
        rng = np.random.default_rng([seed, number])
        wall = random_wall(rng)
        rig = random_rig(rng, wall.nominal_radius, kind=kind)
        pose, laser = random_pose(rng, rig, wall.nominal_radius), int(rng.integers(len(rig.lasers)))
        line = LineLight(sigma=0.003 * wall.nominal_radius)
        yield lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=1.0, laser=laser), rig, wall, pose, laser


@pytest.mark.parametrize("kind", CONES + SIDEWAYS)
def test_the_line_lies_on_wall_and_laser_surface_and_is_found_where_it_is(kind):
    for lit, rig, wall, pose, laser in scenes(kind, 1):
        assert np.abs(rig.lasers[laser].surface.value(lit.points)).max() < 1e-12
        assert np.abs(wall.depth(pose.apply(lit.points))).max() < 1e-12
        seen = lit.visible
        error = []
        for branch in (0, 1) if kind in CONES else (0,):
            found = triangulate(rig, lit.u[seen], lit.v[seen], laser=laser, branch=branch)
            moved = np.linalg.norm(found.d_pixel, axis=(1, 2))
            error.append(np.linalg.norm(found.points - lit.points[seen], axis=1) / moved)
        rays = rig.mount.place(rig.camera.unproject(lit.u[seen], lit.v[seen])).direction
        gradient = rig.lasers[laser].surface.gradient(lit.points[seen])
        clear = np.abs(np.sum(rays * gradient, axis=1)) > 1.01 * GRAZING_SINE * np.linalg.norm(gradient, axis=1)
        assert clear.mean() > 0.9
        assert np.nanmin(np.array(error)[:, clear], axis=0).max() < 1e-9


@pytest.mark.parametrize("kind", CONES)
def test_nothing_stands_between_laser_and_lit_wall(kind):
    for lit, rig, wall, pose, laser in scenes(kind, 2):
        source = rig.lasers[laser].surface.apex
        fraction = np.linspace(0.05, 0.9995, 400)[:, None, None]
        way = pose.apply(source + fraction * (lit.points[::4] - source))
        assert (wall.depth(way) > 1e-9).any(axis=0).mean() < 0.005  # the very edges of shadows


@pytest.mark.parametrize("kind", CONES)
def test_the_true_ring_lies_on_wall_and_light_at_regular_clocks(kind):
    for lit, rig, wall, pose, laser in scenes(kind, 3):
        ring = true_ring(lit, rig, wall, pipe_from_rig=pose, line=LINE, laser=laser)
        there = np.isfinite(ring.radius)
        points = np.column_stack([*xy_of(ring.clock, ring.radius), ring.axial])[there]
        assert ring.clock == pytest.approx(np.radians(0.9) * np.arange(400))
        assert there.mean() > 0.95
        assert np.all(there | ~ring.visible)
        assert np.abs(wall.depth(pose.apply(points))).max() < 1e-12
        assert np.abs(rig.lasers[laser].surface.value(points)).max() < 1e-12
        assert np.all((ring.signal > 0) <= ring.visible)


def test_light_that_leaps_over_a_wall_leaves_a_gap_in_the_ring():
    wall = PipeWall(R0, (Rail(0.2 * R0, 0.1 * R0, clock=np.pi / 2, edge=0.01 * R0),))
    lit = lit_line(CONE, wall, pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0)
    ring = true_ring(lit, CONE, wall, pipe_from_rig=Pose.identity(), line=LINE)
    gap = ring.clock[np.isnan(ring.radius)]
    # seen from above, the rail at 3 o'clock hides the wall below it
    assert 3 < gap.size < 30
    assert np.all((gap > np.pi / 2) & (gap < np.pi / 2 + 0.4))


def test_a_line_is_thicker_where_its_light_grazes_the_wall():
    """Above the camera the light of a cone beside it falls at 18 deg on the wall, below at 45 deg."""
    lit = lit_line(CONE, PipeWall(R0), pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0)
    wide = np.linalg.norm(lit.spread, axis=1)
    crown, invert = (np.abs(np.cos(lit.clock) - sign) < 0.01 for sign in (1, -1))
    above, below = np.arctan2([0.5, 1.5], 1.5)
    # in the image lengths along the wall shrink alike: both lie on one ring across the axis
    assert wide[crown].mean() / wide[invert].mean() == pytest.approx(np.sin(below) / np.sin(above), rel=0.02)


def test_light_is_shared_evenly_among_the_angles_of_the_fan():
    coaxial = Rig("coaxial-cone", CAMERA, (Laser(Cone(0.0, 0.0, 0.8, offset=R0), "red"),))
    lit = lit_line(coaxial, PipeWall(R0), pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0)
    quarters = [lit.energy[(lit.clock >= q * np.pi / 2) & (lit.clock < (q + 1) * np.pi / 2)].sum() for q in range(4)]
    assert quarters == pytest.approx([np.mean(quarters)] * 4, rel=0.005)
    assert lit.signal == pytest.approx(LINE.brightness, rel=0.01)


def test_the_image_of_a_cone_line_is_as_bright_as_its_signal_and_keeps_all_light():
    rig = replace(CONE, camera=Camera(1024, 768, Lens("equidistant", 500.0, 384.0), (512.0, 380.0)))
    lit = lit_line(rig, PipeWall(R0, (Ovality((2.0, 2.0)),)), pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0)
    image = line_image(lit, (768, 1024), psf_sigma=1.0)
    for n in range(0, lit.u.size, 97):
        column, row = round(lit.u[n]), round(lit.v[n])
        assert image[row - 2 : row + 3, column - 2 : column + 3].max() == pytest.approx(lit.signal[n], rel=0.05)
    assert image.sum() == pytest.approx(lit.energy.sum(), rel=1e-3)


def test_lasers_lit_together_add_up():
    rng = np.random.default_rng(5)
    rig = random_rig(rng, R0, kind="dual-cone")
    rig = replace(rig, lasers=(rig.lasers[0], replace(rig.lasers[1], channel="green")))
    pose, wall = random_pose(rng, rig, R0), PipeWall(R0, (Ovality((2.0, 2.0)),))
    lines = {n: lit_line(rig, wall, pipe_from_rig=pose, line=LINE, psf_sigma=0.9, laser=n) for n in (0, 1)}
    given = {"line": LINE, "sensor": Sensor.perfect(bits=16), "rng": rng}
    both = photograph_all(lines, rig, **given).astype(float)
    one, two = (photograph(lines[n], rig, **given, laser=n).astype(float) for n in (0, 1))
    assert np.abs(both - np.minimum(one + two, 65535)).max() <= 1.5  # each is rounded
    assert np.argmax(one.sum(axis=(0, 1))) == 0
    assert np.argmax(two.sum(axis=(0, 1))) == 1
    assert not photograph_all({}, rig, **given).any()


@pytest.mark.parametrize("kind", SIDEWAYS)
def test_every_row_of_a_side_facing_image_shows_the_line_where_truth_says(kind):
    for lit, rig, wall, pose, _ in scenes(kind, 6):
        rows = true_rows(lit, rig, wall, pipe_from_rig=pose, line=LINE)
        image = line_image(lit, (rig.camera.height, rig.camera.width), psf_sigma=1.0)
        assert np.isfinite(rows.radius).mean() > 0.95
        found = triangulate(rig, rows.u[rows.visible], rows.row[rows.visible])
        assert found.radius == pytest.approx(rows.radius[rows.visible], abs=1e-9)
        assert found.axial == pytest.approx(rows.axial[rows.visible], abs=1e-9)
        points = np.column_stack([*xy_of(rows.clock, rows.radius), rows.axial])[rows.visible]
        assert np.abs(wall.depth(pose.apply(points))).max() < 1e-12
        slope = np.gradient(rows.u) if rows.u.size > 1 else np.zeros(1)
        smooth = np.flatnonzero(rows.visible & (np.abs(slope) < 0.3))
        columns = np.arange(rig.camera.width)
        for row in smooth[5:-5:40] if smooth.size > 10 else smooth:
            near = np.where(np.abs(columns - rows.u[row]) < 12, image[row], 0)
            assert near @ columns / near.sum() == pytest.approx(rows.u[row], abs=0.4)  # blur smooths the wall's grain


def test_the_line_of_a_smooth_wall_is_centred_in_every_row():
    wall = PipeWall(R0, (Ovality((2.0, 2.0), axis=1.0),))
    for seed in range(4):
        rng = np.random.default_rng([12, seed])
        rig = random_rig(rng, R0, kind="side-facing")
        pose = random_pose(rng, rig, R0)
        lit = lit_line(rig, wall, pipe_from_rig=pose, line=LINE, psf_sigma=1.0)
        rows = true_rows(lit, rig, wall, pipe_from_rig=pose, line=LINE)
        image = line_image(lit, (rig.camera.height, rig.camera.width), psf_sigma=1.0)[8:-8]
        centroid = image @ np.arange(rig.camera.width) / image.sum(axis=1)
        assert rows.visible.all()
        assert centroid == pytest.approx(rows.u[8:-8], abs=0.01)


def test_a_head_looks_outwards_at_its_clock():
    for clock in (0.0, 1.0, 4.0):
        outwards = head_pose(clock).apply(np.array([0.0, 2.0, 0.5]))
        assert outwards == pytest.approx([*xy_of(clock, 2.0), 0.5])


@pytest.mark.parametrize("kind", RIG_KINDS)
def test_random_rigs_of_every_kind_see_their_light_and_so_do_true_rigs(kind):
    for seed in range(10):
        rng = np.random.default_rng([7, seed])
        stated = random_rig(rng, R0, kind=kind)
        assert stated.configuration == kind
        assert set(stated.covariance.names) <= set(stated.parameter_names)
        assert (stated.covariance.u > 0).all()
        rig = draw_rig(stated, rng)
        assert rig.parameter_names == stated.parameter_names
        if isinstance(stated.lasers[0].surface, Beam):
            continue
        for laser in range(len(stated.lasers)):
            lit = lit_line(rig, PipeWall(R0), pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0, laser=laser)
            assert lit.visible.sum() > 10 or kind == "rotating-spot"
            assert isinstance(rig.mount, SideFacing) or lit.visible.all()


def test_what_cannot_be_simulated_is_refused():
    rng = np.random.default_rng(8)
    with pytest.raises(InputError, match="allowed: perpendicular-plane"):
        random_rig(rng, R0, kind="triple-cone")
    spots = random_rig(rng, R0, kind="spot-array")
    with pytest.raises(InputError, match="Beam draws no line"):
        lit_line(spots, PipeWall(R0), pipe_from_rig=Pose.identity(), line=LINE, psf_sigma=1.0)
    outside = Pose(np.eye(3), np.array([0, -0.7 * R0, 0]))
    with pytest.raises(InputError, match="stands outside the pipe"):
        lit_line(CONE, PipeWall(R0), pipe_from_rig=outside, line=LINE, psf_sigma=1.0)
    with pytest.raises(InputError, match="angular stops"):
        Survey("x", CONE, PipeWall(R0), (Station(0, angular=1),), 0.0, 0.1, Pose.identity())


def test_a_dual_cone_scan_lights_each_laser_in_its_takes(tmp_path):
    stated = random_rig(np.random.default_rng(9), R0, kind="dual-cone", width=240, height=180)
    alone = tuple(replace(laser, takes=(n + 1,)) for n, laser in enumerate(stated.lasers))
    both = tuple(replace(laser, takes=(0, n + 1)) for n, laser in enumerate(stated.lasers))
    survey = Survey(
        "dual",
        replace(stated, lasers=both),
        PipeWall(R0, (Dent(0.005, 1.0, 0.1, 0.2, 0.05),)),
        (Station(0, takes=3), Station(3, takes=4)),
        origin=-0.3,
        step=0.01,
        pose=Pose.from_roll_pitch_yaw(0.02, translation=(0.002, 0.001, 0.0)),
        stated=replace(stated, lasers=alone),
    )
    folder = simulate_scan(tmp_path / "scan", survey, seed=1)
    rig = read_rig(read_scan(folder).rig_path)
    assert [laser.takes for laser in rig.lasers] == [(1,), (2,)]
    images = [read_image(folder / f"pipe 003 {take}.png")[:, :, 0].astype(float) for take in range(4)]
    together, one, two, none = (image > 60 for image in images)
    assert not none.any()
    assert (together & ~one & ~two).sum() < 0.15 * together.sum()  # where both are faint, and other speckle
    assert (one & two).sum() < 0.5 * one.sum()
    with np.load(folder / "truth.npz") as truth:
        assert truth["ring_rig_R"].shape == truth["ring_rig_visible"].shape == (2, 2, 400)
        assert truth["true_diameter_mean"].shape == (2, 2)
        assert np.nanmax(np.abs(truth["ring_rig_R"] * 0.0254 - R0)) < 0.01


def test_a_side_facing_scan_turns_its_head(tmp_path):
    rig = random_rig(np.random.default_rng(10), R0, kind="side-facing", width=160, height=120)
    wall = PipeWall(R0, (Ovality((3.0, 3.0), axis=1.0),))
    stops = tuple(Station(number, angular=angular) for number in (0, 2) for angular in (0, 50, 130))
    turning = (0.2, np.radians(0.9))
    survey = Survey("side", rig, wall, stops, 0.1, 0.005, Pose.identity(), prefix="side", angular=turning)
    folder = simulate_scan(tmp_path / "scan", survey, seed=1)
    scan = read_scan(folder)
    assert (scan.angular.origin, scan.angular.step) == pytest.approx(turning)
    assert sorted(path.name for path in folder.glob("*.png"))[1] == "side 000 050 0.png"
    image = read_image(folder / "side 002 130 0.png")
    assert image.shape == (120, 160, 3)
    with np.load(folder / "truth.npz") as truth:
        assert truth["row_rig_R"].shape == truth["row_visible"].shape == (2, 3, 120)
        radius, clock = truth["row_rig_R"] * 0.0254, truth["row_rig_phi"]
        assert truth["head_deg"] == pytest.approx(np.degrees(0.2 + np.radians([0, 45, 117])))
        assert radius == pytest.approx(wall.radius(0.0, clock), abs=1e-9)
        turned = np.mod(clock - np.radians(truth["head_deg"])[:, None] + np.pi, 2 * np.pi) - np.pi
        assert np.abs(turned).max() < 0.02  # the sheet is a little skew
        peak = np.argmax(image[:, :, 0].astype(float), axis=1)
        assert np.median(np.abs(peak - truth["row_u"][1, 2])) < 1.5
