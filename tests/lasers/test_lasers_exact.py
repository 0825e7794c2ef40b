"""The same meetings in 40-digit arithmetic, written independently: along the ray, root by root, in ascending order."""

import mpmath as mp
import numpy as np
from rays_everywhere import rays, relative, surfaces

from calibore.lasers import Cone

mp.mp.dps = 40
AGREEMENT = 1e-10  # relative; grazing meetings, which lose digits, are flagged and left out
CASES = 60


def exact(values):
    return [mp.mpf(float(value)) for value in values]


def dot(a, b):
    return sum((x * y for x, y in zip(a, b, strict=True)), mp.mpf(0))


def exact_cone(cone):
    baseline, aim, half_angle, clock, offset = exact(getattr(cone, name) for name in cone.parameter_names)
    outwards = [mp.sin(clock), -mp.cos(clock), mp.mpf(0)]
    apex = [baseline * e for e in outwards[:2]] + [offset]
    return apex, [-mp.sin(aim) * e for e in outwards[:2]] + [mp.cos(aim)], mp.cos(half_angle)


def lit_roots(cone, origin, direction):
    """Ascending distances at which F = 0, and F' there."""
    (apex, axis, cosine), u = exact_cone(cone), exact(direction)
    m = [o - v for o, v in zip(exact(origin), apex, strict=True)]
    a, b, c = (dot(axis, p) * dot(axis, q) - cosine**2 * dot(p, q) for p, q in ((u, u), (u, m), (m, m)))
    if b * b < a * c:
        return []
    roots = sorted((-b + sign * mp.sqrt(b * b - a * c)) / a for sign in (1, -1))

    def value(t):
        w = [p + t * q for p, q in zip(m, u, strict=True)]
        return dot(axis, w) - cosine * mp.sqrt(dot(w, w))

    return [(t, mp.diff(value, t)) for t in roots if abs(value(t)) < mp.mpf(10) ** -25 * (1 + abs(t))]


def test_meetings_with_cones_agree_with_exact_ones():
    compared = 0
    for cone in surfaces("cone", 40, seed=11):
        origins, directions = rays(np.random.default_rng(12), CASES // 4)
        meetings = cone.meet(origins, directions)
        for i, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
            expected = [np.nan, np.nan]
            for t, slope in lit_roots(cone, origin, direction):
                expected[0 if slope * mp.cos(cone.half_angle) > 0 else 1] = float(t)
            assert np.array_equal(np.isnan(expected), meetings.flags[:, i] == 0)
            good = meetings.admissible[:, i]
            np.testing.assert_allclose(meetings.distance[good, i], np.array(expected)[good], rtol=AGREEMENT)
            compared += good.sum()
    assert compared > 100


def test_meetings_with_flat_surfaces_agree_with_exact_ones():
    for kind in ("plane", "sheet"):
        for surface in surfaces(kind, 10):
            origins, directions = rays(np.random.default_rng(13), CASES)
            meetings = surface.meet(origins, directions)
            one, two, three = exact(getattr(surface, name) for name in surface.parameter_names)
            for i in np.nonzero(meetings.admissible[0])[0]:
                o, u = exact(origins[i]), exact(directions[i])
                if kind == "sheet":  # x = offset + skew y + lean z
                    expected = (one + two * o[1] + three * o[2] - o[0]) / (u[0] - two * u[1] - three * u[2])
                else:  # z = baseline + tilt_x x + tilt_y y
                    expected = (one + two * o[0] + three * o[1] - o[2]) / (u[2] - two * u[0] - three * u[1])
                assert abs(meetings.distance[0, i] / float(expected) - 1) < AGREEMENT


def test_gradients_of_cones_agree_with_exact_ones():
    for cone in surfaces("cone", 10, seed=14):
        point = np.random.default_rng(15).normal(size=3)

        def value(*q):
            baseline, aim, half_angle, clock, offset, x, y, z = q
            outwards = [mp.sin(clock), -mp.cos(clock), 0]
            w = [x - baseline * outwards[0], y - baseline * outwards[1], z - offset]
            reach = mp.cos(aim) * w[2] - mp.sin(aim) * (w[0] * outwards[0] + w[1] * outwards[1])
            return reach - mp.cos(half_angle) * mp.sqrt(dot(w, w))

        at = exact([*(getattr(cone, name) for name in cone.parameter_names), *point])
        orders = [tuple(int(i == j) for j in range(8)) for i in range(8)]
        expected = np.array([float(mp.diff(value, at, order)) for order in orders])
        assert relative(cone.parameter_gradient(point[None])[0], expected[:5]) < AGREEMENT
        assert relative(cone.gradient(point[None])[0], expected[5:]) < AGREEMENT


def test_next_to_a_tangent_ray_the_meetings_keep_the_digits_that_the_question_has():
    """The discriminant comes from the plane through apex and ray: an error of rounding, not of its square root."""
    cone = Cone.for_ring(0.5, 1.0, 1.0)
    for sine in (1e-2, 1e-4, 1e-6):
        half = float(cone.half_angle)
        azimuth = 2.0
        sideways = np.cross(cone.axis, [1.0, 0.0, 0.0])
        generator = np.cos(half) * cone.axis
        generator = generator + np.sin(half) * (np.cos(azimuth) * np.array([1.0, 0, 0]) + np.sin(azimuth) * sideways)
        touched = cone.apex + 0.8 * generator
        normal = cone.gradient(touched[None])[0] / np.sin(half)
        tangent = np.cross(normal, generator)
        direction = (tangent + sine * normal)[None] / np.hypot(1, sine)
        origin = touched - 0.7 * direction[0]
        distance = cone.meet(origin, direction).distance[:, 0]
        expected = [float(t) for t, _ in lit_roots(cone, origin, direction[0])]
        np.testing.assert_allclose(distance, expected, rtol=0, atol=1e-15 / sine)
