"""A first look at a side-facing head: which aim and k put the line on the target at all."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._references import FlatTarget
from calibore.errors import InputError
from calibore.rigs import Rig, SideFacing

Array = NDArray[np.float64]
AIMS = np.radians(np.linspace(-12.0, 12.0, 241))
SCALES = np.linspace(0.8, 1.25, 31)
BASELINES = 0.4, 2.5
"""Of the stated value, between which a first look accepts one."""


def roughly(rig: Rig, looks: tuple[Look, ...], *, k_known: bool) -> Rig:
    """`rig` with baseline and aim, and k unless that is known, moved so that the middles of its lines triangulate near
    their ranges; small errors of the aim let far ones run to infinity, where no search by slopes finds back.

    R = D cot(aim - theta) (Swanbom 2007, eq. 7-1, in one angle) is linear in D for every aim and k of a grid.
    """
    mount = rig.mount
    assert isinstance(mount, SideFacing)
    ranges = np.array([look.reference.distance for look in looks if isinstance(look.reference, FlatTarget)])
    columns = np.array([np.median(look.u) for look in looks])
    best, found = np.inf, None
    for scale in [1.0] if k_known else SCALES:
        camera = replace(rig.camera, lens=replace(rig.camera.lens, k=rig.camera.lens.k * scale))
        direction = camera.unproject(columns, np.full(columns.size, camera.principal_point[1])).direction
        angle = np.arctan2(direction[:, 0], direction[:, 2])
        aims = mount.aim + AIMS
        relative = 1 / np.tan(aims[:, None] - angle) / ranges
        baseline = relative.sum(axis=1) / np.sum(relative**2, axis=1)
        misfit = np.sum((baseline[:, None] * relative - 1) ** 2, axis=1)
        least, most = BASELINES
        lost = (relative <= 0).any(axis=1) | (baseline < least * mount.baseline) | (baseline > most * mount.baseline)
        misfit[lost | (aims <= 0) | ~np.isfinite(misfit)] = np.inf
        number = int(np.argmin(misfit))
        if misfit[number] < best:
            best, found = (
                misfit[number],
                replace(rig, camera=camera, mount=SideFacing(float(baseline[number]), float(aims[number]))),
            )
    if found is None:
        raise InputError("no baseline, aim and k anywhere near these put the lines at their ranges")
    return found
