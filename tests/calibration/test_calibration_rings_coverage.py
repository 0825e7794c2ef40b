"""What a ring calibration states is as often right as it says."""

import numpy as np
import pytest
from calibration_ring_marks import random_case
from scipy.stats import t as student

from calibore.calibration._rings._fit import final_fit, fit_all
from calibore.calibration._rings._result import calibrated
from calibore.fitting import region_contains
from calibore.lasers import Plane
from calibore.rigs import triangulate
from calibore.uncertainty import Covariance, propagate

CASES = 40
"""500 of them gave 96 % regions and a scatter of 1.00 u: `python -m benchmarks calibration`."""
CLOCKS = np.arange(4) * np.pi / 2 + 0.3
NOMINAL = 0.8
"""Of the outermost ring's radius: where the wall is."""


def _calibrated(seed):
    """Whether the region holds the truth; on the wall: error over u, and degrees of freedom."""
    case = random_case(np.random.default_rng([12, seed]))
    short, fits = fit_all(case.sight, (case.lens,))
    ring_fit = final_fit(short, fits[case.lens])
    fit, names = ring_fit.fit, calibrated(ring_fit)
    held = region_contains(fit, [case.truth[name] for name in names], names=names)
    index = [fit.names.index(name) for name in names]
    covariance = Covariance(names, fit.covariance[np.ix_(index, index)])
    rig = ring_fit.model.rig(fit.values, 0).knowing(covariance)
    radius = NOMINAL * case.radii[-1]
    plane = Plane(*(case.truth[f"laser.{name}"] for name in Plane.parameter_names))
    x, y = radius * np.cos(CLOCKS), radius * np.sin(CLOCKS)
    wall = np.stack([x, y, plane.baseline + plane.tilt_x * x + plane.tilt_y * y], axis=1)
    found = triangulate(rig, *case.lens.camera(case.truth, width=1024, height=768).project(wall))
    slopes = found.radius_sensitivities.parameters
    u = propagate(slopes, covariance, names=rig.parameter_names).u
    freedom = []
    for row in slopes:
        combination = np.zeros(len(fit.names))
        combination[index] = [row[rig.parameter_names.index(name)] for name in names]
        freedom.append(fit.degrees_of_freedom_of(combination))
    return held, (found.radius - radius) / u, np.array(freedom)


@pytest.mark.slow
def test_regions_hold_the_truth_as_often_as_they_say_and_u_on_the_wall_is_the_actual_scatter():
    held, errors, freedom = zip(*map(_calibrated, range(CASES)), strict=True)
    errors, freedom = np.concatenate(errors), np.concatenate(freedom)
    # binomial, 40 of 0.95: fewer than 34 by chance in one of 300 such tests
    assert np.mean(held) >= 34 / 40
    inside = np.abs(errors) <= student.ppf(0.975, freedom)
    # the four radii of a case are as good as two independent ones: of 80, fewer than 0.875 in one of 400
    assert inside.mean() >= 0.875
    # an estimate with few degrees of freedom scatters as Student's t does, by more than u
    scatter = np.sqrt(np.mean(errors**2 * (1 - 2 / np.maximum(freedom, 3))))
    # chi-square of 80: its root is off by more than 0.22 in one of 200
    assert abs(scatter - 1) < 0.22
