"""What a calibration in the pipe tells people."""

from collections.abc import Iterable, Iterator

from calibore.calibration._calibration import Comparison
from calibore.calibration._in_situ._change import Change
from calibore.calibration._in_situ._file import ProfileTarget
from calibore.calibration._in_situ._fit import CLEARLY, InSitu
from calibore.calibration._in_situ._pose import SETTING, Aligned
from calibore.calibration._in_situ._wall import POSE
from calibore.calibration._in_words import DEGREE, Unit, probability, unit_of, word_of
from calibore.calibration._input_files import InputFile
from calibore.rigs import value_of

FEW = 0.5
"""Fraction of marks compared below which people should know."""


def in_situ_findings(found: InSitu, alignment: Aligned, unit: Unit) -> Iterator[str]:
    """The verdict, the table of changes (Swanbom 2007, Table 8.1), what explains them, and how the reference lies."""
    change = found.change
    chance = f"chi-square {change.chi_square:.1f} for {len(change.names)}, {probability(change.p)}"
    if change.tenable:
        yield f"The old calibration is still tenable ({chance}): keep it."
    else:
        yield f"The old calibration is no longer tenable ({chance}): use this one, and find out what has moved."
    yield from _table(change, unit)
    yield from _explained(found)
    if found.combined is not None:
        yield "The parameters written are those that the reference and the calibration in use agree on (prior = true)."
    yield _pose(found, unit)
    share = 100 * alignment.compared / alignment.marks
    yield (
        f"{alignment.compared} of {alignment.marks} marks ({share:.0f} %) fall on sound parts of the reference; radii "
        f"scatter by {unit.said(alignment.off, alignment.off)} about it."
    )


def _table(change: Change, unit: Unit) -> Iterator[str]:
    """One row per parameter: in use, found, changed by."""
    rows = zip(change.names, change.before, change.after, change.u_before, change.u_after, change.sigmas, strict=True)
    for name, before, after, u_before, u_after, sigmas in rows:
        one, word = unit_of(name, unit), word_of(name)
        per_cent = f" ({100 * (after - before) / before:+.2f} %)" if before else ""
        yield (
            f"{_first(word)}: in use {one.said(before, u_after)} ({_known(one, u_before)}), "
            f"found {one.said(after, u_after)} (u = {one.said(u_after, u_after)}): moved by "
            f"{one.said(after - before, u_after, sign=True)}{per_cent}, {abs(sigmas):.1f} standard uncertainties of "
            "both."
        )


def _first(word: str) -> str:
    """The `word` that begins a sentence, unless it is a symbol such as k."""
    return word if len(word) == 1 else word[:1].upper() + word[1:]


def _known(unit: Unit, u: float) -> str:
    return f"u = {unit.said(u, u)}" if u > 0 else "taken as exact"


def _explained(found: InSitu) -> Iterator[str]:
    """Which change alone would do."""
    single = [model for model in found.models if len(model.estimates) == 1]
    if found.change.tenable or len(single) < 2:
        return
    best, *rest = single
    alike = [one for one in rest if one.aicc - best.aicc < CLEARLY]
    whole = next((one for one in found.models if len(one.estimates) == len(found.change.names)), best)
    if best.aicc - whole.aicc > CLEARLY:
        yield f"No single parameter explains the change; {_single(best, found)} comes nearest."
    elif alike:
        others = " or ".join(_single(one, found) for one in alike)
        yield f"One change alone would explain it: {_single(best, found)}, or as well {others}."
    else:
        yield f"One change alone explains it, and best: {_single(best, found)}; the others need not have moved."


def _single(model: Comparison, found: InSitu) -> str:
    name, estimate = next(iter(model.estimates.items()))
    before = value_of(found.found.model.rig, name)
    return f"{word_of(name)} by {100 * (estimate.value - before) / before:+.2f} %"


def _pose(found: InSitu, unit: Unit) -> str:
    fit, reference = found.found.fit, found.found.model.settings[SETTING]
    start = dict(zip(POSE, getattr(reference, "pose", [0.0] * len(POSE)), strict=True))
    said = []
    for name, one in zip(POSE[:4], (DEGREE, unit, unit, unit), strict=True):
        index = fit.names.index(f"{SETTING}.{name}")
        value, u = start[name] + fit.values[index], float(fit.u[index])
        said.append(f"{name} {one.said(value, u, sign=True)} (u = {one.said(u, u)})")
    return f"The reference lies in the scan's frame turned and shifted by {', '.join(said)}."


def in_situ_warnings(found: InSitu, target: ProfileTarget, files: Iterable[InputFile]) -> Iterator[str]:
    if found.found.model.rig.default_uncertainty:
        yield (
            "The rig file states no uncertainty of the laser's place: 0.1 % of the nominal radius is assumed for the "
            "calibration in use, and everything it does not mention is taken as exactly known."
        )
    if found.untold:
        yield (
            f"The reference cannot tell {', '.join(map(word_of, found.untold))} beside the others, so it was held; a "
            "pipe with more different radii could."
        )
    fit = found.found.fit
    left_out = int((fit.weights == 0).sum())
    if left_out > (1 - FEW) * fit.weights.size:
        yield (
            f"{left_out} of {fit.weights.size} marks did not fit the reference and were left out; do both show the "
            "same stretch of pipe?"
        )
    refused = [file for file in files if file.refused]
    if refused:
        yield f"{len(refused)} pictures were not used; the first, {refused[0].name}: {refused[0].refused}."
