"""Which meeting is the wall, how far it is from ceasing to be, and cones and heads against an independent renderer."""

from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import Cone, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import (
    Laser,
    Rig,
    SideFacing,
    follow_stripe,
    margin,
    meetings_of,
    project_ring,
    read_rig,
    triangulate,
)
from calibore.status import Status
from calibore.uncertainty import Covariance

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
INCH = 0.0254


def cone_rig(baseline, projection, *, columns=1024):
    """Swanbom 2007, section 3.3: nominal radius 1, equidistant, 2 (aim + half angle) across the long axis."""
    cone = Cone.for_ring(baseline, projection, 1.0)
    lens = Lens("equidistant", columns / (2 * (cone.aim + cone.half_angle)), 384.0)
    return Rig("single-cone", Camera(columns, 768, lens, (columns / 2, 384.0)), (Laser(cone),))


def seen(rig, radius, *, n=720):
    """Pixels of a wall of `radius` (n,) and which of its points the camera sees."""
    clock, u, v = project_ring(rig, radius, n)
    there = np.isfinite(u)
    return clock[there], u[there], v[there], np.broadcast_to(radius, n)[there]


@pytest.mark.parametrize(("baseline", "projection"), [(0.25, 1.0), (0.5, 1.0), (0.75, 1.0), (0.5, 2.0)])
def test_the_meeting_nearest_to_the_wall_is_the_wall_where_the_farther_one_is_not(baseline, projection):
    rig = cone_rig(baseline, projection)
    _, u, v, radius = seen(rig, 1.0)
    found = triangulate(rig, u, v, prior_radius=1.0)
    assert np.abs(found.radius - radius)[found.status == Status.OK].max() < 1e-9
    both = meetings_of(rig, u, v)
    ambiguous = (both.radius > 0).all(axis=0)
    farther = ambiguous & (np.abs(both.radius[0] - 1) < 1e-9) & (both.radius[1] > 1.01)
    assert farther.sum() > 0.02 * u.size  # there "discard the nearer" (Swanbom 2007, eq. 3-37) is wrong


def test_the_branch_of_a_dented_wall_follows_continuity_where_the_prior_alone_is_misled():
    rig = cone_rig(0.5, 1.0)
    clock = np.arange(720) * (2 * np.pi / 720)
    deep = 1 + 0.75 * np.exp(-(((clock - np.radians(100)) / np.radians(9)) ** 2))  # an opening near the tangent
    _, u, v, radius = seen(rig, deep)
    candidates = meetings_of(rig, u, v)
    followed = triangulate(rig, u, v, branch=follow_stripe(candidates, 1.0))
    nearest = triangulate(rig, u, v, prior_radius=1.0)

    def wrong(found):
        return np.sum(np.abs(found.radius - radius)[found.status == Status.OK] > 1e-6)

    assert wrong(followed) <= 2  # at the fold itself, where both meetings are one
    assert wrong(nearest) > wrong(followed)


def test_a_ray_that_can_meet_twice_needs_to_be_told_which_counts():
    with pytest.raises(InputError, match="pass prior_radius"):
        triangulate(cone_rig(0.5, 1.0), [512.0], [300.0])


def test_a_ray_beside_the_cone_grazes_it():
    rig = cone_rig(0.5, 1.0)
    assert triangulate(rig, [1020.0], [384.0], prior_radius=1.0).status.tolist() == [Status.GRAZING]


@pytest.mark.parametrize(("degrees", "published"), [(15, 7.75), (8, 2.22), (4, 0.558), (2, 0.140)])
def test_the_margin_near_the_frontier_is_that_of_the_equation_book(degrees, published):
    """equations.md, 5.5: D = 0.5, L = 1, u(D) = u(L) = 0.001, 1 px, correlated; distance from the tangent azimuth."""
    rig = cone_rig(0.5, 1.0)
    known = rig.with_default_uncertainty(1.0).covariance
    rig = rig.knowing(Covariance(known.names, 3 * known.matrix))  # 0.001 as a standard uncertainty, not as limits
    tangent = np.radians(-1.827503008673351)
    clock = np.pi / 2 - (tangent + np.radians(degrees))
    cone = rig.lasers[0].surface
    feet = np.array([[np.sin(clock), -np.cos(clock), 0.0]])
    depth = cone.meet(feet, np.array([[0.0, 0, 1]])).distance[0]
    u, v = rig.project(feet + depth[:, None] * [0, 0, 1])
    found = triangulate(rig, u, v, prior_radius=1.0)
    ours = margin(rig, u, v, branch=found.branch, u_pixel=1.0)
    assert ours[0] == pytest.approx(published, rel=0.005)  # theirs from 200 000 draws


