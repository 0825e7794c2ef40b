"""The calibration of the head in the pipe, against the tactile scan ("intrinsic", 8.3.3)."""

from pathlib import Path

from calibore.calibration import calibrate, write_calibration
from calibore.experiment._instruments import Instrument
from calibore.experiment._scans import DRIFTED, Job, by_rig_file
from calibore.experiment._touch import NAME
from calibore.experiment._workshop import Workshop

VARIANT = "in-situ"


def in_situ_job(instrument: Instrument, workshop: Workshop, scan: Path, section: int) -> Job | None:
    """What the pictures of the head's middle stop are for, besides its profile; None for all others."""
    middle = len(instrument.sections(workshop.plan)) // 2
    if instrument.kind != "side" or section != middle:
        return None
    rig = workshop.calibration(DRIFTED, instrument.name)
    return workshop.calibration(VARIANT, instrument.name), lambda place: _calibrated(scan, rig, workshop, place)


def _calibrated(scan: Path, rig: Path, workshop: Workshop, place: Path) -> None:
    toml, folder = by_rig_file(scan, rig, name="in-situ"), place.parent
    text = (
        'format = "calibore-target/1"\nkind = "profile"\n'
        f'rig = "../{DRIFTED}/{rig.name}"\nscan = "../../{toml.relative_to(workshop.out).as_posix()}"\n'
        f'tactile = "../../scans/{NAME}"\nprobe = "../probe.toml"\n'
    )
    (folder / "target.toml").write_text(text, encoding="utf-8")
    write_calibration(calibrate("profile", folder), place)
