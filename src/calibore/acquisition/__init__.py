"""Pictures measured while they are taken: a camera, a network stream, a folder that is being filled.

`described`       a job and its source from what a user gives: `Wanted`
`live_scan`       what a source brings, measured with bounded delay and memory into a result folder; survives a kill
`LiveStream`      a camera or network stream that may stop, change and come back
`GrowingFolder`   image files in order as they become complete
`LiveOdometry`    an odometry table that grows meanwhile; `placed_by_speed`, `placed_in_folder` where there is none
`panel`, `plain_line`   a run's `Vitals` for people
"""

from calibore.acquisition._backlog import Arrival, Backlog, LeftOut
from calibore.acquisition._book import LEFT_OUT, Book
from calibore.acquisition._description import Wanted, described
from calibore.acquisition._folder import GrowingFolder
from calibore.acquisition._job import WAITING, Limits, LiveJob
from calibore.acquisition._journal import Journal, journal_folder
from calibore.acquisition._live import default_workers, live_scan
from calibore.acquisition._panel import panel, plain_line
from calibore.acquisition._place import LiveOdometry, placed_by_speed, placed_in_folder, speed_of
from calibore.acquisition._run import Watch
from calibore.acquisition._source import LiveSource
from calibore.acquisition._stream import LiveStream
from calibore.acquisition._vitals import Latencies, Vitals

__all__ = [
    "LEFT_OUT",
    "WAITING",
    "Arrival",
    "Backlog",
    "Book",
    "GrowingFolder",
    "Journal",
    "Latencies",
    "LeftOut",
    "Limits",
    "LiveJob",
    "LiveOdometry",
    "LiveSource",
    "LiveStream",
    "Vitals",
    "Wanted",
    "Watch",
    "default_workers",
    "described",
    "journal_folder",
    "live_scan",
    "panel",
    "placed_by_speed",
    "placed_in_folder",
    "plain_line",
    "speed_of",
]
