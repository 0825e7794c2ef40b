"""A real scheduler with two worker processes gives what this machine gives, also when one of them is killed."""

import signal
from pathlib import Path

import numpy as np
import pytest
import zarr

pytest.importorskip("distributed", reason="Dask is not installed: the cluster cannot be tried")

from dask_cluster import dask_cluster

from calibore.crews import Cluster, in_order
from calibore.crews._cluster import AHEAD, LARGEST
from calibore.errors import InputError
from calibore.profiling import profile_scan
from calibore.simulation import read_survey, simulate_scan

EXAMPLES = Path(__file__).parents[2] / "examples"
RIG = (EXAMPLES / "test-pipe-rig.toml").read_text(encoding="utf-8")
SMALL = RIG.replace("1024", "320").replace("768", "240").replace("571.0", "178").replace("[512.0, 384.0]", "[160, 120]")
SPEC = """
format = "calibore-simulation/1"
name = "small"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
parts = [{ kind = "rail", height = "0.8 in", width = "1 in" }]
[motion]
axial = { origin = "-13.1 in", step = "10 mm", stations = 24 }
"""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("dask"), workers=2) as started:
        yield started


def _arrays(out):
    group = zarr.open_group(out / "profile.zarr", mode="r")
    return {name: np.asarray(array) for name, array in group.arrays()}


@pytest.mark.slow
def test_a_scan_is_simulated_and_measured_alike_here_and_there_though_a_worker_is_killed(cluster, tmp_path):
    address, workers = cluster
    (tmp_path / "rig.toml").write_text(SMALL, encoding="utf-8")
    (tmp_path / "spec.toml").write_text(SPEC, encoding="utf-8")
    survey, seed = read_survey(tmp_path / "spec.toml")
    here = simulate_scan(tmp_path / "here", survey, seed=seed, workers=1)
    profile_scan(here, tmp_path / "out-here", workers=1)
    with Cluster(address) as crew:
        there = simulate_scan(tmp_path / "there", survey, seed=seed, workers=crew)
        for picture in here.glob("*.png"):
            assert (there / picture.name).read_bytes() == picture.read_bytes()

        def progress(done, total):
            if done == 4:
                workers[0].send_signal(signal.SIGKILL)

        profile_scan(here, tmp_path / "out-there", workers=crew, progress=progress)
    workers[0].wait(timeout=10)
    ours, theirs = _arrays(tmp_path / "out-here"), _arrays(tmp_path / "out-there")
    assert ours.keys() == theirs.keys()
    for name, values in ours.items():
        np.testing.assert_array_equal(values, theirs[name], err_msg=name)
    assert workers[0].returncode == -signal.SIGKILL


def test_results_come_in_order_and_errors_come_home(cluster):
    with Cluster(cluster[0]) as crew:
        assert list(in_order(range(30), lambda x: x * x, workers=crew)) == [x * x for x in range(30)]

        def refuse(number):
            raise InputError(f"Number {number} is refused.")

        with pytest.raises(InputError, match=r"^Number 3 is refused\.$"):
            list(in_order([3, 4], refuse, workers=crew))


def test_a_failure_costs_no_result_before_it(cluster):
    def refuse(number):
        if number == 37:
            raise InputError("Number 37 is refused.")
        return number

    came = []
    with Cluster(cluster[0]) as crew, pytest.raises(InputError, match=r"^Number 37 is refused\.$"):
        came.extend(crew.in_order(iter(range(60)), refuse))
    assert came == list(range(37))


def test_items_are_drawn_only_as_far_ahead_as_the_workers_need_them(cluster):
    drawn, most = 0, 0

    def items():
        nonlocal drawn
        while drawn < 400:
            drawn += 1
            yield drawn

    with Cluster(cluster[0]) as crew:
        for taken in crew.in_order(items(), abs):
            most = max(most, drawn - taken)
        assert (drawn, taken) == (400, 400)
        assert LARGEST < most <= (AHEAD * crew.hands + 1) * LARGEST


def test_no_scheduler_is_one_sentence(monkeypatch):
    monkeypatch.setattr("calibore.crews._cluster.PATIENCE", 1)
    with pytest.raises(InputError, match=r'No Dask scheduler answers at "tcp://127\.0\.0\.1:9"; start one with'):
        Cluster("tcp://127.0.0.1:9")
    with pytest.raises(InputError, match="No Dask scheduler answers"):
        Cluster("nowhere")
