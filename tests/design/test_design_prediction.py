"""What is told of a rig before it is built is what it then does."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from random_designs import CONFIGURATIONS, random_clocks, random_study

from calibore.design import (
    AS_PUBLISHED,
    HONEST,
    STRIPE,
    Assumptions,
    Study,
    combine_lasers,
    cone_rig,
    image_map,
    plane_rig,
    predict,
    predict_on_wall,
    predict_ring,
    reversed_rig,
    side_rig,
)
from calibore.errors import InputError
from calibore.rigs import SideFacing, moved, triangulate

SHARED = Path(__file__).parents[2].parent / "shared"
SURE = 40.0
"""Margin from which the second-order term, 1 / (4 m), is below a per cent."""


def _places(rng, study, rig, n, inputs):
    """`n` places of the nominal wall that the rig measures well; fewer where there are none."""
    reach = 0.1 * study.nominal_radius if isinstance(rig.mount, SideFacing) and rig.camera.height > 1 else 0.0
    found = predict_on_wall(
        rig,
        random_clocks(rng, 6 * n),
        study.nominal_radius,
        axial=rng.uniform(-reach, reach, 6 * n),
        u_pixel=inputs.u_pixel,
    )
    good = np.flatnonzero(found.measurable & (found.margin > SURE))[:n]
    return found, good


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_what_is_measured_scatters_as_predicted(configuration):
    """250 random rigs, each with parameters drawn from its covariance, measure 8 places each with noise: the scatter in
    units of the prediction is 1 within 5 % (its own standard error is 2 %).
    """
    rng = np.random.default_rng([3, CONFIGURATIONS.index(configuration)])
    squares = {"radius": [], "axial": []}
    while len(squares["radius"]) < 250:
        inputs = replace(HONEST, length=float(rng.choice([1e-4, 5e-4])), u_pixel=float(rng.uniform(0.05, 0.5)))
        study = random_study(rng, configuration, inputs=inputs)
        rig = study.rig()
        found, good = _places(rng, study, rig, 8, inputs)
        if not good.size:
            continue
        at = found.u[good], found.v[good]
        along = np.stack([np.ones(good.size), np.zeros(good.size)], axis=1)
        if not isinstance(rig.mount, SideFacing):
            offset = np.stack(at, axis=1) - rig.camera.principal_point
            along = offset / np.linalg.norm(offset, axis=1, keepdims=True)
        noise = rng.normal(0, inputs.u_pixel, (good.size, 1)) * along
        drawn = rig.covariance.draw(rng, 1)[0]
        real = moved(rig, dict(zip(rig.covariance.names, drawn.tolist(), strict=True)))
        seen = triangulate(real, at[0] + noise[:, 0], at[1] + noise[:, 1], prior_radius=study.nominal_radius)
        for name, values in (("radius", seen.radius), ("axial", seen.axial)):
            u = getattr(found, f"u_{name}")[good]
            error = values - getattr(found, name)[good]
            moves = u > 1e-12 * study.nominal_radius
            squares[name].append(np.mean((error[moves] / u[moves]) ** 2) if moves.any() else np.nan)
    for name, values in squares.items():
        if np.isfinite(values).any():
            assert np.sqrt(np.nanmean(values)) == pytest.approx(1, abs=0.05), name


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_place_of_the_wall_is_found_again_whichever_meeting_it_is(configuration):
    rng = np.random.default_rng([4, CONFIGURATIONS.index(configuration)])
    for _ in range(20):
        study = random_study(rng, configuration)
        radius = study.nominal_radius * rng.uniform(0.6, 1.8, 50)
        found = predict_on_wall(study.rig(), random_clocks(rng, 50), radius)
        there = found.status == 0
        assert there.any()
        np.testing.assert_allclose(found.radius[there], radius[there], rtol=1e-6)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_shares_sum_to_one_and_parts_to_the_whole(configuration):
    rng = np.random.default_rng([5, CONFIGURATIONS.index(configuration)])
    study = random_study(rng, configuration)
    found = predict_on_wall(study.rig(), random_clocks(rng, 100), study.nominal_radius)
    here = np.isfinite(found.u_radius)
    np.testing.assert_allclose(sum(found.shares.values())[here], 1, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(found.u_radius_independent, found.u_radius_common)[here], found.u_radius[here])
    common = np.sqrt(np.square(found.of_radius.modes).sum(axis=0))
    np.testing.assert_allclose(common[here], found.u_radius_common[here], rtol=1e-9, atol=1e-15)
    assert STRIPE in found.shares


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_a_pipe_twice_as_wide_is_measured_twice_as_roughly(configuration):
    small, large = (Study(configuration, radius).rig() for radius in (0.1, 0.2))
    clock = np.linspace(0.1, 6, 40)
    first, second = predict_on_wall(small, clock, 0.1), predict_on_wall(large, clock, 0.2)
    np.testing.assert_allclose(2 * first.u_radius, second.u_radius, rtol=1e-8)
    np.testing.assert_allclose(first.margin, second.margin, rtol=1e-8)


def test_the_published_predictions_come_out_as_published():
    path = SHARED / "reference" / "published_values.json"
    if not path.exists():
        pytest.skip(f"the published values are not there: {path}")
    known = {value["id"]: value["computed"] for value in json.loads(path.read_text(encoding="utf-8"))["values"]}
    as_then = {"direction": None}

    def ours(rig, clock, radius=1.0):
        return float(predict_on_wall(rig, clock, radius, **as_then).u_radius)

    lower_side = 3 * np.pi / 4
    for name, found in {
        "plane_U_D2": ours(plane_rig(2, inputs=AS_PUBLISHED), 0.3),
        "plane_U_in_D0.5": 6 * ours(plane_rig(0.5, inputs=AS_PUBLISHED), 0.3),
        "cone2_U_D0.5": ours(cone_rig(0.5, 2, inputs=AS_PUBLISHED), lower_side),
        "cone2_U_R2": ours(cone_rig(0.5, 2, inputs=AS_PUBLISHED), lower_side, 2.0),
        "side_U_D0.3": ours(side_rig(0.3, inputs=AS_PUBLISHED), 0.7),
        "side_U_in_D0.4": 6 * ours(side_rig(0.4, inputs=AS_PUBLISHED), 0.7),
    }.items():
        assert found == pytest.approx(known[name], rel=1e-9), name
    corner = predict(side_rig(0.25, inputs=AS_PUBLISHED), 0, 0, **as_then)
    assert float(corner.u_axial) == pytest.approx(known["side_UH_lo_D0.25"], rel=1e-9)


def test_the_published_composite_is_worst_half_way_between_the_lasers():
    rig = cone_rig(0.5, 1, second_clock=-np.pi / 2, inputs=AS_PUBLISHED)
    clock = np.linspace(0, 2 * np.pi, 721)
    each = [predict_on_wall(rig, clock, 1.0, direction=None, laser=laser) for laser in (0, 1)]
    best = combine_lasers(each, rule="best", cropped=False)
    assert np.degrees(clock[np.argmax(best.u_radius)]) == pytest.approx(135, abs=0.5)
    assert best.u_radius.max() == pytest.approx(0.016679501632147785, rel=1e-9)


def test_ignoring_that_angles_move_with_their_lengths_makes_a_side_facing_head_look_worse_than_it_is():
    apart, together = (side_rig(0.4, inputs=replace(HONEST, correlated=correlated)) for correlated in (False, True))
    assert predict_on_wall(apart, 0, 1.0).u_radius_common > 2 * predict_on_wall(together, 0, 1.0).u_radius_common


def test_minimum_variance_is_the_least_of_all_mixtures_of_two_lasers():
    rig = cone_rig(0.5, 2, second_clock=-np.pi / 2, inputs=Assumptions(0.003))
    each = [predict_on_wall(rig, np.linspace(0, 6.2, 90), 1.0, laser=laser) for laser in (0, 1)]
    both = combine_lasers(each)
    usable = each[0].measurable & each[1].measurable
    independent = np.stack([one.of_radius.independent for one in each])[:, usable]
    modes = np.stack([one.of_radius.modes for one in each])[:, :, usable]
    for weight in np.linspace(0, 1, 41):
        mixed = np.array([weight, 1 - weight])
        shared = np.square(np.einsum("l,lmn->mn", mixed, modes)).sum(axis=0)
        variance = np.square(mixed[:, None] * independent).sum(axis=0) + shared
        assert (both.u_radius[usable] ** 2 <= variance * (1 + 1e-9)).all()
    assert (both.u_radius <= combine_lasers(each, rule="best").u_radius * (1 + 1e-9)).all()
    np.testing.assert_allclose(both.weights.sum(axis=0), 1, rtol=1e-9)


def test_what_two_lasers_share_is_not_averaged_away():
    found = predict_on_wall(cone_rig(0.5, 2, inputs=HONEST), 1.0, 1.0)
    twice = combine_lasers([found, found])
    assert float(twice.u_common) == pytest.approx(float(found.u_radius_common), rel=1e-6)
    assert float(twice.u_independent) == pytest.approx(float(found.u_radius_independent) / np.sqrt(2), rel=1e-6)


def test_a_map_with_its_budget_takes_less_than_a_second():
    import time

    rig = cone_rig(0.5, 1)
    seconds = []
    for _ in range(3):
        before = time.process_time()
        found = image_map(rig, nominal_radius=1.0)
        seconds.append(time.process_time() - before)
    assert found.region.shape == (300, 400)
    assert set(found.prediction.shares) == {"laser.baseline", "laser.aim", "laser.half_angle", STRIPE}
    assert min(seconds) < 3.0  # 0.4 s measured; room for a busy machine


def test_a_ring_of_a_spot_array_has_one_place_per_beam():
    rig = Study("spot-array", 0.15, beams=6).rig()
    ring = predict_ring(rig, np.linspace(0, 5, 6), 0.15)
    np.testing.assert_allclose(ring.u_radius, ring.u_radius[0], rtol=1e-9)
    assert sorted(ring.laser.tolist()) == list(range(6))


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: cone_rig(1.2, 1), "below 1 nominal radii, got 1.2"),
        (lambda: cone_rig(0.5, -1), "projection must be above 0"),
        (lambda: plane_rig(-1), "baseline must be above 0"),
        (lambda: side_rig(0.5, maximum_radius=0.7), "above 0.75"),
        (lambda: reversed_rig(1, 1), "above 1"),
        (lambda: reversed_rig(1.5, 1, lens="perspective"), "does not image a zenith"),
        (lambda: Assumptions(-0.001), "must be 0 or more, got -0.001"),
        (lambda: predict(plane_rig(2), 10, 10, u_pixel=-1), "must be 0 or more, got -1"),
        (lambda: Study("triple-cone", 0.1), "is not known"),
        (lambda: Study("side-facing", 0.1, projection=2), "has no projection"),
        (lambda: Study("side-facing", -0.1), "must be positive"),
    ],
)
def test_what_cannot_be_built_is_refused_with_the_value_and_what_is_allowed(build, words):
    with pytest.raises(InputError, match=words):
        build()
