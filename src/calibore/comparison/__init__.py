"""The difference of two profiles of one pipe, once they are registered.

`difference`   -> `Difference`: point by point with covariance, what calibration explains apart
`agreement`    -> `Agreement`: errors of a measurement against a reference, beside what it states
`changes`      -> `Changes`: what has changed between two epochs, with a stated probability of false alarm
"""

from calibore.comparison._agreement import Agreement, Errors, OutlierRule, agreement
from calibore.comparison._changes import Changes, changes
from calibore.comparison._difference import Difference, difference, difference_of
from calibore.comparison._region import Region

__all__ = [
    "Agreement",
    "Changes",
    "Difference",
    "Errors",
    "OutlierRule",
    "Region",
    "agreement",
    "changes",
    "difference",
    "difference_of",
]
