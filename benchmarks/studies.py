"""Studies too long for the tests, on the tests' random pipes: `python -m benchmarks coverage` and `ovality`."""

import sys
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
COVERAGE_FACTOR = 1.96
MEASURABLE = 0.05
"""Signal from which a point counts (data README)."""
DEFINITIONS = ("ovality_f1216_max", "ovality_f1216_min", "ovality_range", "ovality_harmonic")


def coverage(exact_rigs: int = 300, drawn_rigs: int = 400) -> list[str]:
    """Markdown lines: how often intervals hold the truth over many rigs."""
    sys.path.insert(0, str(TESTS / "properties"))
    from random_rigs import one_ring

    rows = ["| rig file | rigs | inside 1.96 u | rms error / u | missed | points |", "|---|---|---|---|---|---|"]
    for name, count, exact in (("exact", exact_rigs, True), ("wrong by a draw, features", drawn_rigs, False)):
        z, missed, wanted = [], 0, 0
        for seed in range(count):
            ring, truth, _ = one_ring(seed, exact=exact, features=not exact)
            common = 0.0 if exact else np.sqrt(np.sum(ring.modes**2, axis=0))
            want = truth.visible & (truth.signal > MEASURABLE)
            got = want & np.isfinite(ring.radius)
            z.append(((ring.radius - truth.radius) / np.hypot(ring.u, common))[got])
            missed, wanted = missed + int((want & ~got).sum()), wanted + int(want.sum())
        every = np.concatenate(z)
        inside = 100 * np.mean(np.abs(every) <= COVERAGE_FACTOR)
        rms, lost = np.sqrt(np.mean(every[np.abs(every) < 6] ** 2)), 100 * missed / wanted
        rows.append(f"| {name} | {count} | {inside:.1f} % | {rms:.2f} | {lost:.2f} % | {every.size} |")
    return ["## Coverage over random rigs", *rows]


def ovality(rings: int = 250, featured: int = 200) -> list[str]:
    """Markdown lines: the tables of docs/explanation/ovality-bias.md."""
    sys.path.insert(0, str(TESTS / "metrics"))
    head = "| noise (% R) | ovality | definition | raw bias | corrected | mean u | held |"
    lines = [head, "|---|---|---|---|---|---|---|"]
    for noise in (0.001, 0.005):
        for kind in ("white", "correlated"):
            for spread in (0.0, 0.5, 2.0, 5.0):
                rows = _bias(f"{100 * noise:g} {kind}", spread, rings, noise=noise, kind=kind)
                lines += rows if spread == 0 else [row for row in rows if "range" in row or "harmonic" in row]
    for kind in ("white", "correlated"):
        lines += _bias(f"0.5 {kind}, 1500 points", 0.0, 100, noise=0.005, kind=kind, count=1500)
    lines += ["", "| case | noise (% R) | quantity | corrected bias | mean u | held |", "|---|---|---|---|---|---|"]
    dent = {"dent": True, "spread": 1.0, "offset": 0.1}
    for noise, kind in ((0.001, "white"), (0.005, "white"), (0.001, "correlated")):
        lines += _feature("dent, 1 % oval, 0.1 R off centre", featured, noise=noise, kind=kind, **dent)
    rail = {"rail": True, "spread": 2.0, "offset": 0.1}
    return lines + _feature("rail, 2 % oval, 0.1 R off centre", featured, noise=0.001, kind="white", **rail)


def _bias(label: str, spread: float, rings: int, **case) -> list[str]:
    from metrics_rings import NOMINAL, random_ring

    from calibore import metrics

    rng, rows = np.random.default_rng(20 + rings), []
    for _ in range(rings):
        ring, truth = random_ring(rng, spread=spread, **case)
        half = ring.radius.size // 2
        diameters = ring.radius[:half] + ring.radius[half:]
        found = metrics.ring_quantities(ring, nominal_radius=NOMINAL)
        rows.append([_errors(getattr(metrics, n)(diameters), getattr(found, n), truth[n]) for n in DEFINITIONS])
    lines = []
    for name, (raw, error, u) in zip(DEFINITIONS, np.array(rows).transpose(1, 2, 0), strict=True):
        numbers = f"{raw.mean():+.3f} | {error.mean():+.3f} | {u.mean():.3f} | {_held(error, u)}"
        lines.append(f"| {label} | {spread:g} % | {_short(name)} | {numbers} |")
    return lines


def _errors(raw, found, true) -> tuple[float, float, float]:
    return float(raw) - true, found.value - true, found.u


def _feature(label: str, rings: int, *, noise: float, kind: str, **case) -> list[str]:
    from metrics_rings import NOMINAL, random_ring

    from calibore.metrics import ring_quantities

    rng, lines = np.random.default_rng(20 + rings), []
    results = []
    for _ in range(rings):
        ring, truth = random_ring(rng, noise=noise, kind=kind, **case)
        results.append((ring_quantities(ring, nominal_radius=NOMINAL), truth))
    for name in ("diameter_min", "diameter_max"):
        error = np.array([getattr(found, name).value - truth[name] for found, truth in results]) * 50 / NOMINAL
        u = np.array([getattr(found, name).u for found, _ in results]) * 50 / NOMINAL
        numbers = f"{error.mean():+.3f} | {u.mean():.3f} | {_held(error, u)}"
        lines.append(f"| {label} | {100 * noise:g} {kind} | {name} | {numbers} |")
    return lines


def _held(error: np.ndarray, u: np.ndarray) -> str:
    return f"{100 * np.mean(np.abs(error) <= COVERAGE_FACTOR * u):.1f} %"


def _short(name: str) -> str:
    return name.removeprefix("ovality_").replace("f1216_", "F1216 ")
