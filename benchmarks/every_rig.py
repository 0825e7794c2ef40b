"""Predicted against simulated uncertainty: `python -m benchmarks every_rig` for rigs of every kind without pictures,
and `python -m benchmarks pictures` with pictures of those that draw rings.
"""

import sys
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
COVERAGE_FACTOR = 1.96
FIRST_ORDER = 4.0
"""Margin from which the law of propagation holds (docs/decisions/0005)."""
MEASURABLE = 0.05
"""Signal from which a point counts (data README)."""
RING_KINDS = ("perpendicular-plane", "single-cone", "dual-cone", "coaxial-cone", "asymmetric-cone", "reversed-cone")


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


def pictures(rigs: int = 100) -> list[str]:
    """Markdown lines: rings measured in simulated pictures, with an exact rig file, and with one wrong by a draw."""
    head = "| kind | rig file | rigs | inside 1.96 u | rms error / u | missed | points |"
    rows = [_pictured(kind, rigs, exact=exact) for kind in RING_KINDS for exact in (True, False)]
    return ["## Pictures by random rigs, profiled", "", head, "|---" * 7 + "|", *rows]


def _pictured(kind: str, rigs: int, *, exact: bool) -> str:
    sys.path.insert(0, str(TESTS / "properties"))
    from random_rigs import one_ring

    z, missed, wanted = [], 0, 0
    for seed in range(rigs):
        ring, truth, _ = one_ring(seed, exact=exact, features=not exact, kind=kind)
        want = truth.visible & (truth.signal > MEASURABLE)
        got = want & np.isfinite(ring.radius)
        common = 0.0 if exact else np.sqrt(np.sum(ring.modes**2, axis=0))
        z.append(((ring.radius - truth.radius) / np.hypot(ring.u, common))[got])
        missed, wanted = missed + int((want & ~got).sum()), wanted + int(want.sum())
    every = np.concatenate(z)
    inside, rms = 100 * np.mean(np.abs(every) <= COVERAGE_FACTOR), np.sqrt(np.mean(every[np.abs(every) < 6] ** 2))
    said = "exact" if exact else "wrong by a draw, features"
    return f"| {kind} | {said} | {rigs} | {inside:.1f} % | {rms:.2f} | {100 * missed / wanted:.2f} % | {every.size} |"
