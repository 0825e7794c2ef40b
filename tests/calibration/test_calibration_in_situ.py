"""Calibration in the pipe: what has moved is found and named, what has not is left in peace at the stated rate."""

import numpy as np
import pytest
from calibration_in_situ_pipes import INCH, dented_wall, drawn, plane_rig, side_rig, sightings, target

from calibore.calibration._in_situ._change import change_of
from calibore.calibration._in_situ._fit import candidates, fit_in_situ
from calibore.calibration._in_situ._pose import aligned
from calibore.calibration._in_situ._words import in_situ_findings
from calibore.calibration._rig._fit import fit_rig
from calibore.errors import InputError
from calibore.rigs import moved, value_of
from calibore.uncertainty import Covariance

POSE = np.array([0.02, 0.0003, -0.0004, 0.001, 0.0, 0.0])
BASELINE = Covariance.independent({"laser.baseline": 0.003 * INCH})
HEAD = ("camera.k", "laser.baseline", "laser.aim")


def looks_of(rig, wall, folder, rng, *, seen_by=None, pose=POSE, **more):
    """Looks with the reference, taken for `rig`, of what the rig `seen_by` sees."""
    return aligned(target(rig, wall, folder), rig, sightings(seen_by or rig, wall, rng, pose=pose, **more))


def changed(rig, share):
    return moved(rig, {name: part * value_of(rig, name) for name, part in share.items()})


def test_a_rig_that_is_as_it_was_is_called_tenable_at_the_stated_rate(tmp_path):
    rng, wall, rig = np.random.default_rng(1), dented_wall(), plane_rig()
    p, error = [], []
    for _ in range(8):
        true = drawn(rig, BASELINE, rng)
        looks = looks_of(rig, wall, tmp_path, rng, seen_by=true, pose=POSE * rng.normal(0, 1, 6), marks=40).looks
        found = fit_rig(rig, looks, free=("laser.baseline",))
        change = change_of(found, ("laser.baseline",), old=BASELINE)
        p.append(change.p)
        error.append((change.after[0] - value_of(true, "laser.baseline")) / change.u_after[0])
    assert 3.9 < -2 * np.sum(np.log(p)) < 39.3  # Fisher: chi-square of 16 degrees of freedom, 99.8 %
    assert np.abs(error).max() < 3.5
    assert 0.4 < np.sqrt(np.mean(np.square(error))) < 1.7


def test_a_baseline_changed_by_half_a_per_cent_is_found_on_a_plane_rig(tmp_path):
    rng, wall, rig = np.random.default_rng(2), dented_wall(), plane_rig().knowing(BASELINE)
    true = changed(rig, {"laser.baseline": 0.005})
    alignment = looks_of(rig, wall, tmp_path, rng, seen_by=true)
    found = fit_in_situ(rig, alignment.looks)
    assert found.change.names == ("laser.baseline",)
    assert not found.change.tenable
    assert found.change.after[0] == pytest.approx(true.lasers[0].surface.baseline, abs=3 * found.change.u_after[0])
    said = list(in_situ_findings(found, alignment, target(rig, wall, tmp_path).unit))
    assert said[0].startswith("The old calibration is no longer tenable")
    assert "Baseline: in use 6.85" in said[1]
    assert "(+0.50 %)" in said[1] or "(+0.49 %)" in said[1] or "(+0.51 %)" in said[1]


@pytest.mark.parametrize(
    ("name", "share", "word"), [("camera.k", 0.0258, "k by +2.5"), ("laser.baseline", 0.005, "baseline by +0.")]
)
def test_the_parameter_that_moved_is_named_on_a_side_facing_head(tmp_path, name, share, word):
    rng, wall = np.random.default_rng(3), dented_wall()
    rig = side_rig().knowing(Covariance.independent(dict(zip(HEAD, (2.0, 0.001 * INCH, 2e-4), strict=True))))
    true = changed(rig, {name: share})
    alignment = looks_of(rig, wall, tmp_path, rng, seen_by=true)
    found = fit_in_situ(rig, alignment.looks)
    assert not found.change.tenable
    single = next(model for model in found.models if len(model.estimates) == 1)
    assert list(single.estimates) == [name]
    estimate = single.estimates[name]
    assert estimate.value == pytest.approx(value_of(true, name), abs=3.5 * estimate.u)
    assert name in found.change.names
    for key, after, u in zip(found.change.names, found.change.after, found.change.u_after, strict=True):
        assert abs(after - value_of(true, key)) < 3.5 * u
    assert any(
        "One change alone" in said and word in said
        for said in in_situ_findings(found, alignment, target(rig, wall, tmp_path).unit)
    )


