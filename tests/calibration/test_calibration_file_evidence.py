"""What a calibration states follows from its FILE and evidence alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_examples import NAMES, calibration, fitted

from calibore.calibration import (
    calibrate,
    read_calibration,
    recomputed_covariance,
    verify_inputs,
    write_calibration,
)
from calibore.errors import InputError

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
SEEDS = range(1, 4)
ROUNDING = 1e-6
SCATTER = 1e-4
"""Relative: how closely the likelihood of the scatter tells where it is greatest."""


def change(recomputed, stated) -> float:
    return float(np.abs((recomputed.matrix - stated.matrix) / np.outer(stated.u, stated.u)).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_the_covariance_follows_from_the_evidence_within_rounding(tmp_path, seed):
    found = calibration(seed, tied=False)
    write_calibration(found, tmp_path / "lens.toml")
    assert change(recomputed_covariance(tmp_path / "lens.toml"), found.covariance) < ROUNDING


@pytest.mark.parametrize("seed", SEEDS)
def test_so_it_does_with_shared_errors_neighbours_and_prior_knowledge(tmp_path, seed):
    found = calibration(seed)
    write_calibration(found, tmp_path / "lens.toml")
    assert change(recomputed_covariance(tmp_path / "lens.toml"), found.covariance) < SCATTER


@pytest.mark.parametrize("without", ["group", "chain", "prior", "weight"])
def test_each_part_of_the_evidence_matters(tmp_path, without):
    """Else the tests above would say nothing of it."""
    found = calibration()
    seen = found.observations
    n = seen.residual.size
    lost = {"group": np.full(n, -1), "chain": None, "prior": None, "weight": np.ones(n)}[without]
    write_calibration(replace(found, observations=replace(seen, **{without: lost})), tmp_path / "lens.toml")
    assert change(recomputed_covariance(tmp_path / "lens.toml"), found.covariance) > 100 * SCATTER


def test_known_noise_is_taken_as_known(tmp_path):
    fit, seen = fitted(tied=False)
    used = fit.weights > 0
    weighted = fit.jacobian[used] / fit.sigma[used][:, None]
    stated = np.linalg.inv(weighted.T @ weighted)[:4, :4]
    found = calibration(tied=False)
    covariance = type(found.covariance)(NAMES, stated)
    rig = found.rig.knowing(covariance, found.degrees_of_freedom)
    known = replace(found, rig=rig, covariance=covariance, observations=replace(seen, known_noise=True))
    write_calibration(known, tmp_path / "lens.toml")
    assert change(recomputed_covariance(tmp_path / "lens.toml"), covariance) < ROUNDING


def test_where_no_such_fit_was_made_the_whitened_jacobian_says_all(tmp_path):
    found = calibration()
    rows = np.random.default_rng(4).normal(size=(20, 6)) * [2e3, 800.0, 0.4, 1.0, 900.0, 900.0]
    covariance = type(found.covariance)(NAMES, np.linalg.inv(rows.T @ rows)[:4, :4])
    rig = found.rig.knowing(covariance, found.degrees_of_freedom)
    seen = replace(found.observations, whitened=rows)
    write_calibration(replace(found, rig=rig, covariance=covariance, observations=seen), tmp_path / "lens.toml")
    assert change(recomputed_covariance(tmp_path / "lens.toml"), covariance) < ROUNDING


def test_without_evidence_or_with_another_nothing_is_recomputed(tmp_path):
    out = tmp_path / "lens.toml"
    write_calibration(calibration(), out)
    next(tmp_path.glob("*.zarr")).rename(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="has lost its evidence"):
        recomputed_covariance(out)
    other = replace(calibration().observations, names=tuple("abcdef"))
    write_calibration(replace(calibration(), observations=other), out)
    with pytest.raises(InputError, match=r"does not hold laser.baseline, .*belongs to another calibration"):
        recomputed_covariance(out)


def test_evidence_is_a_plain_group_that_others_can_open(tmp_path):
    import xarray as xr

    write_calibration(calibration(), tmp_path / "lens.toml")
    with xr.open_zarr(next(tmp_path.glob("*.zarr"))) as store:
        assert store["residual"].attrs["units"] == "px"
        assert store["jacobian"].dims == ("row", "parameter")
        assert list(store.attrs["names"])[:4] == list(NAMES)
        assert np.array_equal(store["residual"], read_calibration(tmp_path / "lens.toml").observations.residual)


@pytest.mark.parametrize(("verb", "folder"), [("probe", "tactile"), ("rig", "side-range")])
def test_so_does_that_of_real_calibrations_and_a_changed_input_is_seen(tmp_path, verb, folder):
    source = SIMULATED / folder
    if not source.is_dir():
        pytest.skip(f"{source} is absent: no calibration of it is checked against its evidence")
    found, out = calibrate(verb, source), tmp_path / "found.toml"
    write_calibration(found, out)
    assert change(recomputed_covariance(out), found.covariance) < SCATTER
    assert verify_inputs(out, source) == {}
    assert set(verify_inputs(out, tmp_path).values()) == {"missing"}
