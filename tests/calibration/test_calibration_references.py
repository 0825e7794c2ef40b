"""Known surfaces, and the light of a rig on them: every derivative is one, and what lies on a surface has no gap."""

import numpy as np
import pytest
from known_marks import flat_looks, gauge_look

from calibore.calibration._rig._model import RigModel, nearest_branches
from calibore.calibration._rig._references import AHEAD, OUTWARDS, FlatTarget, RingGauge
from calibore.errors import InputError
from calibore.rigs import moved, value_of, values_of
from calibore.simulation import random_rig

STEP = 1e-6


def references(rng):
    yield FlatTarget(rng.uniform(0.1, 0.4), OUTWARDS), rng.normal(size=2) * 0.02
    yield FlatTarget(rng.uniform(0.1, 0.4), AHEAD, u_tilt=(0.0, 0.01)), rng.normal(size=1) * 0.02
    yield RingGauge(rng.uniform(0.1, 0.4), at=rng.uniform(0.1, 0.3)), rng.normal(size=4) * 0.02
    yield RingGauge(rng.uniform(0.1, 0.4), u_tilt=0.0), rng.normal(size=2) * 0.02


def test_gaps_move_as_their_derivatives_say():
    rng = np.random.default_rng(1)
    for _ in range(20):
        for reference, nuisance in references(rng):
            points = rng.normal(size=(30, 3)) * 0.2
            gap = reference.gap(points, nuisance)
            for axis in range(3):
                step = STEP * np.eye(3)[axis]
                change = reference.gap(points + step, nuisance).value - reference.gap(points - step, nuisance).value
                np.testing.assert_allclose(change / (2 * STEP), gap.by_point[:, axis], atol=1e-6)
            for number in range(nuisance.size):
                step = STEP * np.eye(nuisance.size)[number]
                change = reference.gap(points, nuisance + step).value - reference.gap(points, nuisance - step).value
                np.testing.assert_allclose(change / (2 * STEP), gap.by_nuisance[:, number], atol=1e-6)


def test_points_of_an_inclined_gauge_have_no_gap_and_give_its_place_away():
    rng = np.random.default_rng(2)
    for _ in range(20):
        gauge, place = RingGauge(0.2, at=0.15), np.array([*rng.normal(size=2) * 0.01, *rng.normal(size=2) * 0.01])
        turn, along = rng.uniform(0, 2 * np.pi, 400), rng.normal(size=400) * 0.03
        axis = np.array([place[2], place[3], 1.0]) / np.hypot(1, np.hypot(*place[2:]))
        first = np.cross([0.0, 1.0, 0.0], axis)
        first /= np.linalg.norm(first)
        round_ = np.outer(np.cos(turn), first) + np.outer(np.sin(turn), np.cross(axis, first))
        points = np.array([place[0], place[1], 0.15]) + 0.1 * round_ + along[:, None] * axis
        np.testing.assert_allclose(gauge.gap(points, place).value, 0, atol=1e-15)
        np.testing.assert_allclose(gauge.first_guess(points)[:2], place[:2], atol=1e-3)


def test_a_gauge_seen_as_an_ellipse_is_first_taken_for_inclined():
    turn = np.arange(200) * (2 * np.pi / 200)
    tilt, way = 0.04, 0.7
    stretched = np.stack([np.cos(turn) / np.cos(tilt), np.sin(turn)], axis=1) * 0.1
    points = np.column_stack([stretched @ [[np.cos(way), np.sin(way)], [-np.sin(way), np.cos(way)]], np.full(200, 0.2)])
    guess = RingGauge(0.2, at=0.2, u_tilt=0.05).first_guess(points)
    assert np.hypot(*guess[2:]) == pytest.approx(tilt, rel=0.05)
    assert abs(guess[2] * np.sin(way) - guess[3] * np.cos(way)) < 0.05 * tilt