def test_what_was_taken_as_exact_is_called_so_and_models_by_their_words(tmp_path):
    rng, wall, rig = np.random.default_rng(9), dented_wall(), side_rig().knowing(BASELINE)
    alignment = looks_of(rig, wall, tmp_path, rng)
    found = fit_in_situ(rig, alignment.looks, free=("camera.k", "laser.baseline"))
    said = list(in_situ_findings(found, alignment, target(rig, wall, tmp_path).unit))
    assert any(one.startswith("k: in use 3274") and "px (taken as exact), found" in one for one in said)
    assert any(one.startswith("Baseline: in use 2.35") and "(u = 0.0030 in), found" in one for one in said)
    assert {"nothing moved", "k moved", "baseline moved", "k and baseline moved"} <= {one.model for one in found.models}


def test_the_calibration_in_use_may_count_beside_the_reference(tmp_path):
    rng, wall = np.random.default_rng(4), dented_wall()
    old = Covariance.independent({"laser.baseline": 2e-4 * INCH})
    rig = plane_rig().knowing(old)
    found = fit_in_situ(rig, looks_of(rig, wall, tmp_path, rng).looks, prior=True)
    u_alone, u_both = found.change.u_after[0], found.result.covariance.u[0]
    assert u_both == pytest.approx((old.u[0] ** -2 + u_alone**-2) ** -0.5, rel=0.05)
    assert found.result is found.combined


def test_what_the_old_calibration_says_of_other_parameters_counts_in_the_difference(tmp_path):
    """The baseline was calibrated together with k: the pipe tells their ratio, and so did the old calibration."""
    rng, wall, rig = np.random.default_rng(5), dented_wall(), plane_rig()
    u = np.array([0.02 * INCH, 446.3 * 0.02 / 6.85])
    old = Covariance(("laser.baseline", "camera.k"), np.outer(u, u) * [[1, 0.999], [0.999, 1]])
    true = changed(rig, dict.fromkeys(old.names, 0.01))  # along the correlation, and far less against it
    looks = looks_of(rig, wall, tmp_path, rng, seen_by=true).looks
    found = fit_rig(rig, looks, free=old.names, prior=old.restricted(["camera.k"]))
    change = change_of(found, ("laser.baseline",), old=old)
    apart = change_of(found, ("laser.baseline",), old=Covariance.independent(dict(zip(old.names, old.u, strict=True))))
    assert change.u[0] < 0.8 * apart.u[0]


def test_the_error_of_the_reference_itself_goes_into_the_result(tmp_path):
    rig, u = plane_rig(), 0.002 * INCH
    sharp, vague = (
        fit_rig(
            rig, looks_of(rig, dented_wall(u=size), tmp_path, np.random.default_rng(6)).looks, free=("laser.baseline",)
        )
        for size in (0.0, u)
    )
    added = np.sqrt(vague.covariance.u[0] ** 2 - sharp.covariance.u[0] ** 2)
    assert added == pytest.approx(u * rig.lasers[0].surface.baseline / (6.0 * INCH), rel=0.05)


def test_features_that_only_one_of_both_shows_do_not_count(tmp_path):
    rng, wall, rig = np.random.default_rng(7), dented_wall(), plane_rig()
    marks = sightings(rig, wall, rng, pose=POSE)
    for one in marks:
        one.u[10:14] += 6 * one.direction[10:14, 0]
        one.v[10:14] += 6 * one.direction[10:14, 1]
    alignment = aligned(target(rig, wall, tmp_path), rig, marks)
    found = fit_rig(rig, alignment.looks, free=("laser.baseline",))
    assert abs(found.change("laser.baseline")[0]) < 3.5 * found.change("laser.baseline")[1]
    assert found.fit.noise * 0.5 < 0.4  # px; 0.3 were drawn


def test_what_may_have_moved_depends_on_the_rig():
    assert candidates(plane_rig()) == ("laser.baseline",)
    assert candidates(side_rig()) == HEAD


def test_a_round_pipe_does_not_tell_zoom_baseline_and_aim_apart(tmp_path):
    rng, rig = np.random.default_rng(8), side_rig()
    wall = dented_wall()
    wall = type(wall)(wall.axial, wall.clock, np.full_like(wall.radius, 6 * INCH))
    found = fit_in_situ(rig, looks_of(rig, wall, tmp_path, rng, pose=np.zeros(6)).looks)
    assert found.change.names == ("camera.k",)
    assert found.untold == ("laser.baseline", "laser.aim")
    with pytest.raises(InputError, match=r"free names camera\.zoom"):
        fit_in_situ(rig, (), free=("camera.zoom",))
