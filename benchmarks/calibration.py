"""Do calibrations hold what they state: `python -m benchmarks calibration`, on the tests' random calibrations.

`python -m benchmarks calibration probe` runs the kinds whose name begins so.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
PROCESSES = 2
COUNT = {"concentric rings": 300, "probe": 400, "two pins": 500}
OTHERWISE = 200
SEEDS = 1000
"""From here on; tests use those below."""
CHUNK = 10


def report(kind: str = "") -> list[str]:
    """Markdown lines: a row per kind of calibration whose name begins with `kind`."""
    kinds = [name for name in _cases().KINDS if name.startswith(kind)]
    head = "| calibration | simulated | 95 % regions that hold | scatter / u | 95 % intervals that hold | refused |"
    return ["## Calibrations that hold what they state", "", head, "|---" * 6 + "|", *map(_row, kinds)]


def _row(kind: str) -> str:
    count = COUNT.get(kind, OTHERWISE)
    with ProcessPoolExecutor(PROCESSES) as pool:
        every = list(pool.map(_outcome, [kind] * count, range(SEEDS, SEEDS + count), chunksize=CHUNK))
    found = [one for one in every if one is not None]
    scores = np.concatenate([one.scores for one in found])
    held, inside = np.mean([one.held for one in found]), np.mean(np.abs(scores) <= 1.959964)
    scatter = np.sqrt(np.mean(scores**2))
    return (
        f"| {kind} | {len(found)} | {100 * held:.1f} % | {scatter:.2f} | {100 * inside:.1f} % | {count - len(found)} |"
    )


def _outcome(kind, seed):
    """None where the calibration was refused, with a sentence."""
    from calibore.errors import InputError

    try:
        return _cases().outcome(kind, seed)
    except InputError:
        return None


def _cases():
    if str(TESTS / "calibration") not in sys.path:
        sys.path.insert(0, str(TESTS / "calibration"))
    import calibration_coverage

    return calibration_coverage
