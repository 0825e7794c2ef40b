"""Monte Carlo that stops by itself, when what it says no longer changes."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import Cone
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, adaptive_monte_carlo, measure, monte_carlo, project_ring
from calibore.uncertainty import tolerance_of


def rig_and_pixels():
    cone = Cone.for_ring(0.5, 2.0, 1.0)
    camera = Camera(1024, 768, Lens("equidistant", 560.0, 384.0), (511.5, 383.5))
    rig = Rig("single-cone", camera, (Laser(cone),)).with_default_uncertainty(1.0)
    clock, u, v = project_ring(rig, 1.0, 8)
    clear = np.abs(np.sin(clock)) < 0.8  # away from the sides, where draws are lost
    return rig, u[clear], v[clear]


def test_what_has_settled_is_within_its_tolerance_of_what_many_more_draws_say():
    rig, u, v = rig_and_pixels()
    found = adaptive_monte_carlo(rig, u, v, u_pixel=0.3, rng=np.random.default_rng(1), prior_radius=1.0)
    assert found.settled.all()
    assert 50_000 <= found.drawn.draws < 2_000_000
    exact = monte_carlo(rig, u, v, u_pixel=0.3, draws=1_000_000, rng=np.random.default_rng(2), prior_radius=1.0)
    for ours, theirs in ((found.drawn.radius, exact.radius), (found.drawn.axial, exact.axial)):
        allowed = tolerance_of(theirs.u, 2)
        for ends in (0, 1):
            assert (np.abs(ours.symmetric - theirs.symmetric)[:, ends] < 1.5 * allowed).mean() > 0.9
        assert (np.abs(ours.u - theirs.u) < allowed).mean() > 0.9
    assert np.allclose(found.drawn.covariance, exact.covariance, rtol=0.05)


def test_blocks_together_are_what_one_run_of_as_many_draws_would_be():
    rig, u, v = rig_and_pixels()
    options = {"u_pixel": 0.3, "prior_radius": 1.0}
    found = adaptive_monte_carlo(rig, u, v, rng=np.random.default_rng(3), most_draws=60_000, digits=4, **options)
    assert found.drawn.draws == 60_000
    assert not found.settled.any()
    first = measure(rig, u, v, **options)
    assert np.allclose(found.drawn.radius.u, first.u_radius, rtol=0.02)  # 60 000 draws, and m far above 4


def test_a_point_that_loses_its_draws_does_not_keep_the_others_from_telling():
    rig, u, v = rig_and_pixels()
    found = adaptive_monte_carlo(
        rig, [u[0], 2.0], [v[0], 380.0], u_pixel=0.3, rng=np.random.default_rng(4), most_draws=60_000, prior_radius=1.0
    )
    assert found.drawn.lost[1] == 1.0
    assert np.isfinite(found.drawn.radius.u[0])
    assert np.isnan(found.drawn.radius.u[1])
    assert not found.settled[1]


def test_no_digit_at_all_is_refused():
    rig, u, v = rig_and_pixels()
    with pytest.raises(InputError, match="at least one significant digit, got 0"):
        adaptive_monte_carlo(rig, u, v, u_pixel=0.3, rng=np.random.default_rng(5), digits=0, prior_radius=1.0)
