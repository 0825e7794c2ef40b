"""Every derivative that a surface states is the slope of what it says it is."""

import numpy as np
import pytest
from rays_everywhere import KINDS, STEP, parameter_slopes, rays, relative, slopes, surfaces

ROUNDING = 1e-10  # relative; a complex step has no truncation error
NEXT_TO_GRAZING = 1e-8  # rounding over the square of the grazing sine


@pytest.fixture(params=[f"{kind} {number}" for kind in KINDS for number in range(10)])
def surface(request):
    kind, number = request.param.split()
    return surfaces(kind)[int(number)]


def test_gradients_are_the_slopes_of_the_value(surface):
    points, _ = rays(np.random.default_rng(2), 100)
    assert relative(surface.gradient(points), slopes(lambda shift: surface.value(points + shift))) < ROUNDING
    expected = parameter_slopes(surface, lambda moved: moved.value(points))
    assert relative(surface.parameter_gradient(points), expected) < ROUNDING


def test_frontiers_move_as_they_state(surface):
    origins, directions = rays(np.random.default_rng(3), 100)
    frontier = surface.frontier(origins, directions)
    turned = slopes(lambda shift: surface.frontier(origins, directions + shift).value)
    moved = slopes(lambda shift: surface.frontier(origins + shift, directions).value)
    changed = parameter_slopes(surface, lambda other: other.frontier(origins, directions).value)
    assert relative(frontier.by_direction, turned) < ROUNDING
    assert relative(frontier.by_origin, moved) < ROUNDING
    assert relative(frontier.by_parameters, changed) < ROUNDING


def test_a_meeting_moves_as_the_implicit_derivative_says(surface):
    origins, directions = rays(np.random.default_rng(4), 300)
    meetings = surface.meet(origins, directions)
    turned = slopes(lambda shift: surface.meet(origins, directions + shift).distance + 0j)
    changed = parameter_slopes(surface, lambda other: other.meet(origins, directions).distance + 0j)
    for distance, by_direction, by_parameters, good in zip(
        meetings.distance, turned, changed, meetings.admissible, strict=True
    ):
        points = (origins + distance[:, None] * directions)[good]
        closing = np.einsum("ni,ni->n", surface.gradient(points), directions[good])[:, None]
        expected = -distance[good, None] * surface.gradient(points) / closing
        assert relative(by_direction[good], expected) < NEXT_TO_GRAZING
        assert relative(by_parameters[good], -surface.parameter_gradient(points) / closing) < NEXT_TO_GRAZING


def test_flags_do_not_depend_on_an_imaginary_step(surface):
    origins, directions = rays(np.random.default_rng(5), 300)
    flags = surface.meet(origins, directions).flags
    assert np.array_equal(surface.meet(origins, directions + 1j * STEP).flags, flags)
    assert np.array_equal(surface.meet(origins + 1j * STEP, directions).flags, flags)


def test_one_origin_for_all_rays_is_the_same_as_one_each(surface):
    _, directions = rays(np.random.default_rng(6), 50)
    one, many = (np.zeros(3), directions), (np.zeros_like(directions), directions)
    meetings = surface.meet(*one)
    assert np.array_equal(meetings.flags, surface.meet(*many).flags)
    assert meetings.distance.dtype == np.float64
    frontier = surface.frontier(*one)
    assert np.array_equal(frontier.value, surface.frontier(*many).value)
    assert frontier.by_origin.shape == frontier.by_direction.shape == (*frontier.value.shape, 3)
    assert frontier.by_parameters.shape == (*frontier.value.shape, len(surface.parameter_names))
    assert frontier.second_order.shape == (len(frontier.value), len(meetings.distance))
