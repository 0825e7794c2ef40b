"""Certified non-linear regressions: NIST's Statistical Reference Datasets, and an example of the GUM."""

import numpy as np
import pytest
from nist_models import FOLDER, LAWS, model, read_certified

from calibore.fitting import least_squares

DIGITS = 6.0  # of parameters, from Start 2
DIGITS_OF_DEVIATIONS = 4.0  # of standard deviations
NOISELESS = ("Lanczos1",)  # residuals of 1e-13 of the data, below double precision of the model

needs_data = pytest.mark.skipif(not FOLDER.exists(), reason=f"NIST's datasets are not in {FOLDER}")


@needs_data
@pytest.mark.parametrize("name", LAWS)
def test_derivatives_of_the_models_agree_with_complex_steps(name: str):
    certified = read_certified(name)
    slopes = np.column_stack(LAWS[name](certified.values, certified.x)[1])
    for number, value in enumerate(certified.values):
        moved = certified.values.astype(complex)
        moved[number] += 1e-30j * value
        step = LAWS[name](moved, certified.x)[0].imag / (1e-30 * value)
        assert np.allclose(step, slopes[:, number], rtol=1e-9, atol=1e-9 * np.abs(slopes[:, number]).max())


@needs_data
def test_certified_parameters_and_deviations_are_found_from_start_2():
    digits = np.array([_digits(name, start=1) for name in LAWS])
    for name, (values, deviations) in zip(LAWS, digits, strict=True):
        print(f"{name:10s} digits of parameters {values:5.2f}, of standard deviations {deviations:5.2f}")
    assert np.sum(digits[:, 0] >= DIGITS) >= 26
    assert digits[:, 0].min() >= 4
    assert np.sum(digits[:, 1] >= DIGITS_OF_DEVIATIONS) >= 26


@needs_data
def test_certified_parameters_are_found_from_the_far_start_1():
    digits = np.array([_digits(name, start=0) for name in LAWS])
    assert (digits[:, 0] >= DIGITS).all()
    assert all(digits[i, 1] >= DIGITS_OF_DEVIATIONS for i, name in enumerate(LAWS) if name not in NOISELESS)


def _digits(name: str, *, start: int) -> tuple[float, float]:
    """Agreeing digits of the worst parameter and of the worst standard deviation."""
    certified = read_certified(name)
    names = [f"b{i + 1}" for i in range(certified.values.size)]
    fit = least_squares(model(name, certified), certified.starts[start], names=names)
    pairs = ((fit.values, certified.values), (fit.u, certified.deviations))
    found = [-np.log10(max(np.max(np.abs(value - true) / np.abs(true)), 1e-16)) for value, true in pairs]
    return float(found[0]), float(found[1])


def test_the_calibration_of_a_thermometer_in_gum_h3_is_found():
    reading = np.array([21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511]) - 20
    correction = np.array([171, 169, 166, 159, 164, 165, 156, 157, 159, 161, 160]) * -1e-3
    jacobian = np.column_stack([np.ones(11), reading])
    fit = least_squares(lambda b: (correction - jacobian @ b, jacobian), [0.0, 0.0], names=["intercept", "slope"])
    at_30 = np.array([1.0, 10.0])
    assert np.allclose(fit.values, [-0.1712, 0.00218], atol=[5e-5, 5e-6])
    assert np.allclose(fit.u, [0.0029, 0.00067], atol=[5e-5, 5e-6])
    assert fit.covariance[0, 1] / fit.u.prod() == pytest.approx(-0.930, abs=5e-4)
    assert at_30 @ fit.values == pytest.approx(-0.1494, abs=5e-5)
    assert np.sqrt(at_30 @ fit.covariance @ at_30) == pytest.approx(0.0041, abs=5e-5)
    assert fit.degrees_of_freedom == pytest.approx(9)
