"""Walls are where their parts say."""

import numpy as np
import pytest

from calibore import metrics
from calibore.errors import InputError
from calibore.simulation import (
    Dent,
    Harmonic,
    LateralOpening,
    OffsetJoint,
    Ovality,
    PipeWall,
    Rail,
    Roughness,
    random_wall,
)

R0 = 0.15
CLOCKS = np.arange(720) * (2 * np.pi / 720)


def test_a_wall_without_parts_is_a_cylinder():
    assert np.all(PipeWall(R0).radius(np.linspace(-1, 1, 720), CLOCKS) == R0)


@pytest.mark.parametrize(
    ("part", "change"),
    [
        (Dent(0.01, 2.0, 0.3, 0.1, 0.02), -0.01),
        (Dent(-0.01, 2.0, 0.3, 0.1, 0.02), 0.01),
        (LateralOpening(0.03, 0.02, 2.0, 0.3), 0.02),
        (Rail(0.02, 0.02, clock=2.0), -0.02),
        (Rail(0.02, 0.02, clock=2.0, axial=(0.2, 0.4)), -0.02),
        (OffsetJoint(0.004, 2.0, 0.29), 0.004),
        (Harmonic(3, 0.002, 2.0), 0.002),
    ],
)
def test_a_feature_stands_at_its_clock_and_axial_position(part, change):
    wall = PipeWall(R0, (part,))
    assert float(wall.radius(0.3, 2.0)) == pytest.approx(R0 + change, abs=1e-12)
    assert float(wall.radius(0.3, 2.0 + 2 * np.pi)) == pytest.approx(R0 + change, abs=1e-12)


@pytest.mark.parametrize("part", [Dent(0.01, 2.0, 0.3, 0.1, 0.02), LateralOpening(0.03, 0.02, 2.0, 0.3)])
def test_a_local_feature_leaves_the_rest_of_the_wall_alone(part):
    wall = PipeWall(R0, (part,))
    assert float(wall.radius(0.3, 2.0 + np.pi)) == pytest.approx(R0, abs=1e-9)
    assert float(wall.radius(0.6, 2.0)) == pytest.approx(R0, abs=1e-9)


def test_ovality_is_the_harmonic_ovality_of_its_name_and_grows_as_stated():
    wall = PipeWall(R0, (Ovality((0.5, 2.5), axial=(0.0, 1.0), axis=0.7),))
    for axial, percent in ((-1.0, 0.5), (0.0, 0.5), (0.25, 1.0), (1.0, 2.5), (3.0, 2.5)):
        radii = wall.radius(axial, CLOCKS)
        assert metrics.ovality_harmonic(radii[:360] + radii[360:]) == pytest.approx(percent, abs=1e-9)
        assert wall.radius(axial, 0.7) == pytest.approx(R0 * (1 + percent / 100))


def test_the_top_of_a_rail_is_flat():
    clock = np.pi + np.linspace(-0.05, 0.05, 51)
    radius = PipeWall(R0, (Rail(0.02, 0.02),)).radius(0.0, clock)
    assert -radius * np.cos(clock) == pytest.approx(np.full(51, R0 - 0.02), abs=1e-12)


def test_roughness_has_its_rms_and_is_smooth_at_a_millimetre():
    rough = PipeWall(R0, (Roughness(4e-5, 0.003, seed=3),))
    axial, clock = np.meshgrid(np.arange(0, 0.3, 0.001), CLOCKS)
    texture = rough.radius(axial, clock) - R0
    assert texture.std() == pytest.approx(4e-5, rel=0.02)  # 24 000 lattice cells
    assert np.abs(texture.mean()) < 2e-6
    # A texture of 3 mm grain keeps most of its value over 1 mm: correlation of cubic splines at a third of a knot.
    assert np.corrcoef(texture[:, 1:].ravel(), texture[:, :-1].ravel())[0, 1] > 0.9


def test_the_same_seed_gives_the_same_roughness_and_another_seed_another():
    one, same, other = (PipeWall(R0, (Roughness(4e-5, seed=seed),)).radius(0.01, CLOCKS) for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.allclose(one, other, atol=1e-6)


def test_no_wall_reaches_into_its_clearance():
    rng = np.random.default_rng(11)
    for _ in range(30):
        wall = random_wall(rng)
        axial = rng.uniform(-1, 1, 20000) * wall.nominal_radius
        assert wall.radius(axial, rng.uniform(0, 2 * np.pi, axial.size)).min() >= wall.clearance > 0


def test_slopes_are_the_derivatives_of_the_radius():
    wall = PipeWall(R0, (Harmonic(4, 0.003, 0.2), Dent(0.01, 2.0, 0.0, 0.3, 0.05)))
    axial = np.full(CLOCKS.shape, 0.02)
    by_axial, by_clock = wall.slopes(axial, CLOCKS)
    away = np.mod(CLOCKS - 2.0 + np.pi, 2 * np.pi) - np.pi
    dent = 0.01 * np.exp(-0.5 * ((away / 0.3) ** 2 + 0.4**2))
    assert by_axial == pytest.approx(dent * 0.02 / 0.05**2, abs=1e-8)  # differences of radii rounded to 1e-17 m
    assert by_clock == pytest.approx(dent * away / 0.09 - 0.012 * np.sin(4 * (CLOCKS - 0.2)), abs=1e-8)


def test_a_wall_that_would_close_the_pipe_is_refused():
    with pytest.raises(InputError, match="beyond the axis"):
        PipeWall(R0, (Dent(0.2, 0.0, 0.0, 0.1, 0.1),))
    with pytest.raises(InputError, match="nominal radius must be positive"):
        PipeWall(-0.1)
    with pytest.raises(InputError, match="height of a rail must be positive"):
        Rail(0.0, 0.02)
