"""The centre of a ring is where its undisturbed wall says it is."""

import numpy as np
import pytest

from calibore.metrics import RingShape, ring_quantities

RADIUS, NOISE = 0.15, 1.5e-4
CLOCK = np.arange(400) * (2 * np.pi / 400)


def _bump(width_degrees, *, at=1.0):
    away = np.mod(CLOCK - at + np.pi, 2 * np.pi) - np.pi
    return np.exp(-0.5 * (away / np.radians(width_degrees)) ** 2)


FEATURES = {
    "none": np.zeros(400),
    "dent": -0.05 * RADIUS * _bump(9),
    "wide dent": -0.03 * RADIUS * _bump(15),
    "opening": 0.1 * RADIUS * (_bump(25) > 0.5),
    "two features": -0.05 * RADIUS * _bump(9) + 0.1 * RADIUS * (_bump(12, at=3.5) > 0.5),
}


@pytest.mark.parametrize("feature", FEATURES)
@pytest.mark.parametrize("ovality", [0.0, 0.02])
def test_features_do_not_pull_the_centre(feature, ovality):
    rng = np.random.default_rng(1)
    centre = np.array([0.012, -0.02])
    pulled = []
    for _ in range(5):
        wall = RADIUS * (1 + ovality * np.cos(2 * (CLOCK - 0.4))) + FEATURES[feature]
        x, y = centre[0] + wall * np.sin(CLOCK), centre[1] - wall * np.cos(CLOCK)
        angle, radius = np.mod(np.arctan2(x, -y), 2 * np.pi), np.hypot(x, y)
        order = np.argsort(angle)
        measured = radius[order] + NOISE * rng.standard_normal(400)
        found = ring_quantities(RingShape(angle[order], measured, np.full(400, NOISE)), nominal_radius=RADIUS)
        pulled.append([found.centre_x.value - centre[0], found.centre_y.value - centre[1]])
    # a least-squares circle is pulled by 0.5 to 2.7 % of the radius, a robust one without ovality by up to 0.5 %
    assert np.abs(np.mean(pulled, axis=0)).max() < 0.0016 * RADIUS
