"""The experiment's tables: what the dissertation prints, and beside it what this program measures."""

from collections.abc import Iterator

import numpy as np

from calibore.experiment import (
    DRIFTED,
    EXACT,
    FRESH,
    INCH,
    TABLE_6_1,
    TABLE_8_2,
    TABLE_8_3,
    UNSTATED,
    LaserOutcome,
    Outcome,
)
from calibore.optics import LENS_LAWS
from calibore.reports._comparison_words import with_u
from calibore.reports._experiment_head import Table, head_table, in_situ_table
from calibore.uncertainty import Quantity

RINGS = np.arange(1.0, 12.0)
"""in; radii of the target's rings, at which pixels are turned into inches."""
RIG_FILES = {
    EXACT: "the rig itself",
    FRESH: "calibrated on the day",
    DRIFTED: "calibrated before it changed, [drift] stated",
    UNSTATED: "calibrated before it changed, not stated",
}


def experiment_tables(found: Outcome) -> Iterator[Table]:
    """In the order of the chapters; the answer's own first."""
    yield _held(found)
    if found.of_kind("plane"):
        yield _lenses(found)
    if found.of_kind("side"):
        yield head_table(found)
        yield in_situ_table(found)
    yield _conditioning(found)
    yield _worst_cases(found)


def _held(found: Outcome) -> Table:
    rows = []
    for laser in found.lasers:
        plain = laser.on_plain_wall
        rows.append(
            (
                laser.instrument.title,
                "the rig itself, away from edges",
                _inches(plain.rms),
                _inches(plain.predicted),
                f"{plain.rms / plain.predicted:.2f}",
                f"{plain.relative:.2f}",
                f"{100 * plain.inside:.1f} %",
                *("", "", ""),
            )
        )
        for variant, words in RIG_FILES.items():
            if variant in laser.by_truth:
                truth, touch = laser.by_truth[variant], laser.by_touch[variant]
                rows.append(
                    (
                        laser.instrument.title,
                        words,
                        _inches(truth.rms),
                        _inches(truth.predicted),
                        f"{truth.rms / truth.predicted:.2f}",
                        f"{truth.relative:.2f}",
                        f"{100 * truth.inside:.1f} %",
                        _inches(touch.rms),
                        f"{100 * touch.inside:.1f} %",
                        f"{truth.outliers}",
                    )
                )
    columns = (
        "Instrument", "Rig file", "rms [in]", "predicted rms [in]", "ratio", "rms of error / u", "inside 95 %",
        "rms, tactile [in]", "inside 95 %, tactile", "outliers",
    )  # fmt: skip
    note = (
        "Errors of every visible point against the truth, and against the tactile profile as chapter 8 has it; beyond "
        "0.15 in they are outliers. All points of a scan share one error of calibration: with it, the share inside "
        "says less than the number of points suggests. Texture of the wall, 0.0015 in here, counts as noise: where "
        "noise is small the stated uncertainty is a little too large."
    )
    return Table("held", "Does the predicted uncertainty hold?", note, columns, tuple(rows), 2)


def _lenses(found: Outcome) -> Table:
    rows = []
    for laser in found.of_kind("plane"):
        baseline, known = int(laser.instrument.baseline), found.calibrations[FRESH, laser.name]
        tried = {one.model: one for one in known.models}
        for law, theirs in TABLE_6_1.items():
            one, ours = theirs[baseline], tried.get(law)
            own = ("", "", "", "")
            if ours and "laser.baseline" in ours.estimates:
                D, k = ours.estimates["laser.baseline"], ours.estimates["camera.k"]
                rmse = ours.rmse * _inches_per_pixel(law, D.value / INCH, k.value)
                own = (_by(D, INCH), with_u(k), f"{rmse:.2g}", f"{ours.rmse:.2g}")
            rows.append((f"{baseline} in", law, f"{one.baseline:g}", f"{one.k:g}", f"{one.rmse:g}", *own))
    columns = (
        "Baseline", "Lens law", "D, published [in]", "k, published [px]", "rmse, published [in]", "D, ours [in]",
        "k, ours [px]", "rmse, ours [in]", "rmse, ours [px]",
    )  # fmt: skip
    note = (
        "Ours: one target per baseline, the lens a sine law with the published k, ± standard uncertainties. Of a "
        " perspective lens one photograph tells only D / k."
    )
    return Table("table_6_1", "Table 6.1: fitted curve parameters and errors", note, columns, tuple(rows), 2)


