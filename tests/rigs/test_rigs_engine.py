"""The compiled engine says what its NumPy twin says, of every kind of rig."""

from copy import deepcopy
from dataclasses import fields, replace

import numpy as np
import pytest
from random_engine_rigs import KINDS, random_pixels, random_rig

from calibore.errors import InputError
from calibore.optics import Lens
from calibore.rigs import Rig, engine_form, measure, triangulate
from calibore.status import Status

RELATIVE = 1e-10
CLOSE_TO_THRESHOLD = 1e-4  # of all points: statuses that rounding may decide


def both(rig, laser, u, v, **options):
    options = {"laser": laser, **options}
    return measure(rig, u, v, kernel="native", **options), measure(rig, u, v, kernel="numpy", **options)


def assert_same(ours, theirs, *, differing=0):
    assert (ours.status != theirs.status).sum() <= differing
    same = ours.status == theirs.status
    for field in fields(ours):
        a, b = getattr(ours, field.name)[same], getattr(theirs, field.name)[same]
        assert np.allclose(a, b, rtol=RELATIVE, atol=1e-15, equal_nan=True), field.name


@pytest.mark.parametrize("kind", KINDS)
def test_engine_and_twin_agree_on_random_rigs_of_every_kind(kind):
    rng = np.random.default_rng(KINDS.index(kind))
    measured = 0
    for _ in range(25):
        rig, laser, size = random_rig(rng, kind)
        u, v = random_pixels(rng, 401)  # not a multiple of the lanes
        ours, theirs = both(rig, laser, u, v, u_pixel=0.4, prior_radius=size)
        assert_same(ours, theirs, differing=1)
        measured += int((ours.status == Status.OK).sum())
    assert measured > 300


@pytest.mark.parametrize("kind", KINDS)
def test_they_agree_on_noise_along_a_direction_on_numbered_branches_and_on_a_prior_for_each_point(kind):
    rng = np.random.default_rng(10 + KINDS.index(kind))
    rig, laser, size = random_rig(rng, kind)
    u, v = random_pixels(rng, 301)
    angle, noise = rng.uniform(0, 2 * np.pi, u.size), rng.uniform(0.1, 1, u.size)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    twice = kind in ("cone", "coaxial", "reversed", "dual")
    branch = rng.integers(0, 2 if twice else 1, u.size)
    assert_same(*both(rig, laser, u, v, u_pixel=noise, direction=along, branch=branch))
    assert_same(*both(rig, laser, u, v, u_pixel=noise, prior_radius=size * rng.uniform(0.5, 2, u.size)))


def test_missing_pixels_and_pixels_beyond_the_lens_keep_their_status():
    rig, laser, size = random_rig(np.random.default_rng(3), "plane")
    rig = replace(rig, camera=replace(rig.camera, lens=Lens("sine-law", 200.0, 240.0)))
    u, v = np.array([320.0, np.nan, 320.0, 900.0]), np.array([200.0, 200.0, np.nan, 240.0])
    ours, theirs = both(rig, laser, u, v, u_pixel=0.4, prior_radius=size)
    assert ours.status.tolist() == [Status.OK, Status.NO_PEAK, Status.NO_PEAK, Status.OUTSIDE_LENS]
    assert_same(ours, theirs)


def test_the_number_of_threads_changes_no_byte():
    rng = np.random.default_rng(4)
    rig, laser, size = random_rig(rng, "cone")
    u, v = random_pixels(rng, 30_011)
    one, three = (measure(rig, u, v, u_pixel=0.4, laser=laser, prior_radius=size, threads=n) for n in (1, 3))
    for field in fields(one):
        assert getattr(one, field.name).tobytes() == getattr(three, field.name).tobytes()


def test_a_point_measured_alone_is_the_same_as_among_others():
    rng = np.random.default_rng(5)
    rig, laser, size = random_rig(rng, "cone")
    u, v = random_pixels(rng, 19)
    together = measure(rig, u, v, u_pixel=0.4, laser=laser, prior_radius=size)
    for i in range(u.size):
        alone = measure(rig, u[i], v[i], u_pixel=0.4, laser=laser, prior_radius=size)
        assert alone.radius.tobytes() == together.radius[i : i + 1].tobytes()
        assert alone.u_axial_common.tobytes() == together.u_axial_common[i : i + 1].tobytes()


def test_no_points_give_no_points():
    rig, laser, size = random_rig(np.random.default_rng(6), "cone")
    assert measure(rig, [], [], u_pixel=0.4, laser=laser, prior_radius=size).radius.size == 0


def test_a_lens_that_the_engine_does_not_know_is_measured_all_the_same():
    rng = np.random.default_rng(7)
    rig, laser, size = random_rig(rng, "cone")
    polynomial = Lens("polynomial", 300.0, 240.0, polynomial=(-0.02,))
    rig = Rig("any", replace(rig.camera, lens=polynomial), rig.lasers)
    u, v = random_pixels(rng, 50)
    ours = measure(rig, u, v, u_pixel=0.4, laser=laser, prior_radius=size)
    assert np.array_equal(ours.radius, triangulate(rig, u, v, laser=laser, prior_radius=size).radius, equal_nan=True)


def test_an_unknown_rig_has_no_common_uncertainty():
    rng = np.random.default_rng(8)
    rig, laser, size = random_rig(rng, "plane")
    rig = rig.knowing(None)
    u, v = random_pixels(rng, 64)
    ours, theirs = both(rig, laser, u, v, u_pixel=0.4, prior_radius=size)
    assert_same(ours, theirs)
    assert (ours.u_radius_common[ours.status == Status.OK] == 0).all()


def test_a_cone_needs_to_be_told_which_meeting_counts():
    rig, laser, _ = random_rig(np.random.default_rng(9), "cone")
    for kernel in ("native", "numpy"):
        with pytest.raises(InputError, match="prior_radius"):
            measure(rig, [320.0], [100.0], u_pixel=0.4, laser=laser, kernel=kernel)


def test_numbers_that_do_not_fit_the_points_are_refused():
    rig, laser, size = random_rig(np.random.default_rng(9), "cone")
    with pytest.raises(InputError, match="one for each of 3"):
        measure(rig, [1.0, 2, 3], [1.0, 2, 3], u_pixel=[0.1, 0.2], laser=laser, prior_radius=size)
    with pytest.raises(InputError, match="shape"):
        measure(rig, [1.0], [1.0], u_pixel=0.1, direction=[[1.0, 0, 0]], laser=laser, prior_radius=size)


@pytest.mark.parametrize("kind", KINDS)
def test_a_rig_sent_to_another_process_is_known_there_too(kind):
    """A cluster's workers would otherwise compute with the twin, and differ in the last digit."""
    rig, laser, _ = random_rig(np.random.default_rng(4), kind)
    assert engine_form(deepcopy(rig), laser) is not None
