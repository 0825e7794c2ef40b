"""The pipeline from images to a measured pipe.

`profile_scan`   a scan folder in, a result folder out
`measure_scan`   the same station by station, for programs that keep results in memory
`prepare`        reads and checks what a scan folder says before its first image is read
"""

from calibore.profiling._profile import Finisher, Progress, Sealed, measure_scan, prepare, profile_scan
from calibore.profiling._station import Job, StationResult, measure_station
from calibore.profiling._summary import Tally

__all__ = [
    "Finisher",
    "Job",
    "Progress",
    "Sealed",
    "StationResult",
    "Tally",
    "measure_scan",
    "measure_station",
    "prepare",
    "profile_scan",
]
