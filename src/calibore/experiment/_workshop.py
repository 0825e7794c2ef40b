"""The folder an experiment grows in: every step makes one file or folder there, and is not done twice."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from calibore.crews import Workers
from calibore.experiment._plan import Plan

Progress = Callable[[int, int], None]


@dataclass
class Workshop:
    """`out` holds the experiment of `plan`; `crew` does it; `progress(done, total)` counts steps, a picture being one.

    `keep_pictures` of sections that have been profiled, which else are removed.
    """

    out: Path
    plan: Plan
    crew: Workers
    keep_pictures: bool = False
    progress: Progress | None = None
    total: int = 0
    done: int = field(default=0, init=False)

    def made(self, place: Path, make: Callable[[Path], object], *, worth: int = 1) -> Path:
        """`place`, made by `make` unless it is there; everything made here appears whole. `worth`: steps it counts."""
        if not place.exists():
            place.parent.mkdir(parents=True, exist_ok=True)
            make(place)
        self.count(worth)
        return place

    def count(self, steps: int) -> None:
        self.done += steps
        if self.progress:
            self.progress(self.done, self.total)

    def calibration(self, variant: str, name: str) -> Path:
        """The rig file of an instrument for a `variant`, in the folder with its target."""
        return self.out / "calibrations" / variant / f"{name}.toml"

    def scan(self, name: str, section: int) -> Path:
        return self.out / "scans" / name / f"{section:03d}"

    def profile(self, variant: str, name: str, section: int) -> Path:
        return self.out / "profiles" / variant / name / f"{section:03d}"


def remove(files: Iterable[Path]) -> None:
    """They may be gone already."""
    for path in files:
        path.unlink(missing_ok=True)
