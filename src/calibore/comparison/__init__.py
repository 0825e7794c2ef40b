"""The difference of two profiles of one pipe, once they are registered.

`difference`   -> `Difference`: point by point with covariance, what calibration explains apart
`agreement`    -> `Agreement`: errors of a measurement against a reference, beside what it states
`changes`      -> `Changes`: what has changed between two epochs, with a stated probability of false alarm
`compared`     -> `Compared`: registers, checks and compares, whichever of both questions; `numbers`, `write_arrays`,
               `difference_dataset` of it; `kind_of`, `is_tactile_result`: what a folder is
"""

from calibore.comparison._agreement import Agreement, Errors, OutlierRule, agreement
from calibore.comparison._changes import Changes, changes
from calibore.comparison._checks import mirrored
from calibore.comparison._compared import Compared, compared
from calibore.comparison._difference import Difference, difference, difference_of
from calibore.comparison._files import (
    difference_dataset,
    is_tactile_result,
    kind_of,
    numbers,
    per_year,
    write_arrays,
)
from calibore.comparison._region import Region

__all__ = [
    "Agreement",
    "Changes",
    "Compared",
    "Difference",
    "Errors",
    "OutlierRule",
    "Region",
    "agreement",
    "changes",
    "compared",
    "difference",
    "difference_dataset",
    "difference_of",
    "is_tactile_result",
    "kind_of",
    "mirrored",
    "numbers",
    "per_year",
    "write_arrays",
]