@pytest.mark.parametrize("kind", ["side-facing", "perpendicular-plane", "single-cone", "coaxial-cone"])
def test_residuals_of_marks_move_as_their_derivatives_say(kind):
    rng = np.random.default_rng(3)
    for _ in range(3):
        rig = random_rig(rng, 0.15, kind=kind)
        model = _model(rig, rng)
        values = model.start(rig) + 1e-6 * rng.normal(size=len(model.names))
        residual, jacobian, _ = model.residuals(values)
        seen = np.isfinite(residual) & (np.abs(residual) < 0.5)
        assert np.count_nonzero(seen) > 40
        for number, name in enumerate(model.names):
            step = (1e-3 if name == "camera.k" else 1e-8) * np.eye(len(model.names))[number]
            change = model.residuals(values + step)[0] - model.residuals(values - step)[0]
            slope = -change[seen] / (2 * step[number])
            scale = np.abs(jacobian[seen, number]).max()
            # one Newton step leaves the square of the noise, near a fold at most a hundredth
            np.testing.assert_allclose(slope, jacobian[seen, number], atol=1e-2 * scale, err_msg=name)


@pytest.mark.parametrize("kind", ["side-facing", "perpendicular-plane", "single-cone"])
def test_marks_without_noise_have_no_residual_at_the_truth(kind):
    rng = np.random.default_rng(4)
    rig = random_rig(rng, 0.15, kind=kind)
    model = _model(rig, rng, noise=1e-9)
    residual = model.residuals(model.start(rig))[0]
    assert np.nanmax(np.abs(residual)) < 1e-4


def test_values_of_a_rig_are_those_that_moving_it_changes():
    rng = np.random.default_rng(5)
    for kind in ("side-facing", "dual-cone", "perpendicular-plane"):
        rig = random_rig(rng, 0.15, kind=kind)
        before = values_of(rig, rig.parameter_names)
        for name in rig.parameter_names:
            assert value_of(moved(rig, {name: 1e-3}), name) == pytest.approx(before[name] + 1e-3, abs=1e-12)


def test_impossible_references_are_refused():
    with pytest.raises(InputError, match="positive distance, got -1"):
        FlatTarget(-1.0)
    with pytest.raises(InputError, match="diameter of a ring gauge must be positive"):
        RingGauge(0.0)
    with pytest.raises(InputError, match="must not be negative"):
        RingGauge(0.2, u=-1e-6)


def _model(rig, rng, *, noise=0.1):
    if rig.configuration == "side-facing":
        looks = flat_looks(rig, [0.13, 0.15, 0.18], rng, noise=noise, rows=24)
        free = ("laser.baseline", "laser.aim", "laser.lean", "camera.k")
    else:
        looks = [gauge_look(rig, 2 * r, rng, name=f"{r}", noise=noise, marks=60) for r in (0.14, 0.16)]
        names = rig.lasers[0].surface.parameter_names
        free = (*(f"laser.{name}" for name in names if value_of(rig, f"laser.{name}") != 0), "camera.k")
    model = RigModel(rig, tuple(looks), free)
    straight = model.start(rig)
    straight[len(free) :] = 0.0
    return RigModel(rig, tuple(looks), free, nearest_branches(model, straight))


def test_gauges_inclined_by_chance_have_no_gap_on_average_and_scatter_as_their_doubt_says():
    """Slopes that the pictures do not tell: seen as straight, gauges seem too small, whichever way they lean."""
    rng = np.random.default_rng(6)
    spread = np.array([[9e-5, 3e-5], [3e-5, 4e-5]])
    gauge = RingGauge(0.2, at=0.15).doubting(np.diag([1e-8, 1e-8, 0.0, 0.0]) + np.pad(spread, (2, 0)))
    turn = np.arange(8) * np.pi / 4
    straight = gauge.gap(np.stack([np.cos(turn), np.sin(turn), 1.5 * np.ones(8)], axis=1) * 0.1, np.zeros(7))
    gaps = []
    for slope in rng.multivariate_normal(np.zeros(2), spread, size=20000):
        lean = slope @ [np.cos(turn), np.sin(turn)]
        radius = 0.1 * np.sqrt((1 + slope @ slope) / (1 + slope @ slope - lean**2))
        gaps.append(radius - 0.1 + straight.value)
    size = np.abs(straight.value).max()
    np.testing.assert_allclose(np.mean(gaps, axis=0), 0, atol=0.05 * size)  # 5 times what the mean scatters by
    squares = straight.by_nuisance[:, 4:]
    np.testing.assert_allclose(np.cov(np.transpose(gaps)), squares @ squares.T, atol=0.1 * np.max(squares @ squares.T))
