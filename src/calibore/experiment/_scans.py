"""Section by section: pictures, and what every rig file makes of them."""

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

from calibore.experiment._instruments import Instrument
from calibore.experiment._published import INCH
from calibore.experiment._workshop import Workshop, remove
from calibore.profiling import profile_scan
from calibore.simulation import Survey, simulate_scan

EXACT, FRESH, DRIFTED = "exact", "fresh", "drifted"
VARIANTS = (EXACT, FRESH, DRIFTED)
"""Rig files: the rig itself; as calibrated on the day of the scan; as calibrated before it changed, with [drift]."""

GRID = 0.05 * INCH
"""Spacing of a head's rows, the same whatever its rig file says of the pictures' scale."""

Job = tuple[Path, Callable[[Path], object]]
"""What is to be made of a section's pictures, and how."""


def variants_of(instrument: Instrument) -> tuple[str, ...]:
    return VARIANTS if instrument.before else (EXACT, FRESH)


def steps_of(instrument: Instrument, workshop: Workshop) -> int:
    """Pictures to take and to measure."""
    return pictures_of(instrument.survey(workshop.plan)) * (1 + len(variants_of(instrument)))


def pictures_of(survey: Survey) -> int:
    return sum(station.takes for station in survey.stations)


def scan_sections(instrument: Instrument, workshop: Workshop, *, besides: Callable[[Path, int], Job | None]) -> None:
    """Simulates and profiles all sections of a scan; `besides(scan, section)`: what else its pictures are for."""
    for number, survey in enumerate(instrument.sections(workshop.plan)):
        scan, pictures = workshop.scan(instrument.name, number), pictures_of(survey)
        jobs: list[Job] = [
            (
                workshop.profile(variant, instrument.name, number),
                partial(_profiled, scan, variant, workshop.calibration(variant, instrument.name), workshop),
            )
            for variant in variants_of(instrument)
        ]
        other = besides(scan, number)
        if not all(place.exists() for place, _ in [*jobs, *([other] if other else [])]):
            _photographed(scan, survey, workshop, seed=instrument.seed(workshop.plan))
        else:
            workshop.count(pictures)
        for place, make in jobs:
            workshop.made(place, make, worth=pictures)
        if other:
            workshop.made(*other, worth=0)
        if not workshop.keep_pictures:
            remove(scan.glob("*.png"))


def _photographed(scan: Path, survey: Survey, workshop: Workshop, *, seed: int) -> None:
    wanted = pictures_of(survey)
    if sum(1 for _ in scan.glob("*.png")) == wanted:
        workshop.count(wanted)
        return
    shutil.rmtree(scan, ignore_errors=True)
    simulate_scan(scan, survey, seed=seed, workers=workshop.crew, progress=lambda done, total: workshop.count(1))


def by_rig_file(scan: Path, rig: Path, *, name: str) -> Path:
    """The scan.toml of `scan` again, as `name`, with another rig file than the one beside it."""
    toml = scan / f"{name}.toml"
    named = Path("..", "..", "..", *rig.parts[-3:]).as_posix()
    text = (scan / "scan.toml").read_text(encoding="utf-8")
    grid = f'\n[grid]\naxial_step = "{1e3 * GRID:.9g} mm"\n' if "angular =" in text else ""
    toml.write_text(text.replace('rig = "rig.toml"', f'rig = "{named}"') + grid, encoding="utf-8")
    return toml


def _profiled(scan: Path, variant: str, rig: Path, workshop: Workshop, place: Path) -> None:
    profile_scan(by_rig_file(scan, rig, name=variant), place, workers=workshop.crew)
