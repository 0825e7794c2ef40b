"""`calibore calibrate ...`: pictures of known things in, parameters with their evidence out."""

from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._calibrate_use import Json, UnitName, diff, plan, show
from calibore.cli._calibrate_words import check_unit, tell
from calibore.cli._failure import PARTLY_REFUSED
from calibore.cli._profile import progress_bar

calibrate = typer.Typer(
    name="calibrate",
    help="Lens, rig, pupil and probe from pictures of known things, with covariance, evidence and refusals.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
Target = Annotated[Path, typer.Argument(metavar="INPUT", help="Folder with target.toml and pictures, or target.toml.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Calibration file, e.g. lens.toml; it appears when complete.")]
SAID = {
    "lens": "A camera's lens and centre. From pictures of concentric rings, chessboards, ChArUco or circle grids.",
    "rig": "A rig's laser and lens. From its line on a flat at known ranges, or in gauges of known diameter.",
    "pupil": "Where the entrance pupil is. From pictures of two pins.",
    "probe": "A tactile probe's conversion. From a caliper's lengths and diameters.",
    "profile": "A rig in the pipe itself. Against a profile measured by other means.",
}


def _verb(verb: str) -> Any:
    def run(target: Target, out: Out, unit: UnitName = "mm", json: Json = False) -> None:
        _calibrate(verb, target, out, unit=unit, json=json)

    run.__doc__ = SAID[verb]
    return run


for name in SAID:
    calibrate.command(name)(_verb(name))
for use in (show, diff, plan):
    calibrate.command()(use)


def _calibrate(verb: str, target: Path, out: Path, *, unit: str, json: bool) -> None:
    from calibore.calibration import calibrate as calibrated
    from calibore.calibration import check_calibration_file, write_calibration

    check_unit(unit)
    check_calibration_file(out)
    with progress_bar("Calibrating", quiet=json) as progress:
        found = calibrated(verb, target, progress=progress)
    write_calibration(found, out)
    tell(found, out, unit=unit, json=json)
    if any(file.refused for file in found.files):
        raise typer.Exit(PARTLY_REFUSED)
