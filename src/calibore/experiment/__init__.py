"""The dissertation's experiment (chapters 6 to 8) again, on a simulated pipe whose truth is known.

`run_experiment`   calibrates, scans, touches, registers and compares in one folder -> `Outcome`; goes on where it was
`PLANS`            how large: "reduced" and "full" `Plan`
`LaserOutcome`     errors of one instrument: `Judgement`s by rig file (`EXACT`, `FRESH`, `DRIFTED`, `UNSTATED`), against
                   the truth and against the tactile profile
`TABLE_6_1` ...    what is printed of the experiment, as facts, in inches and degrees
"""

from calibore.experiment._in_situ import VARIANT as IN_SITU
from calibore.experiment._outcome import UNSTATED, Judgement, LaserOutcome
from calibore.experiment._plan import PLANS, Plan
from calibore.experiment._published import (
    DESIGNED,
    EXTRINSIC,
    HEAD_CHANGE,
    INCH,
    INTRINSIC,
    NOMINAL_RADIUS,
    PLANES,
    SPREAD,
    TABLE_6_1,
    TABLE_8_2,
    TABLE_8_3,
    Head,
)
from calibore.experiment._run import Outcome, run_experiment
from calibore.experiment._scans import DRIFTED, EXACT, FRESH

__all__ = [
    "DESIGNED",
    "DRIFTED",
    "EXACT",
    "EXTRINSIC",
    "FRESH",
    "HEAD_CHANGE",
    "INCH",
    "INTRINSIC",
    "IN_SITU",
    "NOMINAL_RADIUS",
    "PLANES",
    "PLANS",
    "SPREAD",
    "TABLE_6_1",
    "TABLE_8_2",
    "TABLE_8_3",
    "UNSTATED",
    "Head",
    "Judgement",
    "LaserOutcome",
    "Outcome",
    "Plan",
    "run_experiment",
]
