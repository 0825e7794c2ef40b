"""What a plan promises is what a calibration with the new pictures keeps; and no guess does better."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from made_calibrations import INCH, RADIUS, cone_rig, drawn, known, plane_rig, published_head, rig_calibration

from calibore.calibration import (
    PlannedBoard,
    PlannedFlats,
    PlannedGauges,
    PlannedRings,
    Shot,
    plan,
    read_planned_target,
    wall_uncertainty,
)
from calibore.calibration._on_the_wall import wall_pixels
from calibore.calibration._planning._plan import without_pose
from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.rigs import SideFacing, moved, triangulate
from calibore.uncertainty import Covariance

SIMULATED = 250
PROMISED = 0.10
STEPS = 5
RINGS = PlannedRings(INCH, 12, marks=24, u_ring=1e-4)
BOARD = PlannedBoard(9, 7, 0.02)
FLATS = PlannedFlats(tuple(np.arange(4.2, 12.0, 0.1) * INCH), marks=20)


def _wall_error(rig, truth):
    """Of the radius, at the pixels where the true rig sees the nominal wall: mean square [m^2]."""
    clock = np.zeros(1) if isinstance(rig.mount, SideFacing) else np.arange(24) * np.pi / 12
    u, v = wall_pixels(truth, clock, np.full(clock.size, RADIUS))
    return np.mean((triangulate(rig, u, v, prior_radius=RADIUS).radius - RADIUS) ** 2)


class _Recalibration:
    """The rig whose residuals (of rig and unknowns of the picture) and present knowledge agree best: Newton steps with
    the differences of the first picture, exact where they settle.
    """

    def __init__(self, rig):
        self.rig, self.root, self.slopes = rig, np.linalg.pinv(rig.covariance.factor()), None

    def __call__(self, residuals, extra):
        scale = np.concatenate([self.rig.covariance.u, extra])
        x = np.zeros(scale.size)
        if self.slopes is None:
            steps = 1e-3 * np.eye(x.size)
            slopes = [(self._all(step, scale, residuals) - self._all(-step, scale, residuals)) / 2e-3 for step in steps]
            self.slopes = np.linalg.pinv(np.transpose(slopes))
        for _ in range(STEPS):
            x = x - self.slopes @ self._all(x, scale, residuals)
        return self._moved(x * scale)

    def _all(self, x, scale, residuals):
        x = x * scale
        known = self.root @ x[: len(self.root.T)]
        return np.concatenate([known, residuals(self._moved(x), x[len(self.root.T) :])])

    def _moved(self, x):
        return moved(self.rig, dict(zip(self.rig.covariance.names, x.tolist(), strict=False)))


def _ring_picture(rig, truth, shot, rng):
    """Marks of a tilted target with a pose and printed radii of its own; residuals for a recalibration."""
    angle = np.tile(np.arange(RINGS.marks) * 2 * np.pi / RINGS.marks, RINGS.rings)
    ring = np.repeat(np.arange(RINGS.rings), RINGS.marks)
    tilt = Pose.from_roll_pitch_yaw(pitch=-shot.tilt, translation=(0.0, 0.0, shot.distance))  # its top leans away
    printed = rng.normal(scale=RINGS.u_ring, size=RINGS.rings)

    def pixels(one, pose, errors):
        radius = (RINGS.radii + errors)[ring]
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
        turn = Pose.from_roll_pitch_yaw(*pose[:3], translation=pose[3:])
        return np.stack(one.camera.project(tilt.apply(turn.apply(points))), axis=1)

    start = pixels(rig, np.zeros(6), 0.0)
    along = pixels(rig, np.array([1e-5, 0, 0, 0, 0, 0]), 0.0) - start
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    inside = (start > 5).all(axis=1) & (start < np.array([1018, 762])).all(axis=1)
    inside &= np.array([inside[ring == number].mean() > 0.5 for number in range(RINGS.rings)])[ring]
    measured = pixels(truth, rng.normal(scale=1e-3, size=6) * [0, 1, 1, 1, 1, 1], printed)
    noise = rng.normal(scale=RINGS.noise, size=angle.size)

    def residuals(one, x):
        pose = np.array([0.0, *x[:5]])
        off = measured - pixels(one, pose, x[5:])
        return np.append(((off * normal).sum(axis=1) + noise)[inside] / RINGS.noise, x[5:] / RINGS.u_ring)

    return residuals, np.concatenate([np.full(5, 1e-3), np.full(RINGS.rings, RINGS.u_ring)])


def _flat_picture(rig, truth, shot, rng):
    """The line on a flat whose place and inclinations are not quite what was read."""
    tilt, error = rng.normal(scale=FLATS.u_tilt), rng.normal(scale=FLATS.u)
    away = np.hypot(shot.distance, rig.mount.baseline)
    z = np.linspace(-1, 1, FLATS.marks) * away * np.tan(379 / rig.camera.lens.k)  # 5 px from the border
    y = shot.distance + error + tilt * z
    u, v = truth.project(np.stack([0 * z, y, z], axis=1))
    noisy = u + rng.normal(scale=FLATS.noise, size=u.size)
    slope = triangulate(rig, u, v).d_pixel[:, 1, 0]

    def residuals(one, x):
        points = triangulate(one, noisy, v).points
        gap = (points[:, 1] - shot.distance - x[0] - x[1] * points[:, 2]) / slope / FLATS.noise
        return np.append(np.where(np.isfinite(gap), gap, 1e3), [x[0] / FLATS.u, x[1] / FLATS.u_tilt])

    return residuals, np.array([FLATS.u, FLATS.u_tilt])


@pytest.mark.parametrize(
    ("rig", "target", "shot", "picture"),
    [
        (known(plane_rig()), RINGS, Shot(distance=0.2, tilt=np.radians(20)), _ring_picture),
        (published_head(), FLATS, Shot(distance=7.0 * INCH, straight=True), _flat_picture),
    ],
    ids=["rings", "flat"],
)
def test_a_calibration_with_the_new_picture_is_as_good_as_was_promised(rig, target, shot, picture):
    rng = np.random.default_rng(12)
    promised = plan(rig, target, nominal_radius=RADIUS, candidates=[shot], count=1)
    before, after, recalibrated = [], [], _Recalibration(rig)
    for truth in drawn(rig, rng, SIMULATED):
        before.append(_wall_error(rig, truth))
        after.append(_wall_error(recalibrated(*picture(rig, truth, shot, rng)), truth))
    assert np.sqrt(np.mean(before)) == pytest.approx(promised.before, rel=PROMISED)
    assert np.sqrt(np.mean(after)) == pytest.approx(promised.after, rel=PROMISED)
    assert promised.after < 0.8 * promised.before


@pytest.mark.parametrize("target", [BOARD, FLATS], ids=["board", "flats"])
def test_no_three_pictures_taken_by_guess_do_better(target):
    rig = published_head() if target is FLATS else known(plane_rig())
    found = plan(rig, target, nominal_radius=RADIUS)
    rng, guesses = np.random.default_rng(3), []
    shots = [step.shot for step in found.ranking]
    for _ in range(20):
        one = rig
        for index in rng.integers(len(shots), size=3):
            taken = plan(one, target, nominal_radius=RADIUS, candidates=[shots[index]], count=1)
            one = rig.knowing(taken.covariance)
        guesses.append(taken.after)
    assert found.after <= min(guesses) * (1 + 1e-9)
    assert found.after < 0.97 * np.median(guesses)


@pytest.mark.parametrize(
    ("rig", "target"),
    [
        (known(plane_rig()), RINGS),
        (known(plane_rig()), BOARD),
        (known(cone_rig()), PlannedGauges((10 * INCH, 12 * INCH, 14 * INCH))),
        (known(cone_rig(lasers=2)), PlannedFlats((0.3, 0.4, 0.5))),
        (published_head(), FLATS),
    ],
)
def test_every_picture_helps_and_the_best_comes_first(rig, target):
    found = plan(rig, target, nominal_radius=RADIUS)
    after = [found.before, *(step.u for step in found.steps)]
    assert all(later <= earlier * (1 + 1e-9) for earlier, later in pairwise(after))
    assert [step.u for step in found.ranking] == sorted(step.u for step in found.ranking)
    assert found.steps[0] == found.ranking[0]
    now = wall_uncertainty(rig, radii=[RADIUS])
    assert found.before == pytest.approx(now.mean[0])
    then = wall_uncertainty(rig.knowing(found.covariance), radii=[RADIUS]).mean[0]
    if len(rig.lasers) == 1:
        assert found.after == pytest.approx(then)
    assert then <= found.after * (1 + 1e-9)  # by then the other laser may know a clock better
    seen = np.isfinite(found.u_before)
    assert (found.u_after[seen] <= found.u_before[seen] * (1 + 1e-9)).all()
    assert all(step.shot.said("in") for step in found.ranking)


def test_a_target_in_the_light_tells_of_the_laser_and_elsewhere_only_of_the_camera():
    rig = rig_calibration(1).rig
    light = Covariance.independent({"laser.baseline": 1e-3, "laser.tilt_x": 0.01, "laser.tilt_y": 0.01})
    rig = rig.knowing(light.joined(rig.covariance.restricted([n for n in rig.covariance.names if "camera" in n])))
    beside, within = (
        plan(rig, RINGS, nominal_radius=RADIUS, candidates=[shot], count=1).covariance
        for shot in (Shot(distance=0.15), Shot(in_light=True))
    )
    np.testing.assert_allclose(beside.restricted(light.names).u, light.u, rtol=1e-6)
    assert (within.restricted(light.names).u < 0.85 * light.u).all()


def test_the_same_gauge_again_tells_less_than_another():
    """Its own error stays, however often it is photographed."""
    rig = known(cone_rig())
    rough = PlannedGauges((11 * INCH, 13 * INCH), u=5e-4)
    again, other = (
        plan(rig, rough, nominal_radius=RADIUS, candidates=[Shot(diameter=d * INCH)], count=4).after for d in (11, 13)
    )
    both = plan(rig, rough, nominal_radius=RADIUS, count=4)
    assert both.after < min(again, other)
    assert len({step.shot for step in both.steps}) == 2


def test_an_unknown_pose_takes_up_what_it_can():
    """Against the inverse of the whole information matrix."""
    rng = np.random.default_rng(5)
    rows, beside, u = rng.normal(size=(40, 5)), rng.normal(size=(40, 3)), np.array([np.inf, 0.3, 1e-3])
    left = without_pose(rows, beside, u)
    whole = np.block([[rows.T @ rows, rows.T @ beside], [beside.T @ rows, beside.T @ beside + np.diag(u**-2.0)]])
    np.testing.assert_allclose(np.linalg.inv(left.T @ left), np.linalg.inv(whole)[:5, :5], rtol=1e-6)


def test_targets_are_read_from_their_files(tmp_path):
    head = 'format = "calibore-target/1"\nimages = "a {take}.png"\n'
    for kind, rest, expected in (
        ("concentric-rings", 'ring_spacing = "1 in"\nrings = 12\nspokes = 8\n', PlannedRings(INCH, 12)),
        ("chessboard", 'corners = [9, 7]\nsquare = "20 mm"\n', BOARD),
        ("charuco", 'squares = [10, 8]\nsquare = "20 mm"\nmarker = "15 mm"\n', BOARD),
        ("asymmetric-circle-grid", 'corners = [4, 11]\nsquare = "20 mm"\n', PlannedBoard(4, 11, 0.02, staggered=True)),
        ("ring-gauge", '[[look]]\ngauge = "300 mm"\nu = "0.02 mm"\n', PlannedGauges((0.3,))),
        ("ring-gauge", '[[look]]\nflat = "300 mm"\nu = "0.02 mm"\n', PlannedFlats((0.3,), u=2e-5)),
    ):
        (tmp_path / "target.toml").write_text(f'{head}kind = "{kind}"\n{rest}', encoding="utf-8")
        assert read_planned_target(tmp_path) == expected
    (tmp_path / "target.toml").write_text(f'{head}kind = "range"\nrange_step = "0.1 in"\n', encoding="utf-8")
    assert read_planned_target(tmp_path).distances[41] == pytest.approx(4.2 * INCH)
    (tmp_path / "target.toml").write_text(f'{head}kind = "two-pin"\n', encoding="utf-8")
    with pytest.raises(InputError, match="two-pin"):
        read_planned_target(tmp_path)


def test_what_cannot_be_planned_is_refused():
    rig = known(plane_rig())
    for changed, target, shots, words in (
        (replace(rig, covariance=None), RINGS, None, "states no uncertainty"),
        (rig, PlannedBoard(9, 7, 0.5), [Shot(distance=0.2)], "none of the pictures"),
    ):
        with pytest.raises(InputError, match=words):
            plan(changed, target, nominal_radius=RADIUS, candidates=shots)
    with pytest.raises(InputError, match="nominal radius"):
        plan(published_head(), FLATS, nominal_radius=40 * INCH)
