"""The dissertation's experiment (chapters 6 to 8) again, on a simulated pipe whose truth is known.

`run_experiment`   calibrates, scans, touches, registers and compares in one folder -> `Outcome`; goes on where it was
`PLANS`            how large: "reduced" and "full" `Plan`
`LaserOutcome`     errors of one instrument: `Judgement`s by rig file, against the truth and against the tactile profile
"""

from calibore.experiment._outcome import Judgement, LaserOutcome
from calibore.experiment._plan import PLANS, Plan
from calibore.experiment._run import Outcome, run_experiment

__all__ = ["PLANS", "Judgement", "LaserOutcome", "Outcome", "Plan", "run_experiment"]
