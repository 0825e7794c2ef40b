"""A tactile probe: the conversion is right as often as it says, and what is wrong with the tables is named."""

from pathlib import Path

import numpy as np
import pytest
from calibration_probe_tables import INCH, INTERCEPT, SLOPE, found_in, tables, write
from scipy import stats

from calibore.calibration import calibrate_probe, recomputed_covariance, write_calibration
from calibore.errors import InputError
from calibore.rigs import read_probe

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "tactile"
needs_shared = pytest.mark.skipif(not SHARED.exists(), reason="the shared tactile scan is not beside the repository")


@pytest.mark.parametrize(("lengths", "diameters", "wrong"), [(34, 3, 0.0), (34, 4, 0.02 * INCH), (12, 5, 0.0)])
def test_slope_and_intercept_are_as_uncertain_as_they_say(lengths, diameters, wrong):
    rng, cases = np.random.default_rng(11), 400
    inside, errors, stated = 0, [], []
    for _ in range(cases):
        made = tables(rng, lengths=lengths, diameters=diameters, wrong=wrong, noise=rng.uniform(0.5e-4, 3e-4))
        probe, _, _ = found_in(made)
        error = np.array([probe.slope - SLOPE, probe.intercept - INTERCEPT])
        distance = error @ np.linalg.solve(probe.covariance.matrix, error) / 2
        inside += distance < stats.f.ppf(0.95, 2, probe.degrees_of_freedom)
        errors.append(error)
        stated.append(probe.covariance.u)
    assert 0.93 < inside / cases < 0.97 + 0.008  # the 95 % region; one standard deviation of the count is 0.009
    scatter = np.sqrt(np.mean(np.square(errors), axis=0))
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(stated), axis=0)), scatter, rtol=0.1)


def test_a_wrong_diameter_is_named_and_left_out_and_good_ones_are_kept():
    rng = np.random.default_rng(12)
    for _ in range(50):
        _, wrong, _ = found_in(tables(rng, diameters=4, wrong=rng.choice([-1, 1]) * 0.02 * INCH))
        assert list(wrong.kept) == [False, True, True, True]
    lost = sum(not found_in(tables(rng, diameters=4))[1].kept.all() for _ in range(200))
    assert lost <= 2


def test_diameters_that_disagree_enlarge_the_uncertainty_where_none_can_be_told_wrong():
    rng = np.random.default_rng(13)
    _, usual, _ = found_in(tables(rng, diameters=2))
    _, torn, _ = found_in(tables(rng, diameters=2, wrong=0.02 * INCH))
    assert torn.kept.all()
    assert torn.freedom == 1
    assert torn.u > 5 * usual.u / max(usual.enlarged, 1)


def test_a_bent_line_and_a_drift_are_told_and_straight_ones_are_not_accused():
    rng, shuffled = np.random.default_rng(14), np.random.default_rng(0).permutation(34)
    bent = [found_in(tables(rng, bend=0.003 * INCH))[2] for _ in range(40)]
    drifting = [found_in(tables(rng, drift=0.004 * INCH, order=shuffled))[2] for _ in range(40)]
    good = [found_in(tables(rng, order=shuffled))[2] for _ in range(300)]
    assert np.mean([one.p_curved < 0.01 for one in bent]) > 0.9
    assert np.mean([one.p_drift < 0.01 for one in drifting]) > 0.9
    assert np.median([one.drift for one in drifting]) == pytest.approx(0.004 * INCH, rel=0.2)
    for name in ("p_curved", "p_drift", "p_alike"):
        assert np.mean([getattr(one, name) < 0.05 for one in good]) == pytest.approx(0.05, abs=0.035)
    assert found_in(tables(rng))[2].p_drift is None


