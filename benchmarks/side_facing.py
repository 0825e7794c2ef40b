"""One picture of a side-facing head, 1024 rows: our kernel against NumPy and OpenCV, truth checked in the same run."""

from collections.abc import Callable
from functools import partial

import cv2
import numpy as np

from benchmarks.peers import side_rows as peer
from benchmarks.surveys import GROSS, SHARED
from benchmarks.timing import compare
from calibore.images import read_image
from calibore.stripe import detect_line

SIDE, STOP, NUMBER, ROWS = SHARED / "side-2.4in", 300, 12, 1024
REFERENCE = "vectorised NumPy, parabola"


def report(rounds: int = 100) -> list[str]:
    """Markdown lines."""
    cv2.setNumThreads(1)
    picture = read_image(SIDE / f"side 000 {STOP:03d} 0.png")
    image = np.ascontiguousarray(np.concatenate([picture, picture])[:ROWS])

    def ours(estimator: str) -> np.ndarray:
        return detect_line(image, down=True, channel="red", estimator=estimator).u

    contestants: dict[str, Callable[[], np.ndarray]] = {
        "calibore detect_line down, with noise model and uncertainty": partial(ours, "zero-crossing"),
        "calibore detect_line down, parabola, with uncertainty": partial(ours, "parabola"),
        "calibore detect_line down, centre of gravity, with uncertainty": partial(ours, "centroid"),
        REFERENCE: partial(peer.parabola, image, 0),
        "OpenCV blur, argmax + centre of gravity": partial(peer.gravity, image, 0),
    }
    with np.errstate(all="ignore"):
        result = compare(contestants, peer=REFERENCE, rounds=rounds, rng=np.random.default_rng(1))
        truth = [f"| {name} | {rms:.3f} | {100 * f:.1f} |" for name, (rms, f) in _truth(contestants)]
    return [
        f"## Side-facing: 1024 x {ROWS} RGB, one peak per row, one thread",
        "| contestant | median ms | peer / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
        "| contestant | rms error px | rows measured % |",
        "|---|---|---|",
        *truth,
    ]


def _truth(contestants: dict[str, Callable[[], np.ndarray]]) -> list[tuple[str, tuple[float, float]]]:
    with np.load(SIDE / "truth.npz") as truth:
        seen = truth["row_visible"][0, NUMBER] & (truth["row_count"][0, NUMBER] == 1)
        line = np.where(seen, truth["row_u"][0, NUMBER], np.nan)
    found = []
    for name, call in contestants.items():
        error = call()[: line.size] - line
        good = np.abs(error) < GROSS
        found.append((name, (float(np.sqrt(np.mean(error[good] ** 2))), float(good.sum() / seen.sum()))))
    return found
