"""What a scan folder says, as values: `ScanSpec` and the motions of carriage and head."""

import datetime
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class AxialMotion:
    """The carriage stops every `step` [m] (negative: travelling backwards), station 0 at `origin` [m]."""

    origin: float
    step: float

    def axial(self, station: ArrayLike) -> NDArray[np.float64]:
        """Axial position of the rig origin [m] at each station, the shape of `station`."""
        return self.origin + self.step * np.asarray(station, dtype=float)


@dataclass(frozen=True)
class AngularMotion:
    """A side-facing head turns by `step` [rad] from angular stop to angular stop, stop 0 at `origin` [rad]."""

    origin: float
    step: float

    def clock(self, stop: ArrayLike) -> NDArray[np.float64]:
        """Clock of the head [rad] at each angular stop, not wrapped, the shape of `stop`."""
        return self.origin + self.step * np.asarray(stop, dtype=float)


@dataclass(frozen=True)
class TactileTables:
    """Probe voltages (rows rings, columns angular stops) and the radius [m] of the ball at the end of its pin; `probe`:
    its calibration; `drift` [m]: standard uncertainty of what its readings shift by during the scan.
    """

    signal: Path
    bias: Path
    tip_radius: float
    probe: Path | None = None
    drift: float | None = None


def without_password(address: str) -> str:
    """`address` as people may see it: `rtsp://name:secret@camera/1` becomes `rtsp://camera/1`."""
    return re.sub(r"(?<=://)[^/@]*@", "", address)


@dataclass(frozen=True)
class ScanSpec:
    """What a scan folder says, SI units, paths resolved; exactly one of `pattern`, `video`, `tactile`, `stream` is set.

    `stream`: where a camera's pictures come from while they are taken; its password is part of nothing that is written.
    `archive`: the Zarr group that holds the pictures called as `pattern` says; None where they are files.

    `motion` is an `AxialMotion` or the path of a table. `search_inner` and `search_outer` are fractions of the nominal
    radius between which the wall is looked for; `axial_step` [m]: spacing of the rows of a side-facing scan's profile,
    None to choose; `date` of the survey. `identity` stays when settings are corrected or the folder is moved: it hashes
    the folder's own name, the scan's name and where its data come from.
    """

    folder: Path
    name: str
    rig_path: Path | None
    nominal_radius: float
    motion: AxialMotion | Path
    identity: str
    pattern: str | None = None
    archive: Path | None = None
    video: Path | None = None
    tactile: TactileTables | None = None
    angular: AngularMotion | None = None
    limit_deflection_percent: float | None = None
    limit_ovality_percent: float | None = None
    search_inner: float = 0.5
    search_outer: float = 1.5
    axial_step: float | None = None
    date: datetime.date | None = None
    stream: str | None = None

    @property
    def kind(self) -> Literal["forward-looking", "side-facing", "tactile"]:
        """`tactile` for probe tables, `side-facing` for a head that turns, else `forward-looking`."""
        if self.tactile:
            return "tactile"
        return "side-facing" if self.angular or "{angular" in (self.pattern or "") else "forward-looking"
