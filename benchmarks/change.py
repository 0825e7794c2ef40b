"""How small a change is found, beside py4dgeo's M3C2 and M3C2-EP: `python -m benchmarks change`.

`pip install -e .[peers]` brings the peer. Every method's threshold is set so that 5 % of unchanged pairs of surveys
show anything; then wear of several widths is put where it may be, and how deep it must be to be found there is asked of
every pair. `python -m benchmarks change 20` takes 20 pairs.
"""

import importlib.util
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from benchmarks.epochs import Epochs, Patch
from calibore.comparison import Difference, difference
from calibore.comparison._chance import thresholds
from calibore.comparison._smoothing import Smoother, windows_of
from calibore.scans import Profile

FALSE_ALARM = 0.05
EULER = 0.5772156649
DEPTHS = {0.005: (0.3e-3, 0.8e-3), 0.015: (0.1e-3, 0.3e-3), 0.04: (0.05e-3, 0.15e-3)}
"""m, by standard width [m] of the wear: at which significance is asked; it is linear in the depth."""
DEEPEST = 1e-3
"""m; what is not found then is not looked for."""
CYLINDERS = (0.008, 0.016, 0.032)
"""m, radii of M3C2."""
PROPAGATED = (0.016,)
PROPAGATED_PAIRS = 12
"""Of M3C2-EP, whose time is that of Python loops over points."""
OURS = "calibore"


class Signal(NamedTuple):
    """`significance` (p,) of growth over a method's own threshold, at `axial` [m], `clock` [rad] (p,)."""

    axial: np.ndarray
    clock: np.ndarray
    significance: np.ndarray

    def greatest(self, patch: Patch | None = None) -> float:
        """Anywhere of either sign, or of growth within a patch; 0 where nothing is known."""
        kept = np.isfinite(self.significance)
        if patch is None:
            return float(np.abs(self.significance[kept]).max(initial=0.0))
        return float(self.significance[kept & patch.holds(self.axial, self.clock)].max(initial=0.0))


Method = Callable[[Difference, Profile, Patch | None], Signal]


def report(pairs: str = "50") -> list[str]:
    """Markdown lines: false alarms and the smallest change found, a row per method."""
    every = [_outcome(seed) for seed in range(int(pairs))]
    names = list(every[0].alone)
    lines = [f"## Wear in a 300 mm pipe, {pairs} pairs of surveys without pictures", ""]
    if not _peer():
        lines += ["**py4dgeo is not installed: no peer below.** `pip install -e .[peers]` brings it.", ""]
    widths = " | ".join(f"{1e3 * width:g} mm wide: 50 %, 90 %" for width in DEPTHS)
    lines += [f"| method | pairs | alarms at its own threshold | threshold for 5 % | {widths} |", "|---" * 7 + "|"]
    for name in names:
        kept = [one for one in every if name in one.alone]
        alone = np.array([one.alone[name] for one in kept])
        limit = _quantile(alone)
        found = [np.quantile([one.depth(name, width, limit) for one in kept], (0.5, 0.9)) for width in DEPTHS]
        depths = " | ".join(f"{_said(half)}, {_said(most)} mm" for half, most in found)
        lines.append(f"| {name} | {alone.size} | {np.count_nonzero(alone > 1)} | {limit:.2f} x own | {depths} |")
    return lines


def _said(depth: float) -> str:
    return f"{1e3 * depth:.3f}" if depth <= DEEPEST else f"> {1e3 * DEEPEST:g}"


class Outcome(NamedTuple):
    """By method: greatest significance over its own threshold of the unchanged pair, `alone`, and by width of wear that
    within the patch, unchanged and for each depth, `worn`.
    """

    alone: dict[str, float]
    worn: dict[tuple[str, float], list[float]]

    def depth(self, method: str, width: float, limit: float) -> float:
        """m, from which it is found."""
        depths, seen = np.array([0.0, *DEPTHS[width]]), self.worn[method, width]
        piece = 0 if seen[1] >= limit else 1
        slope = (seen[piece + 1] - seen[piece]) / (depths[piece + 1] - depths[piece])
        found = depths[piece] + (limit - seen[piece]) / slope if slope > 0 else np.inf
        return float(np.clip(found, 0.0, 2 * DEEPEST))


def _outcome(seed: int) -> Outcome:
    epochs = Epochs(seed)
    unchanged = difference(epochs.unchanged, epochs.before)
    methods = {OURS: _ours(unchanged)} | (dict(_peers(seed)) if _peer() else {})
    alone = {name: method(unchanged, epochs.before, None).greatest() for name, method in methods.items()}
    worn = {}
    for width, depths in DEPTHS.items():
        patch = epochs.patch(width)
        several = [unchanged]
        for depth in depths:
            after = epochs.after(patch, depth)
            several.append(difference(after, epochs.before, start=unchanged.registration.motion, search=False))
        for name, method in methods.items():
            worn[name, width] = [method(one, epochs.before, patch).greatest(patch) for one in several]
    return Outcome(alone, worn)


def _ours(unchanged: Difference) -> Method:
    """As `changes` has it, with the thresholds of the unchanged pair: drawing them anew would take its time."""
    rng, smoother, windows = np.random.default_rng(0), Smoother.of(unchanged), windows_of(unchanged)
    limits = thresholds(unchanged, smoother, windows, false_alarm=FALSE_ALARM, rng=rng)

    def signal(found: Difference, _: Profile, __: Patch | None) -> Signal:
        smoother, strongest = Smoother.of(found), np.zeros(found.value.shape)
        for window, limit in limits.items():
            relative = np.nan_to_num(smoother.mean(found.adjusted, window) / smoother.u(window) / limit)
            strongest = np.where(np.abs(relative) > np.abs(strongest), relative, strongest)
        known = np.isfinite(found.adjusted)
        return Signal(found.axial[known], found.clock[known], strongest[known])

    return signal


def _quantile(maxima: np.ndarray) -> float:
    """That maxima of unchanged pairs exceed with the probability of a false alarm, by Gumbel's distribution."""
    spread = np.sqrt(6) / np.pi * maxima.std(ddof=1)
    return float(maxima.mean() - EULER * spread - spread * np.log(-np.log1p(-FALSE_ALARM)))


def _peer() -> bool:
    return importlib.util.find_spec("py4dgeo") is not None


def _peers(seed: int) -> Iterator[tuple[str, Method]]:
    from benchmarks.peers import m3c2

    def method(peer: Any, cylinder: float, *, freed: bool) -> Method:
        def signal(found: Difference, before: Profile, patch: Patch | None) -> Signal:
            clouds = m3c2.Clouds.of(found, before, freed=freed)
            within = None if patch is None else patch.holds(*clouds.after[:2])
            one = peer(clouds, cylinder=cylinder, within=within)
            return Signal(one.axial, one.clock, one.distance / one.level)

        return signal

    for cylinder in CYLINDERS:
        yield f"M3C2, {1e3 * cylinder:g} mm", method(m3c2.plain, cylinder, freed=False)
    for cylinder in CYLINDERS:
        yield f"M3C2, {1e3 * cylinder:g} mm, freed", method(m3c2.plain, cylinder, freed=True)
    if seed < PROPAGATED_PAIRS:
        for cylinder in PROPAGATED:
            yield f"M3C2-EP, {1e3 * cylinder:g} mm, freed", method(m3c2.propagated, cylinder, freed=True)
