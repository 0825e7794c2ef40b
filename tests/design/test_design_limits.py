"""What a rig sees, against its closed forms and against looking everywhere."""

import numpy as np
import pytest
from random_designs import CONFIGURATIONS, random_study

from calibore.design import (
    Region,
    Study,
    cone_rig,
    image_map,
    measuring_limits,
    plane_rig,
    predict_ring,
    ring_clocks,
    side_rig,
)
from calibore.rigs import meetings_of


@pytest.mark.parametrize("baseline", [0.3, 0.5, 0.7])
def test_a_cone_measures_at_the_crown_from_half_way_between_laser_and_wall(baseline):
    """Swanbom 2007, eq. 3-37 (the second): the crossing of the light with the ray to the far edge of the ring."""
    limits = measuring_limits(cone_rig(baseline, 2.0, across="short"), nominal_radius=1.0)
    assert limits.least[0] == pytest.approx((1 + baseline) / 2, rel=1e-6)
    assert limits.zenith[1] == pytest.approx(np.arctan((1 + baseline) / 2.0), rel=1e-9)


def test_a_plane_measures_up_to_the_radius_its_camera_was_made_for():
    limits = measuring_limits(plane_rig(2.0, maximum_radius=1.7), nominal_radius=1.0)
    assert limits.most[0] == pytest.approx(1.7, rel=1e-6)
    assert limits.everywhere == pytest.approx((0.0, 1.7), rel=1e-6)
    assert limits.fraction == 1


def test_a_side_facing_head_measures_between_its_limits():
    limits = measuring_limits(side_rig(0.4), nominal_radius=1.0)
    assert limits.everywhere == pytest.approx((0.7, 2.0), rel=1e-6)


@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_within_the_limits_everything_is_measured_and_just_beyond_nothing(configuration):
    rng = np.random.default_rng([6, CONFIGURATIONS.index(configuration)])
    study = random_study(rng, configuration)
    rig, radius = study.rig(), study.nominal_radius
    limits = measuring_limits(rig, nominal_radius=radius, clocks=12)
    clock = ring_clocks(rig, 12)
    known = np.isfinite(limits.least)
    assert known.any()
    least, most = (np.where(known, a, radius) for a in (limits.least, np.minimum(limits.most, 20 * radius)))
    for share in np.linspace(0.01, 0.99, 25):
        inside = predict_ring(rig, clock, np.maximum(least, 0.021 * radius) * (1 - share) + most * share)
        assert inside.first_order[known].all()
    below, above = known & (limits.least > 0), known & np.isfinite(limits.most)
    beyond = predict_ring(rig, clock, np.where(below, 0.9999 * least, radius)).first_order
    assert not beyond[below].any()
    beyond = predict_ring(rig, clock, np.where(above, 1.0001 * most, radius)).first_order
    assert not beyond[above].any()


def test_every_pixel_of_a_map_is_what_its_region_says():
    rig = cone_rig(0.5, 1.0)
    found = image_map(rig, nominal_radius=1.0, columns=120, rows=90)
    grid = np.meshgrid(found.u, found.v)
    candidates = meetings_of(rig, grid[0].ravel(), grid[1].ravel())
    lit = (candidates.radius > 0).sum(axis=0).reshape(found.region.shape)
    assert (lit[found.region == Region.NO_MEETING] == 0).all()
    assert (lit[found.region == Region.AMBIGUOUS] == 2).all()
    assert (lit[found.region == Region.MEASURED] >= 1).all()
    values = found.valued(found.prediction.radius)
    np.testing.assert_array_equal(np.isfinite(values), found.region <= Region.MONTE_CARLO)
    assert (found.prediction.margin[found.region == Region.MONTE_CARLO] < 4).all()
    assert sum(found.fraction(region) for region in Region) == pytest.approx(1)
    assert {Region.AMBIGUOUS, Region.MONTE_CARLO, Region.NO_MEETING, Region.MEASURED} <= set(np.unique(found.region))


def test_what_lies_beyond_the_lens_is_marked_not_failed():
    study = Study("perpendicular-plane", 1.0, baseline=2.0, maximum_radius=6.0, lens="sine-law")
    found = image_map(study.rig(), nominal_radius=1.0, columns=80, rows=60)
    assert found.fraction(Region.OUTSIDE_LENS) > 0
    assert np.isnan(found.valued(found.prediction.radius)[found.region == Region.OUTSIDE_LENS]).all()
