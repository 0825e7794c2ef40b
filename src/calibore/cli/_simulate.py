"""`calibore simulate SPEC`: a scan folder with truth, of any pipe and any rig."""

from pathlib import Path
from typing import Annotated

import typer

from calibore.cli._profile import Scheduler, Workers, as_json, crew_of, progress_bar


def simulate(
    spec: Annotated[Path, typer.Argument(help="Specification, a TOML file: pipe, rig, path, light, sensor.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Scan folder to make; it appears when complete.")],
    seed: Annotated[int | None, typer.Option(min=0, help="Instead of the specification's: other noise.")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    json: Annotated[bool, typer.Option("--json", help="Print what was made as JSON.")] = False,
) -> None:
    """Simulate a scan of a pipe that is known exactly. Pictures, scan.toml, rig.toml, and the truth beside them."""
    from calibore.simulation import read_survey, simulate_scan

    survey, chosen = read_survey(spec, seed=seed)
    with crew_of(workers, scheduler) as crew, progress_bar("Simulating", quiet=json) as progress:
        folder = simulate_scan(out, survey, seed=chosen, workers=crew, progress=progress)
    images = sum(station.takes for station in survey.stations)
    if json:
        typer.echo(as_json({"folder": str(folder), "images": images, "stops": len(survey.stations), "seed": chosen}))
        return
    typer.echo(f"Simulated {images} images at {len(survey.stations)} stops: {out}")
    typer.echo(f"Measure it: calibore profile {out} --out RESULT; its truth is in {out / 'truth.npz'}.")
