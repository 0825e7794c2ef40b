"""Calibration of a side-facing head by a flat target at known ranges (Swanbom 2007, section 7.4)."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration
from calibore.calibration._in_words import Unit
from calibore.calibration._rig._findings import observations_of, scatter_of, zeniths_of
from calibore.calibration._rig._fit import RigFit, fit_rig
from calibore.calibration._rig._line_pictures import Progress
from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._range_file import RangeTarget, read_range_target, starting_rig
from calibore.calibration._rig._range_findings import range_findings, range_warnings
from calibore.calibration._rig._range_pictures import LinePictures, find_lines
from calibore.calibration._rig._range_start import roughly
from calibore.calibration._rig._references import FlatTarget
from calibore.calibration._rig._stops import Suspect, without_wrong_stops
from calibore.errors import InputError
from calibore.rigs import Rig, ValidRegion, value_of, values_of
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
HEAD = ("laser.baseline", "laser.aim")
LEAN = "laser.lean"
FEWEST_STOPS = 3
SCATTERING = 2
"""Stops needed beyond the parameters to see how stops scatter."""
NARROWEST = 1.15
"""Farthest over nearest range below which all stops count as one."""
TELLING = 0.1
"""The baseline is told where its standard uncertainty is less than this fraction of it."""
LEAST_LEANING = 0.02
"""The sheet's lean is looked for where it can be told within this slope."""
BOUNDS = {"laser.baseline": (0.3, 3.0), "camera.k": (0.4, 2.5)}
"""Of the stated value; a fit that goes further is lost."""
WIDEST_TURN = np.radians(25.0)


def calibrate_range(path: Path | str, *, progress: Progress | None = None) -> Calibration:
    """A side-facing head from pictures of its line on a flat target; `path`: target.toml or its folder.

    Found are baseline, aim and k, and the sheet's lean where pictures tell it; with `lens_file` the camera's parameters
    are known before, and all that covariance goes in. Without, the principal point is held: on the sheet a shift of it
    is a change of the aim, which is thus the angle of the ray through the stated principal point. Offset and skew of
    the sheet are held at 0 by the choice of the head's axes, unless a rig file states their uncertainty. `progress`
    counts stops. Raises InputError where evidence is missing.
    """
    target = read_range_target(path)
    pictures = find_lines(target, channel=target.said.channel or "red", progress=progress)
    rig, known = starting_rig(target, pictures.size)
    refuse_other_way(pictures.looks)
    found = fit_range(rig, pictures.looks, known=known)
    found, wrong = without_wrong_stops(found, fewest=FEWEST_STOPS)
    return _calibration(target, pictures, found, wrong)


def fit_range(rig: Rig, looks: Iterable[Look], *, known: Covariance | None) -> RigFit:
    """The head that explains `looks` at a flat target; raises InputError where they tell too little."""
    looks = tuple(looks)
    free = free_parameters(rig, known)
    prior = known and known.restricted([name for name in free if name in known.names])
    refuse_too_few(looks, wanted=len(free) - (len(prior.names) if prior else 0))
    bounds = _bounds(rig, free)
    try:
        near = roughly(rig, looks, k_known=(prior is not None and "camera.k" in prior.names) or "camera.k" not in free)
        found = fit_rig(rig, looks, free=(*free, LEAN), prior=prior, bounds=bounds, near=near)
        if found.change(LEAN)[1] > LEAST_LEANING:
            found = fit_rig(rig, looks, free=free, prior=prior, bounds=bounds, near=near)
    except InputError as error:
        raise InputError(
            f"{str(error).rstrip('.')}. The head was looked for near baseline {1e3 * value_of(rig, HEAD[0]):.4g} mm, "
            f"aim {np.degrees(value_of(rig, HEAD[1])):.4g} deg, k {rig.camera.lens.k:.5g} px: check these, the lens "
            "law, range_step and the ranges in the pictures' names."
        ) from error
    baseline, u = value_of(found.rig, HEAD[0]), found.change(HEAD[0])[1]
    if u > TELLING * baseline:
        raise InputError(
            f"These stops do not tell baseline, aim and k apart: the baseline would be {1e3 * baseline:.4g} mm with "
            f"standard uncertainty {1e3 * u:.2g} mm; photograph more stops over a wider span of ranges, or give "
            "lens_file, a calibration of the lens."
        )
    return found


