"""`calibore import SCAN --out ARCHIVE`: a scan whose pictures are in one lossless, checksummed archive."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._failure import PARTLY_REFUSED
from calibore.cli._profile import Workers, as_json, progress_bar

SHOWN = 5
"""Refused images that are worth naming one by one."""


def import_scan(
    scan: Annotated[Path, typer.Argument(help="Scan folder, or its scan.toml.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="New folder; it appears when all pictures are in.")],
    workers: Workers = None,
    json: Annotated[bool, typer.Option("--json", help="Print what was done as JSON.")] = False,
) -> None:
    """Pack the pictures of a scan into an archive that profile reads like the scan, only faster. Lossless, with
    checksums; run again after an interruption, it goes on where it was.
    """
    from calibore.profiling import archive_scan

    with progress_bar("Importing", quiet=json) as progress:
        done = archive_scan(scan, out, workers=workers, progress=progress)
    for line in _refused(done["refused"]):
        typer.echo(f"Warning: {line}", err=True)
    if json:
        typer.echo(as_json(done))
    else:
        images, files, stored = done["counts"]["images"], done["bytes_of_files"], done["bytes_in_archive"]
        typer.echo(f"{images} image{'s' * (images != 1)}: {_size(files)} of files, {_size(stored)} in the archive.")
        typer.echo(f"Measure it: calibore profile {out} --out RESULT")
    if done["refused"]:
        raise typer.Exit(PARTLY_REFUSED)


def _refused(images: list[dict[str, Any]]) -> Iterator[str]:
    for image in images[:SHOWN]:
        yield f'image "{image["image"]}" left out: {image["reason"]}.'
    if len(images) > SHOWN:
        yield f"{len(images) - SHOWN} more left out; import.jsonl in the archive names them."


def _size(count: int) -> str:
    for unit, scale in (("GB", 1e9), ("MB", 1e6)):
        if count >= scale:
            return f"{count / scale:.3g} {unit}"
    return f"{count / 1e3:.3g} kB"