@pytest.mark.parametrize("degrees", [60, 30, 11, 8, -4, -8, -14, -20, -40, -60])
def test_the_margin_tells_the_second_order_term_of_the_radius(degrees):
    """1 / (4 margin) against 1/2 tr(H V) / u from second differences; near the fold the distance to it is less."""
    inputs = np.array([0.5, 1.0])

    def radius(change):
        """Of the ray of the wall point, and of the rig, both moved by (baseline, projection, u, v)."""
        cone = Cone.for_ring(*(inputs + change[:2]), 1.0)
        moved = Rig("single-cone", rig.camera, (Laser(cone),))
        return triangulate(moved, u + change[2], v + change[3], branch=branch).radius[0]

    rig = cone_rig(0.5, 1.0)
    known = rig.with_default_uncertainty(1.0).covariance
    rig = rig.knowing(Covariance(known.names, 3 * known.matrix))
    clock = np.pi / 2 - np.radians(-1.827503008673351 + degrees)
    feet = np.array([[np.sin(clock), -np.cos(clock), 0.0]])
    meeting = rig.lasers[0].surface.meet(feet, np.array([[0.0, 0, 1]]))
    u, v = rig.project(feet + np.nanmax(meeting.distance) * np.array([[0.0, 0, 1]]))
    branch = triangulate(rig, u, v, prior_radius=1.0).branch
    spread, step = np.array([1e-3, 1e-3, 1.0, 1.0]), 0.02
    moves = step * np.diag(spread)
    slope = np.array([radius(m) - radius(-m) for m in moves]) / (2 * step)
    bend = np.array([radius(m) - 2 * radius(0 * m) + radius(-m) for m in moves]) / step**2
    second_order = abs(bend.sum()) / 2 / np.linalg.norm(slope)
    ours = margin(rig, u, v, branch=branch, u_pixel=1.0)[0]
    assert ours <= 1.35 / (4 * second_order)
    assert ours >= 0.75 / (4 * second_order) or 8 <= degrees <= 30  # the far one is straight there


@pytest.mark.parametrize(("case", "laser"), [("cone-single", 0), ("cone-dual", 0), ("cone-dual", 1)])
def test_the_independent_renderer_sees_the_same_points_of_a_cone(case, laser):
    if not SIMULATED.is_dir():
        pytest.skip(f"{SIMULATED} is absent: cones are not checked against the independent renderer")
    truth, rig = np.load(SIMULATED / case / "truth.npz"), read_rig(SIMULATED / case / "rig.toml")
    rig = rig.with_default_uncertainty(6 * INCH)
    for station in range(truth["line_u"].shape[0]):
        lit = truth["line_visible"][station, laser]
        u, v, radius, axial = (
            truth[f"line_{name}"][station, laser][lit].astype(float) for name in ("u", "v", "rig_R", "rig_H")
        )
        branch = follow_stripe(meetings_of(rig, u, v, laser=laser), 6 * INCH)
        found = triangulate(rig, u, v, laser=laser, branch=branch)
        safe = margin(rig, u, v, branch=branch, u_pixel=0.3, laser=laser) >= 1
        assert safe.mean() > 0.9
        pixel = 2e-4 * np.abs(found.d_pixel[safe]).max(axis=(1, 2))  # float32 rounding of pixels and radii
        assert (np.abs(found.radius - radius * INCH)[safe] < pixel + 1e-6 * INCH).all()
        assert (np.abs(found.axial - axial * INCH)[safe] < pixel + 1e-5 * INCH).all()


def test_the_independent_renderer_sees_the_same_points_of_a_side_facing_head():
    if not SIMULATED.is_dir():
        pytest.skip(f"{SIMULATED} is absent: the head is not checked against the independent renderer")
    truth, rig = np.load(SIMULATED / "side-2.4in" / "truth.npz"), read_rig(SIMULATED / "side-2.4in" / "rig.toml")
    alone = truth["row_visible"][0] & (truth["row_count"][0] == 1)
    for head in range(alone.shape[0]):
        rows = np.flatnonzero(alone[head])
        found = triangulate(rig, truth["row_u"][0, head][rows], rows.astype(float))
        assert np.abs(found.radius - truth["row_rig_R"][0, head][rows] * INCH).max() < 1e-7 * INCH
        assert np.abs(found.axial - truth["row_rig_H"][0, head][rows] * INCH).max() < 1e-7 * INCH
        assert np.allclose(found.clock, np.pi)  # head frame: y is outwards


def test_a_head_moves_its_points_as_its_parameters_say():
    """R = D cot(aim - zenith) on the centre row (equations.md, 5-1 to 5-20), and its slopes by D and aim."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        baseline, aim, offset = rng.uniform(0.02, 0.1), rng.uniform(0.2, 0.9), rng.uniform(-300, 300)
        camera = Camera(1024, 768, Lens("equidistant", 2000.0, 384.0), (511.0, 383.0))
        rig = Rig("side-facing", camera, (Laser(Sheet()),), mount=SideFacing(baseline, aim))
        angle = aim - offset / 2000
        found = triangulate(rig, [511.0 + offset], [383.0])
        by = dict(zip(found.parameter_names, found.radius_sensitivities.parameters[0], strict=True))
        assert found.radius[0] == pytest.approx(baseline / np.tan(angle), rel=1e-12)
        assert by["laser.baseline"] == pytest.approx(1 / np.tan(angle), rel=1e-10)
        assert by["laser.aim"] == pytest.approx(-baseline / np.sin(angle) ** 2, rel=1e-10)


def test_light_that_draws_no_ring_is_not_projected_as_one():
    camera = Camera(1024, 768, Lens("equidistant", 2000.0, 384.0), (511.0, 383.0))
    rig = Rig("side-facing", camera, (Laser(Sheet()),), mount=SideFacing(0.05, 0.3))
    with pytest.raises(InputError, match="draws no ring"):
        project_ring(rig, 0.15, 16)
