"""Built to the tolerances, the target is met, and no worse than that."""

from dataclasses import replace

import numpy as np
import pytest
from random_designs import CONFIGURATIONS, random_study

from calibore.design import (
    HONEST,
    STRIPE,
    Study,
    grouped,
    predict_ring,
    ring_clocks,
    ring_shares,
    tolerances,
    useful_clocks,
)
from calibore.errors import InputError
from calibore.uncertainty import Covariance

ONE_LASER = [name for name in CONFIGURATIONS if name not in ("dual-cone", "spot-array")]


def _worst(rig, study, inputs, known, u_pixel):
    """Largest u over the clocks that were useful with the first `inputs`, with other uncertainties."""
    clock = ring_clocks(rig, 120)
    first = predict_ring(rig, clock, study.nominal_radius, assumptions=inputs)
    good = useful_clocks(first.u_radius, first.first_order)
    assert good.any()
    built = predict_ring(
        rig.knowing(known), clock[good], study.nominal_radius, assumptions=replace(inputs, u_pixel=u_pixel)
    )
    return float(np.max(built.predictions[0].u_radius))


@pytest.mark.parametrize("configuration", ONE_LASER)
def test_a_rig_built_to_all_tolerances_meets_the_target_exactly(configuration):
    rng = np.random.default_rng([12, CONFIGURATIONS.index(configuration)])
    study = random_study(rng, configuration)
    rig, target = study.rig(), 0.002 * study.nominal_radius
    found = tolerances(rig, nominal_radius=study.nominal_radius, target=target)
    shared = {row.name: row.sharing for row in found.rows if row.sharing is not None}
    u_pixel = shared.pop(STRIPE)
    worst = _worst(rig, study, HONEST, Covariance.independent(shared), u_pixel)
    assert worst == pytest.approx(target, rel=1e-6)


@pytest.mark.parametrize("configuration", ONE_LASER)
def test_a_rig_with_one_inexact_parameter_meets_the_target_exactly(configuration):
    rng = np.random.default_rng([13, CONFIGURATIONS.index(configuration)])
    study = random_study(rng, configuration)
    rig, target = study.rig(), 0.002 * study.nominal_radius
    found = tolerances(rig, nominal_radius=study.nominal_radius, target=target)
    for row in found.rows:
        if row.alone is not None and row.name != STRIPE:
            worst = _worst(rig, study, HONEST, Covariance.independent({row.name: row.alone}), 0.0)
            assert worst == pytest.approx(target, rel=1e-6), row.name
            assert row.sharing < row.alone


def test_a_stricter_target_makes_every_tolerance_stricter_in_proportion():
    rig = Study("dual-cone", 0.15).rig()
    loose, strict = (tolerances(rig, nominal_radius=0.15, target=target) for target in (1e-3, 1e-4))
    for first, second in zip(loose.rows, strict.rows, strict=True):
        assert first.name == second.name
        assert first.sharing == pytest.approx(10 * second.sharing)


def test_parameters_that_do_nothing_are_left_free():
    found = tolerances(Study("coaxial-cone", 0.15).rig(), nominal_radius=0.15, target=1e-3)
    free = {row.name for row in found.rows if row.sharing is None}
    assert free == {"laser.clock"}


def test_a_target_must_be_positive():
    with pytest.raises(InputError, match="must be a positive uncertainty"):
        tolerances(Study("side-facing", 0.15).rig(), nominal_radius=0.15, target=0.0)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_the_shares_of_a_ring_sum_to_one_with_correlated_inputs_together(configuration):
    study = Study(configuration, 0.15)
    rig = study.rig()
    shares = grouped(ring_shares(predict_ring(rig, ring_clocks(rig), 0.15)), rig.covariance)
    assert sum(shares.values()) == pytest.approx(1)
    assert min(shares.values()) >= 0
    assert next(iter(shares.values())) == max(shares.values())
