"""`calibore export RESULT FORMAT`: a result written for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from calibore.cli._failure import wrong_usage


def export(
    result: Annotated[Path, typer.Argument(help="Result folder of `calibore profile`.")],
    format: Annotated[str, typer.Argument(help="text3 (axial, clock, radius), csv, netcdf, ply, las or laz.")],
    to: Annotated[Path | None, typer.Option("--to", help="File to write; by default inside the result folder.")] = None,
) -> None:
    """Write a finished result as text, CSV, NetCDF, PLY or LAS/LAZ, uncertainties included."""
    from calibore.scans import default_export_name
    from calibore.scans import export as write

    with wrong_usage():
        name = default_export_name(format)
    typer.echo(f"Wrote {write(result, format, to or result / name)}")
