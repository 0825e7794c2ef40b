"""The pipeline from images to a measured pipe.

`profile_scan`   a scan folder in, a result folder out
`measure_scan`   the same station by station, for programs that keep results in memory
`measure_image`  one picture in memory or in a file to a `Ring` on the clock grid
`prepare`        reads and checks what a scan folder says before its first image is read
`archive_scan`   a scan folder in, one that holds its pictures in an archive out
"""

from calibore.profiling._archive import archive_scan
from calibore.profiling._grid import Ring
from calibore.profiling._job import Job
from calibore.profiling._measured import Example
from calibore.profiling._placement import FOLDER_CHANNEL, Placement, Placer, placed_by_station, video_channel
from calibore.profiling._profile import (
    Finisher,
    Progress,
    Sealed,
    forward_job,
    forward_rig,
    measure_scan,
    prepare,
    profile_scan,
)
from calibore.profiling._row import row_quantities
from calibore.profiling._station import (
    RefusedImage,
    StationRefusedError,
    StationResult,
    measure_image,
    measure_station,
)
from calibore.profiling._summary import Tally, summarise

__all__ = [
    "FOLDER_CHANNEL",
    "Example",
    "Finisher",
    "Job",
    "Placement",
    "Placer",
    "Progress",
    "RefusedImage",
    "Ring",
    "Sealed",
    "StationRefusedError",
    "StationResult",
    "Tally",
    "archive_scan",
    "forward_job",
    "forward_rig",
    "measure_image",
    "measure_scan",
    "measure_station",
    "placed_by_station",
    "prepare",
    "profile_scan",
    "row_quantities",
    "summarise",
    "video_channel",
]
