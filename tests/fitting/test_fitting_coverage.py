"""What a fit states holds over many simulated calibrations."""

import numpy as np
import pytest
from scipy.stats import t
from simulated_fits import NAMES, TRUTH, Bench

from calibore.fitting import region_contains

PROBLEMS = 300
COVERED = (0.93, 0.97)  # of 95 % regions
AGREES = 0.10  # relative, of stated and actual standard deviations; four times what 300 draws scatter

BENCHES = {
    "white noise": Bench(),
    "few data and a prior": Bench(groups=4, marks=5, prior=True),
    "correlated neighbours": Bench(marks=15, correlation=0.7),
    "8 groups": Bench(groups=8, marks=10, group_sigma=0.05),
    "groups, neighbours and a prior": Bench(groups=10, marks=15, correlation=0.6, group_sigma=0.05, prior=True),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", BENCHES)
def test_regions_hold_the_truth_and_u_is_the_scatter(case: str):
    rng = np.random.default_rng(1)
    fits = [BENCHES[case].fit(rng) for _ in range(PROBLEMS)]
    covered = np.mean([region_contains(fit, TRUTH) for fit in fits])
    away = np.array([fit.values - TRUTH for fit in fits])
    u = np.array([fit.u for fit in fits])
    degrees = np.array([[fit.degrees_of_freedom_of(unit) for unit in np.eye(3)] for fit in fits])
    each = np.mean(np.abs(away) < u * t.ppf(0.975, degrees), axis=0)
    ratio = np.sqrt(np.mean(u**2, axis=0) / np.mean(away**2, axis=0))
    said = dict(zip(NAMES, zip(each.round(3), ratio.round(3), strict=True), strict=True))
    print(f"{case}: region {covered:.3f}, intervals and u / scatter {said}")
    assert COVERED[0] <= covered <= COVERED[1]
    assert (np.abs(ratio - 1) < AGREES).all()
    assert (np.abs(each - 0.95) < 0.04).all()
