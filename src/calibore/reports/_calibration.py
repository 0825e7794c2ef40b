"""`write_calibration_page`, `write_difference_page`: what a calibration means, and whether another one agrees."""

from pathlib import Path
from typing import Any

import numpy as np

from calibore.calibration import Calibration, Difference, Halves, wall_uncertainty
from calibore.plotting import (
    calibration_pictures,
    difference_pictures,
    known_rig,
    length_unit,
    nominal_radius_of,
    parameter_words,
    plain_text,
    shown_radii,
)
from calibore.reports._calibration_page import write_page
from calibore.reports._calibration_words import (
    Fact,
    calibration_facts,
    checked_halves,
    model_rows,
    parameter_rows,
    reader_unit,
)
from calibore.rigs import Rig

UNITS = "SI (m, rad) and px; standard uncertainties (k = 1)"


def write_calibration_page(
    calibration: Calibration, out: Path | str, *, nominal_radius: float | None = None, unit: str = "mm"
) -> Path:
    """`out`/calibration.html with all pictures and numbers (calibration.json) beside it, all or nothing; its path.

    On walls round `nominal_radius` [m], by default the middle of the radii that the calibration is valid for.
    """
    length_unit(unit)
    nominal_radius, rig = nominal_radius_of(calibration, nominal_radius), known_rig(calibration)
    checked = checked_halves(calibration, nominal_radius)
    u = dict(zip(calibration.covariance.names, calibration.covariance.u.tolist(), strict=True))
    words = {
        "title": f"Calibration: {calibration.kind.replace('-', ' ')}",
        "subtitle": f"{_count(calibration)}.",
        "facts": calibration_facts(calibration, rig, checked, nominal_radius=nominal_radius, unit=unit),
        "warnings": calibration.warnings,
        "sentences": [*calibration.findings, *_halves_sentence(checked, unit)],
        "parameters": parameter_rows(dict(calibration.values), dict(u), unit),
        "models": model_rows(calibration),
        "refused": [{"name": one.name, "reason": one.refused} for one in calibration.files if one.refused],
        "method": METHOD,
    }
    pictures = calibration_pictures(calibration, nominal_radius=nominal_radius, unit=unit)
    data = _data(calibration, rig, checked, nominal_radius)
    return write_page(out, "calibration", words=words, data=data, pictures=pictures)


def write_difference_page(difference: Difference, out: Path | str, *, unit: str = "mm") -> Path:
    """`out`/difference.html with all pictures and numbers (difference.json) beside it, all or nothing; its path."""
    words = {
        "title": "Two calibrations compared",
        "subtitle": "The second minus the first.",
        "facts": _difference_facts(difference, unit),
        "sentences": [difference.verdict(unit)],
        "changes": _change_rows(difference, unit),
        "method": DIFFERENCE_METHOD,
    }
    pictures = difference_pictures(difference, unit=unit)
    return write_page(out, "difference", words=words, data=_difference_data(difference), pictures=pictures)


METHOD = (
    "Uncertainty on the wall: the sensitivities of a radius to every parameter where camera ray and laser light meet, "
    "with the full covariance of the calibration. Uncertainty of directions: in pixels, after the best turn "
    "of the whole camera is taken out. Half against half: both halves of the pictures solved alone, in first order."
)
DIFFERENCE_METHOD = (
    "Directions are compared, so that lenses of different laws can be; the turn of the second camera that makes them "
    "agree best is taken out, weighted by how well they are known. On the wall, what the second rig makes of the "
    "pictures of the first; the shift that every ring's fitted centre takes up is left out. Chi-square is over the "
    "directions that the two covariances allow."
)


def _count(calibration: Calibration) -> str:
    used = sum(one.used for one in calibration.files)
    kept = int((calibration.observations.weight > 0).sum())
    return f"From {used} of {len(calibration.files)} files, {kept} residuals"


def _halves_sentence(checked: Halves | str | None, unit: str) -> list[str]:
    return [] if checked is None else [checked if isinstance(checked, str) else checked.verdict(unit)]


