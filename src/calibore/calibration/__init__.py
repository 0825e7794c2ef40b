"""From pictures of known things to parameters with covariance, and to the evidence that they can be trusted.

`Calibration`   what was found: rig or camera, covariance, model comparison, valid region, evidence
"""

from calibore.calibration._calibration import Calibration, Comparison, InputFile, Observations

__all__ = ["Calibration", "Comparison", "InputFile", "Observations"]
