"""Half of the pictures against the other half: chance where the model suits the lens, more where it does not."""

from dataclasses import replace

import numpy as np
import pytest
from made_calibrations import LENS, RADIUS, board_calibration, rig_calibration, told_before
from scipy.stats import kstest

from calibore.calibration import halves
from calibore.errors import InputError
from calibore.uncertainty import Covariance


def test_halves_of_a_good_calibration_differ_as_much_as_its_covariance_says():
    found = [halves(board_calibration(seed, boards=8)) for seed in range(1, 17)]
    assert kstest([one.p for one in found], "uniform").pvalue > 0.001
    ratio = np.sqrt(np.median([one.rms**2 for one in found]) / np.median([one.expected**2 for one in found]))
    assert 0.5 < ratio < 1.4  # the median of a square of few degrees of freedom lies below its mean
    assert all(one.parts == ("pictures", 4, 4) for one in found)


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_what_was_known_of_the_camera_before_is_no_difference_of_halves(size):
    """Both halves were told the same, be it much less or much more than they see."""
    found = [halves(told_before(board_calibration(seed, boards=8), size=size, seed=seed)) for seed in range(1, 17)]
    assert kstest([one.p for one in found], "uniform").pvalue > 0.001
    ratio = np.sqrt(np.median([one.rms**2 for one in found]) / np.median([one.expected**2 for one in found]))
    assert 0.5 < ratio < 1.4
    assert all(one.outweighed == ("hardly check it" in one.verdict()) == (size < 1) for one in found)


def test_what_was_known_before_hides_no_lens_that_no_model_describes():
    bent = told_before(board_calibration(4, boards=10, noise=0.02, bent=0.7), size=1.0)
    assert halves(bent).p < 1e-3


def test_errors_that_both_halves_share_are_no_difference():
    """Boards printed too large, all of them alike, change k in every picture by as much."""
    calibration = board_calibration(1)
    seen, of_scale = calibration.observations, 5.0 * np.eye(len(LENS))[0]
    alike = replace(
        calibration,
        covariance=Covariance(LENS, calibration.covariance.matrix + np.outer(of_scale, of_scale)),
        observations=replace(seen, group=0 * seen.group, load=seen.jacobian[:, 0], known_group_sigma=5.0),
    )
    assert abs(halves(alike).expected / halves(calibration).expected - 1) < 0.05


def test_halves_agree_with_two_fits_of_the_pictures():
    """What the evidence says in first order is what two fits of half the boards find."""
    whole = board_calibration(1)
    found = halves(whole)
    seen, change = whole.observations, []
    for start in (0, 1):
        rows = seen.file % 2 == start
        change.append(np.linalg.lstsq(seen.jacobian[rows], seen.residual[rows], rcond=None)[0][: len(LENS)])
    moved_by = change[1] - change[0]
    expected = np.sqrt(np.diag(whole.covariance.matrix)) * 2
    assert (np.abs(moved_by) < 4 * expected).all()
    assert found.rms < 4 * found.expected


def test_a_lens_that_no_model_describes_shows():
    """Waves of 0.7 px in the lens: both halves fit, and each predicts the other wrongly."""
    good, bent = (
        halves(board_calibration(4, boards=10, noise=0.02)),
        halves(board_calibration(4, boards=10, noise=0.02, bent=0.7)),
    )
    assert good.agree
    assert bent.rms > 4 * good.rms


def test_more_or_quieter_pictures_bring_halves_below_the_limit():
    found = halves(board_calibration(6, boards=30, noise=0.05))
    assert found.agree
    assert "within the 0.2 px" in found.verdict()


def test_on_the_wall_too():
    found = halves(rig_calibration(1), nominal_radius=RADIUS)
    assert 0 < found.wall_rms < 4 * found.wall_expected


def test_errors_that_groups_share_weigh_in_halves():
    """With errors of 0.3 px common to a board, more is expected of halves than from the marks' noise."""
    calibration = board_calibration(1)
    shared = replace(calibration, group_sigma=0.3)
    ours = halves(shared)
    assert np.isfinite(ours.rms)
    assert ours.parts == ("pictures", 7, 7)


def test_what_has_no_evidence_or_too_little_is_refused():
    calibration = board_calibration(1)
    seen = calibration.observations
    arrays = ("file", "u", "v", "residual", "sigma", "weight", "group", "jacobian")
    none = replace(seen, **{name: getattr(seen, name)[:0] for name in arrays})
    with pytest.raises(InputError, match="no evidence"):
        halves(replace(calibration, observations=none))
    one = replace(seen, file=0 * seen.file, group=0 * seen.group)
    with pytest.raises(InputError, match="too few"):
        halves(replace(calibration, observations=one))
    flat = replace(seen, jacobian=seen.jacobian * (np.array(seen.names) != "camera.c2"))
    with pytest.raises(InputError, match="c2"):
        halves(replace(calibration, observations=flat))