def free_parameters(rig: Rig, known: Covariance | None) -> tuple[str, ...]:
    """Baseline and aim, k, and whatever else somebody has stated an uncertainty of."""
    stated = [] if known is None else [name for name, u in zip(known.names, known.u, strict=True) if u > 0]
    others = [name for name in stated if name not in (*HEAD, LEAN, "camera.k") and name in rig.parameter_names]
    fixed_k = known is not None and "camera.k" in known.names and "camera.k" not in stated
    return (*HEAD, *([] if fixed_k else ["camera.k"]), *others)


def refuse_too_few(looks: tuple[Look, ...], *, wanted: int) -> None:
    """`wanted`: parameters that nothing but the stops tells."""
    ranges = np.array([_range(look) for look in looks])
    stated = looks[0].reference.u is not None
    needed = max(FEWEST_STOPS, wanted + (0 if stated else SCATTERING))
    if ranges.max() < NARROWEST * ranges.min():
        raise InputError(
            f"All {ranges.size} stops that show a line are at nearly one range ({1e3 * ranges.min():.4g} to "
            f"{1e3 * ranges.max():.4g} mm): they tell how baseline, aim and k make that range together, not one of "
            "them; photograph the target over the whole span the head shall measure."
        )
    if np.unique(ranges).size < needed:
        raise InputError(
            f"{np.unique(ranges).size} stops show a line, at least {needed} are needed for {wanted} parameters"
            f"{'' if stated else ' and the scatter of the stops'}; photograph more stops"
            f"{'' if stated else ', or state u_range, the standard uncertainty of the ranges'}."
        )


def refuse_other_way(looks: tuple[Look, ...]) -> None:
    """Raises InputError where the line moves to smaller columns as the target goes away."""
    ranges, columns = np.array([_range(look) for look in looks]), np.array([np.median(look.u) for look in looks])
    if len(looks) > 1 and np.ptp(ranges) > 0 and np.polyfit(ranges, columns, 1)[0] < 0:
        near, far = int(np.argmin(ranges)), int(np.argmax(ranges))
        raise InputError(
            f"The pictures are mirrored or upside down: the line moves from column {columns[near]:.0f} at "
            f"{looks[near].name} to column {columns[far]:.0f} at {looks[far].name}, but larger ranges belong on larger "
            "columns; turn the pictures by 180 deg or undo the mirroring, here and for every scan alike."
        )


def _range(look: Look) -> float:
    assert isinstance(look.reference, FlatTarget)
    return look.reference.distance


def _bounds(rig: Rig, free: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Of the changes."""
    aim = value_of(rig, HEAD[1])
    bounds = {HEAD[1]: (-min(WIDEST_TURN, aim), min(WIDEST_TURN, np.pi / 2 - aim))}
    for name, (least, most) in BOUNDS.items():
        if name in free:
            bounds[name] = (least - 1) * value_of(rig, name), (most - 1) * value_of(rig, name)
    return bounds


def _calibration(target: RangeTarget, pictures: LinePictures, found: RigFit, wrong: list[Suspect]) -> Calibration:
    unit: Unit = target.unit
    ranges = [_range(look) for look in found.model.looks]
    left_out = {one.stop: one for one in wrong}
    files = list(pictures.files)
    for look in pictures.looks:
        if look.name in left_out:
            off = unit.said(left_out[look.name].off, 0.01 * unit.size)
            files[look.file] = replace(files[look.file], refused=f"its range is off by {off}")
    noise, shared = scatter_of(found)
    return Calibration(
        kind="range",
        rig=found.rig,
        camera=found.rig.camera,
        values=values_of(found.rig, found.free),
        covariance=found.covariance,
        degrees_of_freedom=found.fit.degrees_of_freedom,
        noise=noise,
        group_sigma=shared,
        files=tuple(files),
        observations=observations_of(found),
        valid=ValidRegion(zeniths_of(found), (min(ranges), max(ranges))),
        settings={
            "stated": values_of(found.model.rig, found.free),
            "stops": {"count": len(found.model.stops), "scatter_m": found.stop_scatter},
        },
        findings=tuple(range_findings(target, pictures, found)),
        warnings=tuple(range_warnings(target, pictures, found, wrong)),
    )
