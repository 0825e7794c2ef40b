"""truth.npz: what a perfect measurement of a simulated scan would find.

Keys and axes are those of the other simulated scans: `ring_*` (station, laser, clock), or `row_*` (station, angular,
row) of a side-facing head, in inches and radians; `pose_t` inches; what begins with `true_` is SI.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import Pose
from calibore.rigs import Rig, SideFacing
from calibore.simulation._light import LineLight, LitLine
from calibore.simulation._truth import true_quantities, true_ring, true_rows
from calibore.simulation._wall import PipeWall
from calibore.units import parse_quantity

Columns = dict[str, NDArray[Any]]
FULL_TURN = 2 * np.pi


def station_truth(rig: Rig, wall: PipeWall, lines: list[LitLine], *, pipe_from_rig: Pose, line: LineLight) -> Columns:
    """Truth of the `lines` of all lasers at one stop: (laser, clock) of each, or (row,) of a side-facing head."""
    inch = parse_quantity("1 in", "length")
    if isinstance(rig.mount, SideFacing):
        rows = true_rows(lines[0], rig, wall, pipe_from_rig=pipe_from_rig, line=line)
        return {
            "row_u": rows.u,
            "row_rig_R": rows.radius / inch,
            "row_rig_H": rows.axial / inch,
            "row_rig_phi": rows.clock,
            "row_visible": rows.visible,
            "row_signal": rows.signal,
        }
    rings = [true_ring(lit, rig, wall, pipe_from_rig=pipe_from_rig, line=line, laser=n) for n, lit in enumerate(lines)]
    quantities = [true_quantities(lit, nominal_radius=wall.nominal_radius) for lit in lines]
    several = slice(None) if len(lines) > 1 else 0
    return {
        "ring_phi": rings[0].clock,
        "ring_rig_R": np.stack([ring.radius for ring in rings]) / inch,
        "ring_rig_H": np.stack([ring.axial for ring in rings]) / inch,
        "ring_rig_visible": np.stack([ring.visible for ring in rings]),
        "ring_rig_signal": np.stack([ring.signal for ring in rings]),
        **{f"true_{name}": np.array([found[name] for found in quantities])[several] for name in quantities[0]},
    }


def ring_columns(truth: list[Columns], numbers: list[int], poses: list[Pose]) -> Columns:
    """All stations of a rig that draws rings; `true_*` are (station,), or (station, laser) where there are several."""
    columns = {key: np.stack([row[key] for row in truth]) for key in truth[0]}
    axial = np.array([pose.translation[2] for pose in poses])
    return {"stop": np.array(numbers), **columns, **_poses(poses), "true_axial": axial}


def row_columns(
    truth: list[Columns], numbers: list[int], poses: list[Pose], *, angular: NDArray[Any], clock: NDArray[Any]
) -> Columns:
    """All stops of a side-facing head, whose clocks [rad] at the stops `angular` are turned into the rig frame."""
    shape = len(numbers), angular.size
    columns = {key: np.stack([row[key] for row in truth]).reshape(*shape, -1) for key in truth[0]}
    columns["row_rig_phi"] = np.mod(columns["row_rig_phi"] + clock[:, None] - np.pi, FULL_TURN)
    return {
        "axial_index": np.array(numbers),
        "angular_index": angular,
        "head_deg": np.degrees(clock),
        "rows": np.arange(columns["row_u"].shape[2]),
        **columns,
        **_poses(poses),
    }


def _poses(poses: list[Pose]) -> Columns:
    inch = parse_quantity("1 in", "length")
    return {
        "pose_R": np.stack([pose.rotation for pose in poses]),
        "pose_t": np.stack([pose.translation for pose in poses]) / inch,
    }
