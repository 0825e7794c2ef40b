"""`calibore simulate SPEC`: a scan folder or a calibration with truth, of any pipe, any rig, any target."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from calibore.cli._profile import Scheduler, Workers, as_json, crew_of, progress_bar

if TYPE_CHECKING:
    from calibore.simulation import Subject


def simulate(
    spec: Annotated[Path, typer.Argument(help="Specification, a TOML file: pipe or target, rig, path, light, sensor.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to make; it appears when complete.")],
    seed: Annotated[int | None, typer.Option(min=0, help="Instead of the specification's: other noise.")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    json: Annotated[bool, typer.Option("--json", help="Print what was made as JSON.")] = False,
) -> None:
    """Simulate a scan of a pipe that is known exactly, by light or by touch, or a calibration. Pictures or tables, the
    files that say what they are, and the truth beside them.
    """
    from calibore.simulation import read_subject
    from calibore.simulation import simulate as simulated

    subject, chosen = read_subject(spec, seed=seed)
    with crew_of(workers, scheduler) as crew, progress_bar("Simulating", quiet=json) as progress:
        folder = simulated(out, subject, seed=chosen, workers=crew, progress=progress)
    counts, said, use = _told(subject, folder, out)
    if json:
        typer.echo(as_json({"folder": str(folder), **counts, "seed": chosen}))
        return
    typer.echo(f"Simulated {said}: {out}")
    typer.echo(f"{use}; its truth is in {out / 'truth.npz'}.")


def _told(subject: "Subject", folder: Path, out: Path) -> tuple[dict[str, Any], str, str]:
    """What was made in numbers, in words, and what to do with it."""
    from calibore.simulation import Survey, TactileSurvey

    measure = f"Measure it: calibore profile {out} --out RESULT"
    if isinstance(subject, Survey):
        images = sum(station.takes for station in subject.stations)
        stops = len(subject.stations)
        return {"images": images, "stops": stops}, f"{images} images at {stops} stops", measure
    if isinstance(subject, TactileSurvey):
        readings = subject.stations * subject.stops
        return (
            {"readings": readings, "rings": subject.stations},
            f"{readings} readings of {subject.stations} rings",
            measure,
        )
    images = len(list(folder.glob("*.png")))
    said = f"{images} photograph{'s' * (images > 1)} of a target" if images else "the tables of a probe"
    return {"images": images}, said, f"Calibrate with it: calibore calibrate {subject.verb} {out} --out FILE.toml"
