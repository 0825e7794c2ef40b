"""`calibore design optimise SPEC.toml`: a requirement in, the rigs worth building out."""

import os
from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._failure import wrong_usage
from calibore.cli._profile import UnitName, as_json, progress_bar


def optimise(
    spec: Annotated[Path, typer.Argument(help="Requirement file (format calibore-design/1).")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Result folder; it appears when everything is done.")],
    workers: Annotated[int | None, typer.Option(min=1, help="Processes.", show_default="all cores")] = None,
    verify: Annotated[bool, typer.Option(help="Put the best of each configuration to the test by simulation.")] = True,
    unit: UnitName = "mm",
    json: Annotated[bool, typer.Option("--json", help="Print all designs as JSON.")] = False,
) -> None:
    """Find the rigs worth building for a pipe, a budget, a crawler and a list of cameras, and recommend one."""
    from calibore.design import optimise as search
    from calibore.design import read_requirement, verify_best
    from calibore.plotting import length_unit
    from calibore.reports import fill_optimisation, optimisation_folder

    with wrong_usage():
        length_unit(unit)
    wanted = read_requirement(spec)
    with optimisation_folder(out) as folder:
        with progress_bar("Searching", quiet=json) as progress:
            found = search(wanted, workers=workers or os.cpu_count() or 1, progress=progress)
        verified = {}
        if verify:
            with progress_bar("Simulating", quiet=json) as progress:
                verified = verify_best(found, progress=progress)
        plain = fill_optimisation(found, folder, verified=verified, unit=unit)
    if json:
        typer.echo(as_json(plain))
        return
    _tell(plain, out)


def _tell(plain: dict[str, Any], out: Path) -> None:
    for sentence in (*plain["recommendation"], *plain["alternatives"]):
        typer.echo(sentence)
    for name, one in plain["verification"].items():
        typer.echo(f"Simulated over predicted uncertainty, {name}: {one['ratio']:.3f}.")
    typer.echo(f"Rig: {out / 'recommended.toml'}   Page: {out / 'optimise.html'}")
