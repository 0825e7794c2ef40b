"""The data model of a survey: what a scan folder says, and the result folder made from it.

`read_scan` -> `ScanSpec`; one `RingProfile` and `RingPoints` per station go through `ResultWriter` into OUT;
`open_profile`, `open_points`, `read_rings` open OUT again, `read_profile` -> `Profile` all of it in memory; `export`
writes it for other programs.
"""

from calibore.scans._exports import check_format, default_export_name, export
from calibore.scans._lock import locked
from calibore.scans._profile import Profile, joined, read_profile
from calibore.scans._results import open_points, open_profile, read_rings
from calibore.scans._ring import RingPoints, RingProfile
from calibore.scans._scan import AngularMotion, AxialMotion, ScanSpec, TactileTables, without_password
from calibore.scans._scan_file import read_scan
from calibore.scans._writer import ResultWriter

__all__ = [
    "AngularMotion",
    "AxialMotion",
    "Profile",
    "ResultWriter",
    "RingPoints",
    "RingProfile",
    "ScanSpec",
    "TactileTables",
    "check_format",
    "default_export_name",
    "export",
    "joined",
    "locked",
    "open_points",
    "open_profile",
    "read_profile",
    "read_rings",
    "read_scan",
    "without_password",
]
