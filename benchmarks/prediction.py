"""Does the prediction hold? `python -m benchmarks prediction`: predicted against observed rms of the dissertation's six
instruments, with the calibration exact, and coverage with drift that the rig file states, or does not.
"""

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
COVERAGE_FACTOR = 1.96
OUTLIER = 0.15 * 0.0254
"""m, of the dissertation's rule (section 8.2)."""
DOUBTFUL = 3.0
"""Times the usual uncertainty of a ray, from which it is none of those that a designer thinks of."""
RESAMPLED = 1000
NOISE = 0.2
"""px, of lines drawn without pictures."""
Array = np.ndarray[Any, np.dtype[Any]]


def report(part: str = "all", stations: str = "24", draws: str = "128", without_pictures: str = "1024") -> list[str]:
    """Markdown lines of one `part` (exact, ahead, drift) or all: `stations` of a pipe, `draws` of an instrument."""
    sys.path.insert(0, str(TESTS / "properties"))
    parts = {
        "exact": lambda: exact(int(stations)),
        "ahead": lambda: ahead(int(stations) // 2),
        "drift": lambda: drift(int(draws), int(without_pictures)),
    }
    wanted = parts if part == "all" else [part]
    return [line for name in wanted for line in ["", *parts[name]()]]


def exact(stations: int) -> list[str]:
    """Observed over predicted rms, the rig file exact."""
    from known_instruments import beside_fold, instruments, walls

    head = "| instrument | pipe | sections | rms [mm] | observed / predicted | inside | share | observed / predicted "
    lines = ["## Calibration exact", "", f"{head}| > 0.15 in | all: observed / predicted | inside |"]
    lines += ["|---" * 11 + "|"]
    for name, rig in instruments().items():
        for pipe, wall in walls().items():
            sections = _sections(name, rig, wall, stations)
            error, u = (np.stack([getattr(one, key) for one in sections]) for key in ("error", "u"))
            away = np.stack([one.away for one in sections])
            if name.startswith("cone"):
                away &= ~beside_fold(name)
            lines.append(f"| {name} | {pipe} | {len(sections)} | {_exact_row(error, u, away)} |")
            print(lines[-1], file=sys.stderr)
    return lines


def _sections(name: str, rig: Any, wall: Any, stations: int) -> list[Any]:
    from known_instruments import head_sections, ring_section

    if not name.startswith("side"):
        return [ring_section(rig, wall, seed) for seed in range(stations)]
    with tempfile.TemporaryDirectory() as folder:
        sections = head_sections(rig, wall, 1, Path(folder), stations=4, clocks=max(stations // 4, 8))
    longest = max(one.error.size for one in sections)
    return [type(one)(*(_padded(values, longest) for values in one)) for one in sections]


def _padded(values: Array, count: int) -> Array:
    missing = count - values.size
    return np.concatenate([values, np.full(missing, False if values.dtype == bool else np.nan)])


def _exact_row(error: Array, u: Array, away: Array) -> str:
    seen = np.isfinite(error)
    usual = seen & (np.abs(error) <= OUTLIER)
    rms = 1e3 * np.sqrt(np.mean(error[away] ** 2))
    numbers = [f"{rms:.3f}", _ratio(error, u, away), _inside(error, u, away), f"{100 * away.sum() / seen.sum():.0f} %"]
    numbers += [_ratio(error, u, usual), f"{100 * (1 - usual.sum() / seen.sum()):.2f} %"]
    return " | ".join([*numbers, _ratio(error, u, seen), _inside(error, u, seen)])


def _ratio(error: Array, u: Array, counts: Array) -> str:
    """Rms of the error over rms of u, with its standard uncertainty by resampling sections."""
    squares = np.stack([np.sum(np.where(counts, values, 0.0) ** 2, axis=1) for values in (error, u)])
    drawn = np.random.default_rng(1).integers(0, error.shape[0], (RESAMPLED, error.shape[0]))
    several = np.sqrt(squares[0][drawn].sum(axis=1) / squares[1][drawn].sum(axis=1))
    return f"{np.sqrt(squares[0].sum() / squares[1].sum()):.3f} ± {several.std():.3f}"


def _inside(error: Array, u: Array, counts: Array) -> str:
    return f"{100 * np.mean(np.abs(error[counts]) <= COVERAGE_FACTOR * u[counts]):.1f} %"


def ahead(stations: int) -> list[str]:
    """Of single rays in a plain pipe: what `design` says before a rig is built, told the noise of its pictures only."""
    from known_instruments import RADIUS, SMOOTHED, instruments, ring_rays, strip, walls

    from calibore.design import predict_on_wall

    lines = ["## Before it is built", "", "| instrument | u of the line [px] | observed / predicted by design |"]
    lines += ["|---|---|---|"]
    plain = walls()["plain"]
    for name, rig in instruments().items():
        seen = strip if name.startswith("side") else ring_rays
        rows, noises = [], []
        for seed in range(stations):
            rays = seen(rig, plain, seed)
            noise = float(np.median(rays.u))
            said = predict_on_wall(rig, rays.clock, RADIUS, u_pixel=noise)
            counts = (said.margin >= SMOOTHED) & (rays.u <= DOUBTFUL * noise)
            kept = rays.error[counts], said.of_radius.independent[counts]
            rows.append([np.sum(values**2) for values in kept])
            noises.append(noise)
        squares = np.sqrt(np.array(rows))
        ratio = _ratio(squares[:, :1], squares[:, 1:], np.ones((stations, 1), dtype=bool))
        lines.append(f"| {name} | {np.mean(noises):.2f} | {ratio} |")
        print(lines[-1], file=sys.stderr)
    return lines


def drift(draws: int, without_pictures: int) -> list[str]:
    """Coverage where each true rig is the file plus a draw from the drift that the file states, or keeps silent of."""
    from drifting_instruments import drifted_points, drifted_section, drifting, true_rigs
    from known_instruments import instruments

    head = (
        "| instrument | draws | rms / u | inside, no [drift] | inside, with [drift] | draws without pictures | inside |"
    )
    lines = ["## Calibration exact, then drifted", "", head, "|---" * 7 + "|"]
    every: list[list[tuple[float, float]]] = [[], [], []]
    for number, (name, rig) in enumerate(instruments().items()):
        with tempfile.TemporaryDirectory() as folder:
            files = drifting(rig, Path(folder))
        rigs = true_rigs(files[1], draws, number)
        found = [drifted_section(true, *files, number * draws + seed) for seed, true in enumerate(rigs)]
        rng = np.random.default_rng([5, number])
        others = true_rigs(files[1], without_pictures, number)
        drawn = [tuple(drifted_points(true, files[1], rng, points=20, u_pixel=NOISE)) for true in others]
        cells = [[(error, u) for error, u, _ in found], [(error, u) for error, _, u in found], drawn]
        shares = [[_held(error, u) for error, u in cell] for cell in cells]
        for kept, more in zip(every, shares, strict=True):
            kept.extend(more)
        squares = np.array([[np.nansum(error**2), np.nansum(u**2)] for error, u in cells[1]])
        ratio = np.sqrt(squares[:, 0].sum() / squares[:, 1].sum())
        without, within, plain = map(_share, shares)
        lines.append(f"| {name} | {draws} | {ratio:.2f} | {without} | {within} | {without_pictures} | {plain} |")
        print(lines[-1], file=sys.stderr)
    without, within, plain = map(_share, every)
    return [*lines, f"| all | {len(every[0])} | | {without} | {within} | {len(every[2])} | {plain} |"]


def _held(error: Array, u: Array) -> tuple[float, float]:
    """(points inside, points) of one draw."""
    counts = np.isfinite(error)
    return float(np.sum(np.abs(error[counts]) <= COVERAGE_FACTOR * u[counts])), float(counts.sum())


def _share(held: list[tuple[float, float]]) -> str:
    """Share inside, with its standard uncertainty: points of one draw count as a cluster."""
    inside, count = np.array(held).T
    share = inside.sum() / count.sum()
    u = np.sqrt(np.sum((inside - share * count) ** 2)) / count.sum()
    return f"{100 * share:.1f} ± {100 * u:.1f} %"
