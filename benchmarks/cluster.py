"""Two Dask workers against one, on an otherwise idle machine: `python -m benchmarks cluster`."""

import os
import shutil
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.timing import compare
from calibore.crews import Cluster
from calibore.profiling import Tally, measure_scan, prepare
from calibore.scans import read_scan
from calibore.simulation import Station, read_survey, simulate_scan

ROOT = Path(__file__).parents[1]
STATIONS, TIMES = 40, 10
"""Stations that are drawn, and how often the rings of each are measured: of a survey, not of its first second."""
ONE = "one worker"


def report(rounds: int = 3) -> list[str]:
    """Markdown lines."""
    sys.path.append(str(ROOT / "tests" / "crews"))
    from dask_cluster import dask_cluster

    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        survey, seed = read_survey(ROOT / "examples" / "test-pipe.toml")
        survey = replace(survey, stations=tuple(map(Station, range(STATIONS))), step=survey.step / 4)
        scan = simulate_scan(folder / "scan", survey, seed=seed)
        many = _repeated(scan, folder / "many")
        crews = {}
        for count, name in ((1, ONE), (2, "two workers")):
            (folder / name).mkdir()
            address, _ = stack.enter_context(dask_cluster(folder / name, workers=count))
            crews[name] = stack.enter_context(Cluster(address))
            while crews[name].hands < count:
                time.sleep(0.1)

        def measured(name: str) -> list[np.ndarray]:
            job, source, place = prepare(read_scan(many), estimator="zero-crossing")
            results = measure_scan(job, source, place, workers=crews[name], tally=Tally())
            return [result.profile.radius for result in results]

        def drawn(name: str) -> Path:
            return simulate_scan(folder / f"drawn by {name}", survey, seed=seed, workers=crews[name])

        tables = []
        rings = f"{STATIONS * TIMES} images of 1024 x 768, rings with all quantities and uncertainties"
        for what, job in ((rings, measured), (f"{STATIONS} images of 1024 x 768, simulated", drawn)):
            contestants = {name: partial(job, name) for name in crews}
            result = compare(contestants, peer=ONE, rounds=rounds, rng=np.random.default_rng(3))
            tables += [*_head(what), *result.rows(), ""]
        same = all(map(np.array_equal, *(map(np.nan_to_num, measured(name)) for name in crews)))
    return [*tables, f"Results identical: {'yes' if same else 'NO'}."]


def _repeated(scan: Path, folder: Path) -> Path:
    """A scan of the same pictures `TIMES` over, each time further along."""
    folder.mkdir()
    for name in ("scan.toml", "rig.toml"):
        shutil.copy(scan / name, folder)
    for station in range(STATIONS * TIMES):
        os.link(scan / f"pipe {station % STATIONS:03d} 0.png", folder / f"pipe {station:03d} 0.png")
    return folder


def _head(what: str) -> list[str]:
    return [
        f"## Dask: {what}",
        "| contestant | median ms | one worker / contestant (95 %) |",
        "|---|---|---|",
    ]
