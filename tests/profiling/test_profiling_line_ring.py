"""A line on the wall and on the clock grid: the compiled engine and the NumPy code, its specification, say the same."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.errors import ImageError, UsageError
from calibore.lasers import Cone, Plane
from calibore.optics import Camera, Lens
from calibore.profiling._line_ring import line_on_wall
from calibore.rigs import Laser, Rig, ValidRegion, project_ring
from calibore.status import Status, has_value
from calibore.stripe import NoiseModel, Stripe
from calibore.uncertainty import Covariance

RADIUS, RAYS, NOISE = 0.15, 1500, 0.05
ROUNDING = 1e-11
"""Of the largest value of each kind: derivatives near the fold of a cone lose three digits of fifteen."""


def rigs(rng):
    """One rig of each forward-looking kind, its parameters and what is known of them drawn."""
    camera = Camera(640, 480, Lens("equidistant", 420.0, 240.0, c1=rng.normal(0, 0.01)), (320.5, 239.0), aspect=1.01)
    plane = Plane(RADIUS * rng.uniform(1, 2.5), *rng.normal(0, 0.02, 2))
    cone = Cone.for_ring(RADIUS * 0.5, RADIUS * rng.uniform(1, 2.2), RADIUS, clock=rng.uniform(0, 6.28))
    for configuration, surface in (("perpendicular-plane", plane), ("single-cone", cone)):
        rig = Rig(configuration, camera, (Laser(surface, "red"),))
        half = np.diag(rng.uniform(1e-5, 1e-3, len(rig.parameter_names))) @ rng.normal(
            0, 1, (len(rig.parameter_names),) * 2
        )
        yield rig.knowing(Covariance(rig.parameter_names, half @ half.T))


def line(rig, rng):
    """The line on an oval wall with an edge, rays missing, out of order and doubtful."""
    clock = np.arange(RAYS) * 2 * np.pi / RAYS
    wall = RADIUS * (
        1 + 0.02 * np.cos(2 * clock + rng.uniform(0, 6)) - 0.03 * (np.abs(clock - rng.uniform(1, 5)) < 0.2)
    )
    _, u, v = project_ring(rig, wall, RAYS)
    centre = (float(np.nanmean(u)), float(np.nanmean(v)))
    outwards = np.stack([u - centre[0], v - centre[1]], axis=1)
    direction = outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    off = rng.normal(0, NOISE, RAYS)
    status = rng.choice([0, 0, 0, 0, 1, 2, 3, 5], RAYS).astype(np.uint8)
    status[rng.integers(RAYS) + np.arange(90) - RAYS] = Status.NO_PEAK
    status[~np.isfinite(u)] = Status.NO_PEAK
    missing = np.where(has_value(status), 0.0, np.nan)
    u_position = NOISE * rng.uniform(0.5, 2, RAYS) + missing
    u, v = u + off * direction[:, 0] + missing, v + off * direction[:, 1] + missing
    direction = np.nan_to_num(direction)
    shared = np.array([0.6, 0.2, 0.05])
    return Stripe(u, v, direction, u_position, status, np.zeros(RAYS), shared, NoiseModel(), 1.0, centre)


def assert_alike(ours, theirs):
    for part in ("rays", "ring"):
        one, other = getattr(ours, part), getattr(theirs, part)
        for name in getattr(one, "_fields", None) or one.__dataclass_fields__:
            a, b = np.asarray(getattr(one, name), dtype=float), np.asarray(getattr(other, name), dtype=float)
            assert np.isfinite(b).any() or not b.size, name
            size = np.nanmax(np.abs(b)) if b.size else 0.0
            np.testing.assert_allclose(a, b, rtol=0, atol=ROUNDING * max(size, 1e-300), err_msg=f"{part}.{name}")


@pytest.mark.parametrize("seed", range(6))
def test_both_kernels_give_the_same_rays_and_the_same_ring(seed):
    rng = np.random.default_rng(seed)
    for rig in rigs(rng):
        found = line(rig, rng)
        for changed in (rig, replace(rig, stripe=0.7), replace(rig, valid=ValidRegion((0.3, 0.6), (0.14, 0.15)))):
            ours, theirs = (
                line_on_wall(found, changed, prior_radius=RADIUS, kernel=kernel) for kernel in ("native", "numpy")
            )
            assert_alike(ours, theirs)
        assert Status.EXTRAPOLATED in ours.rays.status


def test_a_rig_of_which_nothing_is_uncertain_has_no_modes():
    rng = np.random.default_rng(1)
    for rig in rigs(rng):
        known = rig.knowing(None)
        ours, theirs = (line_on_wall(line(rig, rng), known, prior_radius=RADIUS, kernel=k) for k in ("native", "numpy"))
        assert ours.ring.modes.shape == theirs.ring.modes.shape == (0, 400)


def test_a_line_that_meets_no_light_is_refused_by_both_kernels():
    rng = np.random.default_rng(2)
    rig = next(iter(rigs(rng)))
    nothing, dark = np.full(RAYS, np.nan), np.full(RAYS, Status.NO_PEAK, dtype=np.uint8)
    empty = replace(line(rig, rng), u=nothing, v=nothing, u_position=nothing, status=dark)
    for kernel in ("native", "numpy"):
        with pytest.raises(ImageError, match="no point of its line"):
            line_on_wall(empty, rig, prior_radius=RADIUS, kernel=kernel)


def test_an_unknown_kernel_is_refused():
    rng = np.random.default_rng(2)
    rig = next(iter(rigs(rng)))
    with pytest.raises(UsageError, match="cuda"):
        line_on_wall(line(rig, rng), rig, kernel="cuda")
