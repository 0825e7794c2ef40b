"""What is true where a profile has its points, as truth.npz beside the pictures tells."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.experiment._published import INCH
from calibore.scans import Profile

Array = NDArray[np.float64]
Columns = dict[str, NDArray[Any]]
MEASURABLE = 0.05
"""Of full scale: least light of a point that counts."""
SAME = 1e-6
"""rad and m between positions that are meant to be one."""


def true_radius(profile: Profile, truth: Path) -> Array:
    """True radius (n, m) [m] in the rig's frame, NaN where the camera sees no light worth measuring; `truth` of the
    scan, or the section, that `profile` was measured from.
    """
    wanted = ("ring_rig_", "row_", "pose_t", "head_deg")
    with np.load(truth) as known:
        columns = {key: known[key] for key in known.files if key.startswith(wanted)}
    return _on_rows(columns, profile) if "row_u" in columns else _on_rings(columns, profile)


def _on_rings(columns: Columns, profile: Profile) -> Array:
    """Of the first laser."""
    axial = columns["pose_t"][:, 2] * INCH
    row = np.argmin(np.abs(axial - profile.axial[:, None]), axis=1)
    seen = columns["ring_rig_visible"][row, 0] & (columns["ring_rig_signal"][row, 0] > MEASURABLE)
    seen &= np.abs(axial[row] - profile.axial)[:, None] < SAME
    return np.where(seen, columns["ring_rig_R"][row, 0] * INCH, np.nan)


def _on_rows(columns: Columns, profile: Profile) -> Array:
    """Between neighbouring picture rows of the stop at each clock."""
    head = np.radians(columns["head_deg"])
    true = np.full(profile.radius.shape, np.nan)
    for column, clock in enumerate(profile.clock):
        away = np.abs(np.angle(np.exp(1j * (head - clock))))
        stop = int(np.argmin(away))
        if away[stop] > SAME:
            continue
        for row, place in enumerate(columns["pose_t"][:, 2] * INCH):
            seen = columns["row_visible"][row, stop] & (columns["row_signal"][row, stop] > MEASURABLE)
            radius = np.where(seen, columns["row_rig_R"][row, stop] * INCH, np.nan)
            value = _between_neighbours(profile.axial, columns["row_rig_H"][row, stop] * INCH + place, radius)
            true[:, column] = np.where(np.isfinite(value), value, true[:, column])
    return true


def _between_neighbours(at: Array, place: Array, value: Array) -> Array:
    """Linear between neighbours `place`, NaN beyond them and beside one that is NaN."""
    order = np.argsort(place)
    order = order[np.isfinite(place[order])]
    if order.size < 2:
        return np.full(at.shape, np.nan)
    return np.interp(at, place[order], value[order], left=np.nan, right=np.nan)
