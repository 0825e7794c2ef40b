"""Kind "profile": a rig calibrated in the pipe, against a reference there (Swanbom 2007, 8.3.3, "intrinsic")."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from calibore.calibration._calibration import Calibration
from calibore.calibration._in_situ._file import read_profile_target
from calibore.calibration._in_situ._fit import fit_in_situ
from calibore.calibration._in_situ._marks import read_marks
from calibore.calibration._in_situ._pose import aligned
from calibore.calibration._in_situ._words import in_situ_findings, in_situ_warnings
from calibore.calibration._rig._findings import observations_of, scatter_of, zeniths_of
from calibore.rigs import ValidRegion, values_of


def calibrate_profile(path: Path | str, *, progress: Callable[[int, int], None] | None = None) -> Calibration:
    """The rig in use, re-fitted to a gauge, a table or a tactile scan of the pipe; `path`: target.toml or its folder.

    How the reference lies in the scan's frame is unknown: roll, two shifts, axial shift and slopes of its axis are
    parameters. Marks on features that one of both does not show are left out. `progress` counts pictures, where there
    are any to read. Raises InputError where scan and reference cannot be compared or tell nothing.
    """
    target = read_profile_target(path)
    marks, files = read_marks(target, progress=progress)
    rig = target.rig.with_default_uncertainty(float(np.nanmedian(target.wall.radius)))
    alignment = aligned(target, rig, marks)
    found = fit_in_situ(rig, alignment.looks, free=target.said.free, prior=target.said.prior)
    result = found.result
    radii, (noise, shared) = result.radii(), scatter_of(result)
    return Calibration(
        kind=target.said.kind,
        rig=result.rig,
        camera=result.rig.camera,
        values=values_of(result.rig, result.free),
        covariance=result.covariance,
        degrees_of_freedom=result.fit.degrees_of_freedom,
        noise=noise,
        group_sigma=shared,
        files=(*target.files, *files),
        observations=observations_of(result),
        valid=ValidRegion(zeniths_of(result), (float(np.nanmin(radii)), float(np.nanmax(radii)))),
        models=found.models,
        settings={"in_use": values_of(rig, result.free)},
        findings=tuple(in_situ_findings(found, alignment, target.unit)),
        warnings=tuple(in_situ_warnings(found, target, files)),
    )
