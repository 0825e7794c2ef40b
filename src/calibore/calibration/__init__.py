"""From pictures of known things to parameters with covariance, and to the evidence that they can be trusted.

`Calibration`   what was found: rig or camera, covariance, model comparison, valid region, evidence
`calibrate`     the calibration that a target.toml asks for, by its kind: `calibrate_boards`, `calibrate_pupil` ...
`write_calibration`, `read_calibration`   its FILE, a rig file or the part of one, and its evidence beside it
`check_calibration_file`   whether a FILE may be written, before any work
`recomputed_covariance`, `verify_inputs`   whether FILE, evidence and inputs still agree
`projection_uncertainty`, `wall_uncertainty`, `wall_map`   what a covariance means in the image, and on the wall
`difference`    -> `Difference`: is this the same camera as last year; `halves`: half of the pictures against the rest
`plan`          -> `Plan`: which picture of a target to take next; `read_planned_target`
"""

from calibore.calibration._boards._calibrate import calibrate_boards
from calibore.calibration._calibration import Calibration, Comparison, Observations
from calibore.calibration._difference._difference import Difference, difference
from calibore.calibration._dispatch import calibrate
from calibore.calibration._evidence_covariance import recomputed_covariance
from calibore.calibration._file._file import check_calibration_file, read_calibration, verify_inputs, write_calibration
from calibore.calibration._file._units import unit_of_parameter
from calibore.calibration._halves import Halves, halves
from calibore.calibration._in_situ._calibrate import calibrate_profile
from calibore.calibration._input_files import InputFile
from calibore.calibration._on_the_wall import WallMap, WallUncertainty, wall_map, wall_uncertainty
from calibore.calibration._planning._plan import Plan, Step, plan
from calibore.calibration._planning._shots import Shot
from calibore.calibration._planning._targets import (
    PlannedBoard,
    PlannedFlats,
    PlannedGauges,
    PlannedRings,
    PlannedTarget,
    read_planned_target,
)
from calibore.calibration._probe._calibrate import calibrate_probe
from calibore.calibration._projection import ProjectionUncertainty, projection_uncertainty
from calibore.calibration._pupil._calibrate import calibrate_pupil
from calibore.calibration._rig._gauges import calibrate_gauges
from calibore.calibration._rig._range import calibrate_range
from calibore.calibration._rings._calibrate import calibrate_rings

__all__ = [
    "Calibration",
    "Comparison",
    "Difference",
    "Halves",
    "InputFile",
    "Observations",
    "Plan",
    "PlannedBoard",
    "PlannedFlats",
    "PlannedGauges",
    "PlannedRings",
    "PlannedTarget",
    "ProjectionUncertainty",
    "Shot",
    "Step",
    "WallMap",
    "WallUncertainty",
    "calibrate",
    "calibrate_boards",
    "calibrate_gauges",
    "calibrate_probe",
    "calibrate_profile",
    "calibrate_pupil",
    "calibrate_range",
    "calibrate_rings",
    "check_calibration_file",
    "difference",
    "halves",
    "plan",
    "projection_uncertainty",
    "read_calibration",
    "read_planned_target",
    "recomputed_covariance",
    "unit_of_parameter",
    "verify_inputs",
    "wall_map",
    "wall_uncertainty",
    "write_calibration",
]
