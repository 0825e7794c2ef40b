"""What `calibore calibrate` prints of a calibration: parameters, models compared, findings, files."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from calibore.cli._failure import wrong_usage
from calibore.cli._profile import as_json
from calibore.errors import InputError

if TYPE_CHECKING:
    from calibore.calibration import Calibration, Comparison
    from calibore.uncertainty import Quantity

METRES = {"mm": 1e-3, "in": 0.0254}
DEGREE = math.pi / 180
NAMED = 6
"""Files that are named for one reason; --json names all."""


def check_unit(unit: str) -> None:
    with wrong_usage():
        if unit not in METRES:
            raise InputError(f'Unit "{unit}" is not known; use "mm" or "in".')


def tell(found: "Calibration", out: Path, *, unit: str, json: bool) -> None:
    """What was found, in words and numbers or all of it as JSON; warnings on standard error."""
    for warning in found.warnings:
        typer.echo(f"Warning: {warning}", err=True)
    if json:
        typer.echo(as_json(plain(found, out)))
        return
    for line in result_lines(found, unit):
        typer.echo(line)
    typer.echo(f"\nCalibration: {out}")


def said_in(unit: str, length: str) -> tuple[str, float]:
    """The unit in which people read a value given in `unit` of a file, lengths in `length`; and its size."""
    if unit.split("/")[0] == "m":
        return unit.replace("m", length, 1), METRES[length]
    return ("deg", DEGREE) if unit == "rad" else (unit, 1.0)


def digits_for(u: float) -> int:
    """Decimal places that show two digits of `u`."""
    return max(0, 1 - math.floor(math.log10(u))) if 0 < u < math.inf else 4


def significant(value: float) -> str:
    """Three digits, without an exponent; "not seen" where there is no value."""
    return "not seen" if math.isnan(value) else f"{value:.{digits_for(abs(value)) + 1}f}"


def parameter_rows(calibration: "Calibration", length: str) -> Iterator[tuple[str, ...]]:
    """Name, value, u, unit of every parameter."""
    from calibore.calibration import unit_of_parameter

    for (name, value), u in zip(calibration.values.items(), calibration.covariance.u.tolist(), strict=True):
        unit, size = said_in(unit_of_parameter(name), length)
        digits = digits_for(u / size)
        yield name, f"{value / size:.{digits}f}", f"{u / size:.{digits}f}", unit


def model_rows(models: Sequence["Comparison"], length: str) -> Iterator[tuple[str, ...]]:
    """A heading, then one row per model: how well it fits, and what it says of parameters that most of them have."""
    from calibore.calibration import unit_of_parameter

    told = Counter(name for model in models for name in model.estimates)
    names = [name for name, count in told.items() if 2 * count >= len(models)]
    heads = [f"{name} [{said_in(unit_of_parameter(name), length)[0] or '1'}]" for name in names]
    unit, size = said_in(models[0].unit, length)
    yield ("model", "parameters", f"rmse [{unit}]", "dAICc", "dBIC", "cross-validated", *heads, "")
    for one in models:
        values = [_estimate(one.estimates.get(name), said_in(unit_of_parameter(name), length)[1]) for name in names]
        fits = (one.rmse / size, one.cross_validated / size)
        yield (
            one.model,
            str(one.parameters),
            _number(fits[0], 4),
            _number(one.aicc, 1),
            _number(one.bic, 1),
            _number(fits[1], 4),
            *values,
            one.remark,
        )


def _estimate(quantity: "Quantity | None", size: float) -> str:
    if quantity is None or not math.isfinite(quantity.value):
        return "-"
    if not math.isfinite(quantity.u):
        return "not told"
    digits = digits_for(quantity.u / size)
    return f"{quantity.value / size:.{digits}f} +- {quantity.u / size:.{digits}f}"


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def aligned(rows: Iterable[Sequence[str]], *, left: int = 1) -> Iterator[str]:
    """Rows of cells as lines, the first `left` and the last column to the left, numbers to the right."""
    table = [list(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    last = len(widths) - 1
    for row in table:
        cells = [
            cell.ljust(width) if i < left or i == last else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  " + "  ".join(cells).rstrip()


def result_lines(calibration: "Calibration", length: str) -> Iterator[str]:
    """What a calibration found: findings first, then the numbers, then files not used."""
    yield from calibration.findings
    yield from ("", f"Parameters of this {calibration.kind} calibration, with standard uncertainty u:")
    yield from aligned([("", "value", "u", ""), *parameter_rows(calibration, length)])
    freedom = calibration.degrees_of_freedom
    yield f"  (degrees of freedom {_number(freedom, 1) if math.isfinite(freedom) else 'not limited'})"
    if calibration.valid and calibration.valid.said(length):
        yield f"  valid: {calibration.valid.said(length)}"
    if calibration.models:
        yield from ("", "Models compared:", *aligned(model_rows(calibration.models, length)))
    yield from _not_used(calibration)


def _not_used(calibration: "Calibration") -> Iterator[str]:
    """Files refused, each with its reason, then in a line per reason those that were merely not needed."""
    refused = {file.name: file.refused for file in calibration.files if file.refused}
    aside = {file.name: file.set_aside for file in calibration.files if file.set_aside}
    if refused:
        yield from ("", f"Not used, {len(refused)} of {len(calibration.files)} files:")
        yield from (f"  {names}: {reason}" for reason, names in _by_reason(refused))
    if aside:
        yield ""
        yield from (f"Set aside: {names}: {reason}" for reason, names in _by_reason(aside))


def _by_reason(reasons: dict[str, str]) -> Iterator[tuple[str, str]]:
    """Every reason and the names of the files it holds for."""
    for reason in dict.fromkeys(reasons.values()):
        names = [name for name, one in reasons.items() if one == reason]
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        yield reason, f"{', '.join(names[:NAMED])}{more}"


def plain(calibration: "Calibration", out: Path) -> dict[str, Any]:
    """Everything of a calibration but the single residuals, SI or px."""
    from dataclasses import asdict

    from calibore.calibration import unit_of_parameter

    known = zip(calibration.values.items(), calibration.covariance.u.tolist(), strict=True)
    observations, valid = calibration.observations, calibration.valid
    return {
        "file": str(out),
        "kind": calibration.kind,
        "parameters": [
            {"name": name, "value": float(value), "u": u, "unit": unit_of_parameter(name)} for (name, value), u in known
        ],
        "covariance": calibration.covariance.matrix.tolist(),
        "degrees_of_freedom": float(calibration.degrees_of_freedom),
        "noise": float(calibration.noise),
        "group_sigma": float(calibration.group_sigma),
        "residuals": {"count": observations.residual.size, "unit": observations.unit},
        "valid": valid and {"zenith_rad": valid.zenith, "radius_m": valid.radius},
        "models": [asdict(model) for model in calibration.models],
        "findings": list(calibration.findings),
        "warnings": list(calibration.warnings),
        "files": [asdict(file) for file in calibration.files],
        "settings": {name: dict(table) for name, table in calibration.settings.items()},
    }
