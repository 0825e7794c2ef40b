"""A folder of PNG files to radii: the pipeline of `calibore profile` against the script a user would write."""

import tempfile
from itertools import count
from pathlib import Path

import cv2
import numpy as np

from benchmarks.peers import opencv_script
from benchmarks.surveys import PLANE, image_paths, stated_rig
from benchmarks.timing import compare
from calibore.crews import in_order
from calibore.images import read_image
from calibore.profiling import Job, Ring, Tally, measure_image, measure_scan, prepare, profile_scan
from calibore.scans import read_scan

REFERENCE = "OpenCV imread + warpPolar + NumPy, radii only"
GROSS_IN = 0.15
INCH = 0.0254


def report(workers: int, rounds: int = 15) -> list[str]:
    """Markdown lines."""
    with tempfile.TemporaryDirectory() as folder:
        return _report(workers, rounds, Path(folder))


def _report(workers: int, rounds: int, folder: Path) -> list[str]:
    cv2.setNumThreads(workers)
    paths, numbers = image_paths(), count()

    def measured() -> dict[int, np.ndarray]:
        job, source, place = prepare(read_scan(PLANE), estimator="zero-crossing")
        results = measure_scan(job, source, place, workers=workers, tally=Tally())
        return {result.profile.station: result.profile.radius / INCH for result in results}

    def radii() -> list[Ring]:
        rig, nominal = stated_rig()
        job = Job.of(rig, nominal)
        return list(in_order(paths, lambda path: measure_image(read_image(path), job), workers=workers))

    def written() -> None:
        profile_scan(PLANE, folder / f"{next(numbers)}", workers=workers)

    contestants = {
        "calibore, radii with uncertainties (the same job)": radii,
        "calibore, rings with all quantities and uncertainties": measured,
        "calibore, the same written to OUT": written,
        REFERENCE: lambda: opencv_script.profile(paths),
    }
    with np.errstate(all="ignore"):
        result = compare(contestants, peer=REFERENCE, rounds=rounds, rng=np.random.default_rng(2))
        ours, theirs = measured(), opencv_script.profile(paths)
    first = {path: radii for path, radii in theirs.items() if path.stem.endswith(" 0")}
    by_station = {int(path.stem.split()[1]): radii for path, radii in first.items()}
    return [
        f"## End to end: {len(paths)} PNG files of plane-12in, {workers} thread(s)",
        "| contestant | median ms | peer / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
        "| contestant | rms radius error in | missed % | beyond 0.15 in % |",
        "|---|---|---|---|",
        _score("calibore (both takes)", ours),
        _score("peer (one take)", by_station),
    ]


def _score(name: str, radii: dict[int, np.ndarray]) -> str:
    with np.load(PLANE / "truth.npz") as truth:
        rows = [int(np.flatnonzero(truth["stop"] == station)[0]) for station in radii]
        true = truth["ring_rig_R"][rows, 0]
        want = truth["ring_rig_visible"][rows, 0] & (truth["ring_rig_signal"][rows, 0] > 0.05)
    error = np.stack(list(radii.values())) - true
    good = want & (np.abs(error) < GROSS_IN)
    missed = want & ~np.isfinite(error)
    outliers = want & np.isfinite(error) & ~good
    rms = np.sqrt(np.mean(error[good] ** 2))
    return f"| {name} | {rms:.4f} | {100 * missed.sum() / want.sum():.2f} | {100 * outliers.sum() / want.sum():.2f} |"
