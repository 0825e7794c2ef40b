"""What the page of a calibration says in numbers and words."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from calibore.calibration import (
    Calibration,
    Halves,
    halves,
    projection_uncertainty,
    unit_of_parameter,
    wall_uncertainty,
)
from calibore.errors import InputError
from calibore.plotting import COVERAGE_FACTOR, LengthUnit, length_unit, parameter_words, plain_text
from calibore.rigs import Rig

Fact = dict[str, str]


def checked_halves(calibration: Calibration, nominal_radius: float | None) -> Halves | str | None:
    """Half of the pictures against the other; why that cannot be, in a sentence; None where there is no camera."""
    if calibration.camera is None and calibration.rig is None:
        return None
    try:
        return halves(calibration, nominal_radius=nominal_radius)
    except InputError as error:
        return str(error)


def calibration_facts(
    calibration: Calibration, rig: Rig | None, checked: Halves | str | None, *, nominal_radius: float | None, unit: str
) -> list[Fact]:
    """The numbers on top of the page."""
    scale = length_unit(unit)
    return [
        *_wall_fact(rig, nominal_radius, scale),
        *_direction_fact(calibration),
        *_halves_fact(checked),
        *_noise_fact(calibration, scale),
        *_valid_fact(calibration, unit),
    ]


def parameter_rows(values: dict[str, float], u: dict[str, float | None], unit: str) -> list[Fact]:
    """Parameters with their standard uncertainties, lengths in `unit`, angles in degrees."""
    rows = []
    for name, value in values.items():
        factor, symbol = reader_unit(name, length_unit(unit))
        known = u.get(name)
        decimals = 6 if not known or not known * factor > 0 else max(0, 1 - int(np.floor(np.log10(known * factor))))
        rows.append(
            {
                "name": parameter_words(name),
                "value": f"{value * factor:.{min(decimals, 12)}f}",
                "u": "not stated" if known is None else plain_text(known * factor, 2),
                "unit": symbol,
            }
        )
    return rows


def reader_unit(name: str, scale: LengthUnit) -> tuple[float, str]:
    """Factor from SI, and symbol, of the parameter `name`."""
    unit = unit_of_parameter(name)
    if unit == "m":
        return 1 / scale.metres, scale.symbol
    return (float(np.degrees(1.0)), "deg") if unit == "rad" else (1.0, unit)


def model_rows(calibration: Calibration) -> list[Fact]:
    best = min((one.bic for one in calibration.models if isfinite(one.bic)), default=0.0)
    first = min((one.aicc for one in calibration.models if isfinite(one.aicc)), default=0.0)
    return [
        {
            "model": one.model,
            "parameters": str(one.parameters),
            "rmse": f"{one.rmse:.4g} {one.unit}",
            "cross": f"{one.cross_validated:.4g} {one.unit}" if isfinite(one.cross_validated) else "-",
            "aicc": f"{one.aicc - first:.1f}",
            "bic": f"{one.bic - best:.1f}",
            "remark": one.remark,
        }
        for one in calibration.models
    ]


def _wall_fact(rig: Rig | None, nominal_radius: float | None, scale: LengthUnit) -> Iterator[Fact]:
    if rig is None or nominal_radius is None:
        return
    found = wall_uncertainty(rig, radii=[nominal_radius])
    true, alone = (COVERAGE_FACTOR * float(a[0]) for a in (found.mean, found.mean_uncorrelated))
    where = f"U (k = {COVERAGE_FACTOR:g}) at R = {nominal_radius / scale.metres:.4g} {scale.symbol}"
    if not isfinite(true):
        yield _fact(where, "not seen", "the rig does not see this wall")
        return
    remark = f"{plain_text(alone / scale.metres, 2)} {scale.symbol} if correlations were ignored"
    yield _fact(where, f"{plain_text(true / scale.metres, 2)} {scale.symbol}", remark)


def _direction_fact(calibration: Calibration) -> Iterator[Fact]:
    camera = calibration.rig.camera if calibration.rig else calibration.camera
    if camera is None or not set(calibration.covariance.names) & set(camera.parameter_names):
        return
    from calibore.plotting import image_lattice

    grid = [a.ravel() for a in np.meshgrid(*image_lattice(camera, columns=40))]
    sd = projection_uncertainty(camera, calibration.covariance, *grid, valid=calibration.valid).sd
    direction = camera.unproject(*grid).direction
    zenith = np.arccos(np.clip(direction[:, 2], -1, 1))
    region = calibration.valid.zenith if calibration.valid else None
    inside = np.isfinite(sd) & (True if region is None else (zenith >= region[0]) & (zenith <= region[1]))
    if inside.any():
        middle, most = float(np.median(sd[inside])), float(sd[inside].max())
        yield _fact(
            "Directions known to",
            f"{plain_text(middle, 2)} px",
            f"{plain_text(most, 2)} px at worst in the valid region (k = 1)",
        )


def _halves_fact(checked: Halves | str | None) -> Iterator[Fact]:
    if isinstance(checked, Halves):
        yield _fact(
            "Half against half",
            f"{plain_text(checked.rms, 2)} px rms",
            f"{plain_text(checked.expected, 2)} px expected",
        )


def _noise_fact(calibration: Calibration, scale: LengthUnit) -> Iterator[Fact]:
    factor, symbol = (1 / scale.metres, scale.symbol) if calibration.observations.unit == "m" else (1.0, "px")
    symbol = symbol if calibration.observations.unit in ("m", "px") else calibration.observations.unit
    freedom = calibration.degrees_of_freedom
    shared = (
        f"{plain_text(calibration.group_sigma * factor, 2)} {symbol} shared by groups, "
        if calibration.group_sigma
        else ""
    )
    rests = f"{freedom:.0f} degrees of freedom" if isfinite(freedom) else "known beforehand"
    yield _fact("Noise of one residual", f"{plain_text(calibration.noise * factor, 2)} {symbol}", shared + rests)


def _valid_fact(calibration: Calibration, unit: str) -> Iterator[Fact]:
    if calibration.valid is not None and calibration.valid.said(unit):
        yield _fact("Valid for", calibration.valid.said(unit), "beyond it is extrapolation")


def _fact(name: str, value: str, remark: str) -> Fact:
    return {"name": name, "value": value, "remark": remark}
