"""Predicted against simulated uncertainty, for rigs of every kind: `python -m benchmarks every_rig`."""

import sys
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
COVERAGE_FACTOR = 1.96
FIRST_ORDER = 4.0
"""Margin from which the law of propagation holds (docs/decisions/0005)."""


def report(rigs: int = 300, draws: int = 20) -> list[str]:
    """Markdown lines: a row per kind, from `rigs` random rig files and `draws` true rigs behind each; no pictures."""
    sys.path.insert(0, str(TESTS / "properties"))
    from random_rigs import Detections, detections

    from calibore.simulation import RIG_KINDS

    head = "| kind | points | m >= 4 | R: rms error / rms u | R: rms of error / u | R inside | H: rms error / rms u "
    lines = [f"## {rigs} random rigs of every kind, {draws} true rigs behind each", ""]
    lines += [f"{head}| H: rms of error / u | H inside |", "|---" * 9 + "|"]
    for kind in RIG_KINDS:
        several = [detections(kind, 1000 + seed, draws=draws) for seed in range(rigs)]
        every = Detections(*(np.concatenate(columns) for columns in zip(*several, strict=True)))
        kept = Detections(*(column[every.margin >= FIRST_ORDER] for column in every))
        share = 100 * kept.margin.size / every.margin.size
        numbers = (_compared(kept.radius_error, kept.radius_u), _compared(kept.axial_error, kept.axial_u))
        lines.append(f"| {kind} | {kept.margin.size} | {share:.1f} % | {' | '.join(numbers)} |")
    return lines


def _compared(error: np.ndarray, u: np.ndarray) -> str:
    pooled, single = np.sqrt(np.mean(error**2) / np.mean(u**2)), np.sqrt(np.mean((error / u) ** 2))
    return f"{pooled:.3f} | {single:.3f} | {100 * np.mean(np.abs(error) <= COVERAGE_FACTOR * u):.1f} %"
