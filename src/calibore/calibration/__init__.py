"""From pictures of known things to parameters with covariance, and to the evidence that they can be trusted.

`Calibration`   what was found: rig or camera, covariance, model comparison, valid region, evidence
`write_calibration`, `read_calibration`   its FILE, a rig file or the part of one, and its evidence beside it
`check_calibration_file`   whether a FILE may be written, before any work
`recomputed_covariance`, `verify_inputs`   whether FILE, evidence and inputs still agree
"""

from calibore.calibration._calibration import Calibration, Comparison, InputFile, Observations
from calibore.calibration._evidence_covariance import recomputed_covariance
from calibore.calibration._file import check_calibration_file, read_calibration, verify_inputs, write_calibration

__all__ = [
    "Calibration",
    "Comparison",
    "InputFile",
    "Observations",
    "check_calibration_file",
    "read_calibration",
    "recomputed_covariance",
    "verify_inputs",
    "write_calibration",
]
