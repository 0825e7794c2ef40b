"""`calibore reproduce --out OUT`: the published numbers, tables and figures, computed anew."""

from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._profile import as_json, progress_bar

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for page, JSON and pictures; it appears when complete.")]
Processes = Annotated[int | None, typer.Option(min=1, help="Processes that draw.", show_default="all cores")]
NOT_REPRODUCED = 1


def reproduce(
    out: Out,
    workers: Processes = None,
    json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Compute every number, table and figure of the dissertation anew and say where ours agree. Needs no input."""
    import os

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