def _inches_per_pixel(law: str, baseline: float, k: float) -> float:
    """Root mean square over the rings; both lengths in inches."""
    ratio = LENS_LAWS[law].ratio
    step = 1e-4
    pixels = [k * np.asarray(ratio(np.arctan((RINGS + sign * step) / baseline))) for sign in (1, -1)]
    return float(np.sqrt(np.mean((2 * step / (pixels[0] - pixels[1])) ** 2)))


def _conditioning(found: Outcome) -> Table:
    rows = []
    for laser in found.lasers:
        theirs, ours = TABLE_8_2.get(laser.name), laser.registration
        if theirs is None or laser.scale is None:
            continue
        scale = "curve fit" if theirs.scale is None else f"{theirs.scale:g}"
        motion = ours.motion
        rows.append(
            (
                laser.instrument.title,
                f"{theirs.roll:g}",
                with_u(Quantity(float(np.degrees(motion.roll)), float(np.degrees(ours.u("roll"))))),
                f"{theirs.shift_x:g}",
                with_u(Quantity(motion.shift_x / INCH, ours.u("shift_x") / INCH)),
                f"{theirs.shift_y:g}",
                with_u(Quantity(-motion.shift_y / INCH, ours.u("shift_y") / INCH)),
                scale,
                with_u(laser.scale),
            )
        )
    columns = (
        "Instrument", "roll, published [deg]", "ours", "x, published [in]", "ours", "up, published [in]", "ours",
        "scale, published", "ours",
    )  # fmt: skip
    note = (
        "The published values are what the rigs truly had here; ours were found by registration onto the tactile "
        "profile, by no hand, ± standard uncertainties: roll and shifts with the day's calibration, scale with the rig "
        "file that is out of date."
    )
    return Table("table_8_2", "Table 8.2: conditioning performed by profile", note, columns, tuple(rows))


def _worst_cases(found: Outcome) -> Table:
    rows = []
    for laser in found.lasers:
        theirs = TABLE_8_3.get(laser.name)
        if theirs is not None:
            rows.append(_worst_case(laser, f"{theirs.predicted:g}", f"{theirs.worst_case:g}"))
        else:
            rows.append(_worst_case(laser, "", ""))
    columns = (
        "Instrument", "predicted, published [in]", "worst case, published [in]", "predicted, ours [in]",
        "rms, ours [in]", "s of |error|, ours [in]", "worst case, ours [in]",
    )  # fmt: skip
    note = (
        "Theirs: predicted for the worst case; worst case = rms + standard deviation of the absolute errors. Ours: the "
        "rms of the stated uncertainties, rig files exact, errors against the tactile profile."
    )
    return Table("table_8_3", "Table 8.3 and 8.4.3: predicted uncertainty and worst case", note, columns, tuple(rows))


def _worst_case(laser: LaserOutcome, predicted: str, worst: str) -> tuple[str, ...]:
    one = laser.by_touch[EXACT]
    ours = (one.predicted, one.rms, one.spread, one.worst_case)
    return (laser.instrument.title, predicted, worst, *(_inches(value) for value in ours))


def _inches(metres: float) -> str:
    return f"{metres / INCH:.4f}"


def _by(one: Quantity, unit: float) -> str:
    return with_u(Quantity(one.value / unit, one.u / unit))