def _data(
    calibration: Calibration, rig: Rig | None, checked: Halves | str | None, nominal_radius: float | None
) -> dict[str, Any]:
    wall = None
    if rig is not None and nominal_radius is not None:
        radii = np.union1d(shown_radii(calibration.valid, nominal_radius), [nominal_radius])
        found = wall_uncertainty(rig, radii=radii)
        wall = {"radius": found.radius, "u": found.mean, "u_uncorrelated": found.mean_uncorrelated}
    half = None
    if isinstance(checked, Halves):
        half = {"rms_px": checked.rms, "expected_px": checked.expected, "p": checked.p, "parts": checked.parts}
    known = calibration.covariance
    return {
        "units": UNITS,
        "kind": calibration.kind,
        "nominal_radius": nominal_radius,
        "parameters": dict(calibration.values),
        "covariance": {"names": known.names, "matrix": known.matrix},
        "degrees_of_freedom": calibration.degrees_of_freedom,
        "noise": calibration.noise,
        "group_sigma": calibration.group_sigma,
        "unit_of_residuals": calibration.observations.unit,
        "wall": wall,
        "halves": half,
        "models": [
            {"model": one.model, "parameters": one.parameters, "rmse": one.rmse, "cross_validated": one.cross_validated,
             "aicc": one.aicc, "bic": one.bic, "remark": one.remark}
            for one in calibration.models
        ],
        "findings": calibration.findings,
        "warnings": calibration.warnings,
    }  # fmt: skip


def _difference_facts(difference: Difference, unit: str) -> list[Fact]:
    along, test = difference.directions, difference.judgement
    p = "p unknown" if np.isnan(test.p) else f"p = {plain_text(test.p, 2)}" if test.p >= 1e-3 else "p < 0.001"
    facts = [
        {"name": "By chance alone", "value": p, "remark": f"chi-square {plain_text(test.chi_square)} in "
         f"{test.directions} direction{'s' * (test.directions != 1)}"},
        {"name": "Over the image", "value": f"{plain_text(along.rms, 2)} px rms",
         "remark": f"{plain_text(along.expected, 2)} px expected"},
        {"name": "Turn taken out", "value": f"{plain_text(float(np.degrees(np.linalg.norm(along.turn))), 2)} deg",
         "remark": "of the whole camera"},
    ]  # fmt: skip
    wall, nominal = difference.wall, difference.nominal_radius
    if wall is not None and nominal is not None:
        scale, at = length_unit(unit), int(np.argmin(np.abs(wall.radius - nominal)))
        band = wall.coverage * wall.u_mean[at] / scale.metres
        facts.append(
            {
                "name": f"Mean radius at R = {nominal / scale.metres:.6g} {unit}",
                "value": f"{plain_text(wall.mean[at] / scale.metres, 2, sign=True)} {unit}",
                "remark": f"95 % of unchanged rigs stay within {plain_text(band, 2)} {unit}",
            }
        )
    return facts


def _change_rows(difference: Difference, unit: str) -> list[Fact]:
    rows = []
    for one in difference.changes:
        factor, symbol = reader_unit(one.name, length_unit(unit))
        rows.append(
            {
                "name": parameter_words(one.name),
                "before": plain_text(one.before * factor, 7),
                "after": plain_text(one.after * factor, 7),
                "change": plain_text(one.change * factor, 2, sign=True),
                "sigmas": f"{one.sigmas:+.1f}",
                "share": f"{100 * one.share:.0f} %",
                "unit": symbol,
            }
        )
    return rows


def _difference_data(difference: Difference) -> dict[str, Any]:
    along, wall = difference.directions, difference.wall
    return {
        "units": UNITS,
        "verdict": difference.verdict(),
        "p": difference.p,
        "chi_square": difference.judgement.chi_square,
        "identifiable_directions": difference.judgement.directions,
        "nominal_radius": difference.nominal_radius,
        "image": {"rms_px": along.rms, "expected_px": along.expected, "turn": along.turn, "u": along.u, "v": along.v,
                  "difference_px": along.difference, "sd_px": along.uncertainty.sd},
        "wall": None if wall is None else {
            "radius": wall.radius, "clock": wall.clock, "difference": wall.difference, "u": wall.u, "mean": wall.mean,
            "u_mean": wall.u_mean, "coverage": wall.coverage},
        "changes": [{**one._asdict(), "sigmas": one.sigmas} for one in difference.changes],
    }  # fmt: skip