def test_the_printed_form_of_8_1_has_no_dimension_and_the_corrected_one_gives_the_published_intercept():
    raw = np.array([[0.2698, 0.2085]])
    diameter = 2 * 4.5706 + 5.2405 * raw.sum()
    assert (diameter - 5.2405 * raw.sum()) / 2 == pytest.approx(4.5706)
    assert abs(diameter / (2 * 5.2405 * raw.sum()) - 4.5706) > 2


def test_the_file_gives_the_probe_back_and_the_evidence_its_covariance(tmp_path):
    found = calibrate_probe(write(tmp_path, tables(np.random.default_rng(15))))
    write_calibration(found, tmp_path / "probe.toml")
    probe = read_probe(tmp_path / "probe.toml")
    assert [probe.slope, probe.intercept] == list(found.values.values())
    np.testing.assert_allclose(probe.covariance.matrix, found.covariance.matrix, rtol=1e-12)
    assert probe.degrees_of_freedom == found.degrees_of_freedom
    again = recomputed_covariance(tmp_path / "probe.toml").matrix
    np.testing.assert_allclose(again, found.covariance.matrix, rtol=1e-8)


def test_the_voltmeters_last_digit_is_the_least_noise(tmp_path):
    made = tables(np.random.default_rng(16), noise=1e-7)
    plain = calibrate_probe(write(tmp_path, made, more='u_caliper = "0.0004 in"\n'))
    coarse = calibrate_probe(write(tmp_path, made, more='u_caliper = "0.0004 in"\nadc_bits = 10\nadc_range = 10.0\n'))
    noises = [float(one.settings["probe"]["noise"].split()[0]) for one in (plain, coarse)]
    assert noises[0] < noises[1] == pytest.approx(SLOPE * 10 / 2**10 / np.sqrt(12) / 5, rel=1e-3)


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("lengths.csv", "0.1,1\n0.2,2\n0.3,3\n0.4,4\n", "does not say the unit"),
        ("lengths.csv", "# raw,length_in\n0.1,1\n0.2,2\n0.3,3\n", "has 3 different lengths; measure at least 4"),
        ("lengths.csv", "# raw,length_in\n0.1;1\n0.2;2\n0.3;3\n0.4;4\n", "no table of numbers"),
        ("diameters.csv", "# a,b,c,d,diameter_mm\n1,2,3,4\n", "needs rows of 5 finite numbers"),
        ("target.toml", 'format = "calibore-target/1"\nkind = "probe"\ndiameters = "d.csv"\n', "probe_calibration"),
    ],
)
def test_tables_that_cannot_be_used_say_why(tmp_path, file, text, said):
    write(tmp_path, tables(np.random.default_rng(17)))
    (tmp_path / file).write_text(text)
    with pytest.raises(InputError, match=said):
        calibrate_probe(tmp_path)


@pytest.mark.parametrize("file", ["lengths.csv", "diameters.csv"])
def test_a_table_that_is_not_there_is_asked_for(tmp_path, file):
    write(tmp_path, tables(np.random.default_rng(17)))
    (tmp_path / file).unlink()
    with pytest.raises(InputError, match=rf"{file} is not there; copy the table there.*first line is") as told:
        calibrate_probe(tmp_path)
    assert "Errno" not in str(told.value)


@needs_shared
def test_the_shared_probe_gives_radii_within_a_thousandth_and_a_half_of_an_inch_and_names_its_bad_diameter():
    found = calibrate_probe(SHARED)
    truth = np.load(SHARED / "truth.npz")
    good = ~truth["stuck"] & ~truth["off_tip"]
    slope, intercept = found.values.values()
    off = (slope * truth["raw"] + intercept)[good] - truth["R_contact"][good] * INCH
    assert np.sqrt(np.mean(off**2)) < 0.0015 * INCH
    error = np.array([slope - SLOPE, intercept - INTERCEPT])
    assert (np.abs(error) < 2.5 * found.covariance.u).all()
    assert any("Diameter 3 (stops 35 and 235" in warning for warning in found.warnings)
    assert any("not straight" in warning for warning in found.warnings)
