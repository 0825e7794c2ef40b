"""One station's arrays agree with one another, or are refused."""

import dataclasses

import numpy as np
import pytest
from tiny_survey import ring

from calibore.status import Status


def test_the_common_part_is_the_root_of_its_modes_and_missing_where_the_radius_is():
    profile, _ = ring(0, clocks=400, modes=5)
    measured = np.isfinite(profile.radius)
    expected = np.sqrt(np.einsum("mn,mn->n", profile.common_mode, profile.common_mode))
    np.testing.assert_allclose(profile.u_common[measured], expected[measured], rtol=1e-14)  # rounding of one sum
    assert np.array_equal(np.isnan(profile.u_common), ~measured)


def test_a_scan_without_common_modes_has_no_common_uncertainty():
    profile = dataclasses.replace(ring(0)[0], common_mode=np.empty((0, 8)))
    assert np.nansum(profile.u_common) == 0


@pytest.mark.parametrize("name", ["radius", "axial_position", "u_independent", "common_mode", "status"])
def test_arrays_of_another_shape_are_refused(name):
    profile, _ = ring(0)
    with pytest.raises(ValueError, match=f"{name} must have"):
        dataclasses.replace(profile, **{name: np.zeros(5)})


@pytest.mark.parametrize("name", ["y", "radius", "u_radius", "u", "take", "status"])
def test_points_of_another_number_are_refused(name):
    _, points = ring(0)
    with pytest.raises(ValueError, match=f"{name} must have the shape of x"):
        dataclasses.replace(points, **{name: np.zeros(5)})


@pytest.mark.parametrize("status", Status)
def test_a_radius_is_there_exactly_when_its_status_says_so(status):
    for item in ring(0):
        radius = np.where(np.arange(item.radius.size) == 3, 0.15 if not status.has_value else np.nan, item.radius)
        changed = item.status.copy()
        changed[3] = status
        with pytest.raises(ValueError, match=f"Point 3 has radius .* with status {status.name}"):
            dataclasses.replace(item, radius=radius, status=changed)


def test_an_unknown_status_is_refused():
    profile, _ = ring(0)
    with pytest.raises(ValueError, match="A status must be one of"):
        dataclasses.replace(profile, status=np.full(8, 77))
