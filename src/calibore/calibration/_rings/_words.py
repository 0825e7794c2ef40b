"""What ring photographs tell, and what they do not, in sentences."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rings._choice import BASELINE, DETERMINED, SCALE
from calibore.calibration._rings._model import target_names
from calibore.calibration._rings._pictures import RingPictures
from calibore.calibration._rings._result import Outcome, valid_region
from calibore.errors import InputError

Array = NDArray[np.float64]

CONFUSED = 0.99
"""Correlation of k and D above which people are warned."""
MISFIT = 2.0
"""px: no lens misses rings of its target by so much, though it was fitted without them."""
MANY_LEFT_OUT = 0.05


def check(outcome: Outcome, pictures: RingPictures) -> None:
    """Raises InputError where the photographs do not tell what a calibration needs, saying what would."""
    chosen = outcome.chosen
    if chosen.rms > MISFIT:
        raise InputError(
            f"{pictures.toml}: no lens model describes the rings; the likeliest, {chosen.lens.name}, misses rings "
            f"left out of the fit by {chosen.rms:.1f} px. Check that the target has {pictures.target.rings} evenly "
            f"spaced rings and {pictures.target.spokes} spokes, all of them dark lines, lies flat, and "
            "that ring_spacing is right."
        )
    if chosen.lens.law == "perspective" and not chosen.lens.extras:
        raise InputError(
            f"{pictures.toml}: the lens images like a perspective lens, of which rings tell D / k only "
            f"({_ratio(outcome, pictures)}), neither D nor k; photograph a chessboard at several tilts instead, or "
            "state the distance by nominal_baseline and u_baseline."
        )
    doubt = max(outcome.value(name).u / abs(outcome.value(name).value) for name in (BASELINE, SCALE))
    if doubt > DETERMINED:
        raise InputError(f"{pictures.toml}: {_confused(outcome, pictures, doubt)}")


def findings(outcome: Outcome, pictures: RingPictures) -> Iterator[str]:
    yield _recommendation(outcome, pictures)
    yield _estimates(outcome, pictures)
    yield _why(outcome)
    yield _seen(outcome, pictures)
    yield _lines(outcome, pictures)
    free = [trial for trial in outcome.trials if len(trial.lens.parameters) > 2 and trial.lens.law == "polynomial"]
    if free:
        u = free[-1].ring_fit.u(BASELINE)
        yield (
            f"D rests on the lens law: a {free[-1].lens.name}, which assumes none, leaves it open to "
            f"u = {pictures.unit.said(u, u)}."
        )
    for number in range(1, len(outcome.ring_fit.model.marks)):
        yield _other_picture(outcome, pictures, number)
    yield (
        "As a rig file it takes the light to stand exactly where the target stood, straight across the camera's axis. "
        "Where the laser is mounted by itself, give the file as lens_file to `calibore calibrate rig`."
    )
    yield "It does not matter whether the target was turned or mirrored: rings and spokes are counted as they are seen."


def warnings(outcome: Outcome, pictures: RingPictures) -> Iterator[str]:
    refused = [file for file in pictures.files if file.refused]
    for file in refused:
        yield f"{file.name} was not used: {file.refused}"
    correlation = outcome.ring_fit.correlation(SCALE, BASELINE)
    if abs(correlation) > CONFUSED:
        yield _hardly(outcome, pictures, correlation)
    if outcome.rivals:
        rivals = ", ".join(f"{name} ({weight:.0%})" for name, weight in outcome.rivals.items())
        yield (
            f"The pictures do not rule out other lens laws as simple: {rivals}. The stated covariance holds that "
            "doubt; photograph the target from nearer, so that it fills a wider view."
        )
    left_out = 1 - float(np.mean(outcome.ring_fit.fit.weights > 0))
    if left_out > MANY_LEFT_OUT:
        yield f"{left_out:.0%} of the stretches of lines disagree with the others and are left out; look at the target."


def _recommendation(outcome: Outcome, pictures: RingPictures) -> str:
    chosen = outcome.chosen
    count = len(chosen.lens.parameters)
    length = _on_target(outcome, chosen.rms)
    return (
        f"Recommended lens: {chosen.lens.name}, the simplest ({count} parameter{'s' * (count > 1)}) that predicts "
        f"rings left out of the fit as well as any: to {chosen.rms:.4f} px rms, "
        f"{pictures.unit.said(length, length)} on the target (sectors left out: {chosen.sectors:.4f} px)."
    )


def _estimates(outcome: Outcome, pictures: RingPictures) -> str:
    k, distance = outcome.value(SCALE), outcome.value(BASELINE)
    unit = pictures.unit
    correlation = outcome.ring_fit.correlation(SCALE, BASELINE)
    return (
        f"k = {_with_digits(k.value, k.u)} px (u {k.u:.2g} px), D = {unit.said(distance.value, distance.u)} "
        f"(u {unit.said(distance.u, distance.u)}), correlation {correlation:.3f}."
    )


def _why(outcome: Outcome) -> str:
    chosen = outcome.chosen
    richer = [trial for trial in outcome.trials if len(trial.lens.parameters) > len(chosen.lens.parameters)]
    alike = [trial for trial in outcome.trials if len(trial.lens.parameters) <= len(chosen.lens.parameters)]
    parts = []
    if richer:
        best = min(richer, key=lambda trial: trial.rms)
        parts.append(f"{best.lens.name} with {len(best.lens.parameters)} parameters predicts to {best.rms:.4f} px")
    others = [trial for trial in alike if trial is not chosen]
    if others:
        best = min(others, key=lambda trial: trial.rms)
        parts.append(f"the next as simple, {best.lens.name}, to {best.rms:.4f} px")
    return f"Others: {'; '.join(parts)}." if parts else "No other lens was tried."


def _seen(outcome: Outcome, pictures: RingPictures) -> str:
    marks = outcome.ring_fit.model.marks
    rings = sorted({int(ring) for one in marks for ring in np.unique(one.ring[one.ring > 0])})
    missing = sorted(set(range(1, pictures.target.rings + 1)) - set(rings))
    lost = f" (not measured: {', '.join(map(str, missing))})" if missing else ""
    count = sum(one.u.size for one in pictures.marks)
    photographs = "1 photograph" if len(marks) == 1 else f"{len(marks)} photographs"
    region = valid_region(outcome)
    assert region.zenith is not None
    return (
        f"{count} marks on {len(rings)} rings{lost} and {pictures.target.spokes} spokes of {photographs}, condensed to "
        f"{outcome.sight.line.size} stretches of lines; they cover zenith 0 to {np.degrees(region.zenith[1]):.1f} deg."
    )


def _lines(outcome: Outcome, pictures: RingPictures) -> str:
    """What rings deviate by as a whole: their print, neighbouring lines, the finder."""
    fit, sight = outcome.ring_fit.fit, outcome.sight
    used = (fit.weights > 0) & sight.on_ring
    rings = np.unique(sight.line[used])
    means = np.array([fit.residuals[used & (sight.line == ring)].mean() for ring in rings])
    worst = int(np.argmax(np.abs(means)))
    length = _on_target(outcome, float(abs(means[worst])), ring=int(rings[worst]))
    if outcome.ring_fit.of_print:
        shared = pictures.unit.said(fit.group_sigma, fit.group_sigma)
        return (
            f"The printed radii scatter by {shared} about the stated ones, as the marks tell; ring {rings[worst]} is "
            f"farthest off, by {pictures.unit.said(length, length)}. Measure the rings and state u_ring, or print anew."
        )
    return (
        f"What all marks of a ring share (its print, the lines beside it, the finder) scatters by "
        f"{fit.group_sigma:.4f} px, a stretch by itself by {fit.noise:.4f} px; ring {rings[worst]} is farthest off, "
        f"{means[worst]:+.4f} px ({pictures.unit.said(length, length)})."
    )


def _other_picture(outcome: Outcome, pictures: RingPictures, number: int) -> str:
    name = target_names(number)[0]
    value, u = outcome.ring_fit.fit.value(name), outcome.ring_fit.u(name)
    file = pictures.files[pictures.used[number]].name
    return f"In {file} the target stood at {pictures.unit.said(value, u)} (u {pictures.unit.said(u, u)})."


def _hardly(outcome: Outcome, pictures: RingPictures, correlation: float) -> str:
    return (
        f"k and D can hardly be told apart (correlation {correlation:.4f}): {_narrow(outcome, pictures)} Use them "
        "together only, with their covariance."
    )


def _confused(outcome: Outcome, pictures: RingPictures, doubt: float) -> str:
    correlation = outcome.ring_fit.correlation(SCALE, BASELINE)
    if outcome.chosen.lens.extras:
        return (
            f"no simple lens law fits, and with {outcome.chosen.lens.name} k and D cannot be told apart "
            f"(correlation {correlation:.4f}, u {doubt:.0%}): {_narrow(outcome, pictures)} Or "
            "measure how far the entrance pupil is from the target and state it by nominal_baseline and u_baseline."
        )
    rivals = f" Other lens laws fit as well: {', '.join(outcome.rivals)}." if outcome.rivals else ""
    told = f"k and D cannot be told apart (correlation {correlation:.4f}, u {doubt:.0%})"
    return f"{told}: {_narrow(outcome, pictures)}{rivals}"


def _narrow(outcome: Outcome, pictures: RingPictures) -> str:
    region = valid_region(outcome)
    assert region.zenith is not None
    near = pictures.radii[-1] / 2
    return (
        f"rings cover zenith 0-{np.degrees(region.zenith[1]):.0f} deg only; photograph the target from nearer than "
        f"{near / pictures.unit.size:.3g} {pictures.unit.symbol}."
    )


def _ratio(outcome: Outcome, pictures: RingPictures) -> str:
    ratio = outcome.value(BASELINE).value / outcome.value(SCALE).value
    return f"{ratio / pictures.unit.size:.6g} {pictures.unit.symbol}/px"


def _on_target(outcome: Outcome, pixels: float, *, ring: int | None = None) -> float:
    """Length [m] on the target of so many pixels across a `ring`, or across a typical one."""
    scale = np.abs(outcome.ring_fit.model.pixels_per_metre(outcome.ring_fit.fit.values))
    mine = outcome.sight.line == ring if ring else outcome.sight.on_ring
    return float(pixels * np.sqrt(np.mean(scale[mine] ** -2.0)))


def _with_digits(value: float, u: float) -> str:
    return f"{value:.{max(0, 1 - int(np.floor(np.log10(u))))}f}"
