"""`calibore reproduce --out OUT`: the published numbers, tables and figures, computed anew."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._failure import wrong_usage
from calibore.cli._profile import Scheduler, as_json, progress_bar
from calibore.errors import InputError

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for page, JSON and pictures.")]
Processes = Annotated[int | None, typer.Option(min=1, help="Processes at work.", show_default="all cores")]
NOT_REPRODUCED = 1


class Size(StrEnum):
    """Of the experiment."""

    REDUCED = "reduced"
    FULL = "full"


def reproduce(
    out: Out,
    experiment: Annotated[
        bool,
        typer.Option(
            "--experiment", help="Chapters 6 to 8 instead: calibrate, scan, touch and compare a simulated pipe."
        ),
    ] = False,
    size: Annotated[
        Size, typer.Option(help="Of the experiment; full: 200 000 pictures of the head alone.")
    ] = Size.REDUCED,
    seed: Annotated[int, typer.Option(min=0, help="Of the experiment's noise.")] = 1,
    keep_pictures: Annotated[bool, typer.Option(help="Keep the experiment's pictures once measured.")] = False,
    workers: Processes = None,
    scheduler: Scheduler = None,
    json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Compute every number, table and figure of the dissertation anew and say where ours agree. Needs no input.

    With --experiment: an interrupted run goes on where it was when it is given the same folder again.
    """
    import os

    if experiment:
        from calibore.cli._reproduce_experiment import reproduce_experiment

        options: dict[str, Any] = {"workers": workers, "scheduler": scheduler, "keep_pictures": keep_pictures}
        reproduce_experiment(out, size=size.value, seed=seed, json=json, **options)
        return
    with wrong_usage():
        if scheduler or keep_pictures:
            raise InputError("--scheduler and --keep-pictures belong to --experiment; add it.")

    from calibore.reports import write_reproduction

    with progress_bar("Reproducing", quiet=json) as progress:
        facts = write_reproduction(out, workers=workers or os.cpu_count() or 1, progress=progress)
    if json:
        typer.echo(as_json(facts))
    else:
        show(facts, out)
    if facts["counts"]["not reproduced"]:
        raise typer.Exit(NOT_REPRODUCED)


def show(facts: dict[str, Any], out: Path) -> None:
    """How many agree, and which do not to the last digit."""
    counts = {verdict: count for verdict, count in facts["counts"].items() if verdict != "not published"}
    said = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
    typer.echo(f"{facts['published']} published numbers: {said}.")
    for value in facts["values"]:
        if value["verdict"] not in ("reproduced", "not published"):
            typer.echo(
                f"  {value['where']}: {value['what']}: {value['as_printed']}, ours {value['ours']:.5g}"
                f" ({value['verdict']})"
            )
    claims = facts["claims"]
    typer.echo(
        f"{len(facts['pictures'])} tables and figures; of what the text says of them {claims['holds']} statements "
        f"hold, {claims['in part']} in part, {claims['does not hold']} do not."
    )
    typer.echo(f"Page: {out / 'reproduction.html'}")
