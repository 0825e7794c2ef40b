"""Errors come out as predicted: the dissertation's instruments in pictures, their calibration exact, or drifted."""

import numpy as np
import pytest
from drifting_instruments import drifted_points, drifted_section, drifting, true_rigs
from known_instruments import SINE_LAW, beside_fold, instruments, ring_rays, ring_section, strip, walls

from calibore.design import predict_on_wall

STATIONS = 3
DRAWS = 128


def ratio(pairs):
    """Rms of the errors over rms of what was predicted, of pairs of arrays."""
    error, u = (np.concatenate(arrays) for arrays in zip(*pairs, strict=True))
    return float(np.sqrt(np.mean(error**2) / np.mean(u**2)))


def held(error, u):
    """Share of the points that lie inside."""
    counts = np.isfinite(error)
    return np.mean(np.abs(error[counts]) <= 1.96 * u[counts])


def away(section, keep=True):
    counts = section.away & keep
    return section.error[counts], section.u[counts]


def test_the_rms_of_the_four_planes_is_as_predicted_with_features_in_the_pipe_and_without():
    rigs, pipes = instruments(), walls()
    for pipe, names in (("plain", SINE_LAW), ("test pipe, smooth", ("plane-6in", "plane-30in"))):
        found = [away(ring_section(rigs[name], pipes[pipe], seed)) for name in names for seed in range(STATIONS)]
        # 6 rings tell the ratio to 2 %, 12 to 1.5 %
        assert ratio(found) == pytest.approx(1.0, abs=0.06)


def test_the_rms_of_a_cone_is_as_predicted_away_from_its_fold_on_either_side():
    """Its line is 1.2 px wide below and 2 px above, and so is noisier; with one width for both the ratio was 1.2 and
    0.4 to 0.9, 1 or not on the whole.
    """
    rig, plain, keep = instruments()["cone-single"], walls()["plain"], ~beside_fold("cone-single")
    sections = [ring_section(rig, plain, seed) for seed in range(2 * STATIONS)]
    # 6 rings tell it to 3 %, a half of them to 5 %
    assert ratio([away(section, keep) for section in sections]) == pytest.approx(1.0, abs=0.06)
    above = np.cos(np.arange(keep.size) * (2 * np.pi / keep.size)) > 0
    for side in (above, ~above):
        found = [away(section, keep & side) for section in sections]
        assert ratio(found) == pytest.approx(1.0, abs=0.1)
        assert held(*(np.concatenate(arrays) for arrays in zip(*found, strict=True))) == pytest.approx(0.95, abs=0.02)


def test_the_rms_of_the_rows_of_a_head_is_as_predicted():
    rig, plain = instruments()["side-2.4in"], walls()["plain"]
    pairs = []
    for seed in range(STATIONS):
        rows, said = strip(rig, plain, seed), predict_on_wall(rig, 0.0, plain.nominal_radius).of_radius.independent
        usual = rows.u <= 3 * np.median(rows.u)  # of a speckle taken for the line a designer knows nothing
        pairs.append((rows.error[usual], said * rows.u[usual]))
    # 3 pictures tell it to 4 %
    assert ratio(pairs) == pytest.approx(1.0, abs=0.1)


def test_the_rms_of_single_rays_is_told_before_the_rig_is_built():
    rig, plain = instruments()["plane-12in"], walls()["plain"]
    pairs = []
    for seed in range(STATIONS):
        rays = ring_rays(rig, plain, seed)
        said = predict_on_wall(rig, rays.clock, plain.nominal_radius, u_pixel=float(np.median(rays.u)))
        pairs.append((rays.error, said.of_radius.independent))
    assert ratio(pairs) == pytest.approx(1.0, abs=0.06)


def test_stated_drift_widens_intervals_to_hold_the_truth_and_none_stated_does_not(tmp_path):
    inside, pictured = [], []
    for number, (name, rig) in enumerate(instruments().items()):
        exact, drift = drifting(rig, tmp_path)
        rng = np.random.default_rng([6, number])
        drawn = [drifted_points(true, drift, rng, points=20, u_pixel=0.2) for true in true_rigs(drift, DRAWS, number)]
        inside += [held(error, u) for error, u in drawn]
        if name in ("plane-6in", "plane-30in", "side-2.4in"):
            pictured += [drifted_section(true, exact, drift, number) for true in true_rigs(drift, 2, number)]
    # one draw shares its error: coverage scatters by 20 points from draw to draw, the mean of 768 by 0.7 at most
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)
    without, within = (np.mean([held(one[0], one[place]) for one in pictured]) for place in (1, 2))
    assert without < 0.6
    assert within > 0.8
