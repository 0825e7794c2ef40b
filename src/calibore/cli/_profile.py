"""`calibore profile SCAN --out OUT`: a folder of laser-ring images in, a measured pipe out."""

import json as json_encoder
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from calibore.cli._failure import PARTLY_REFUSED, wrong_usage
from calibore.cli._probe import probe_made_from
from calibore.errors import UsageError

if TYPE_CHECKING:
    from calibore.crews import Workers as Crew
    from calibore.profiling import Finisher, Progress

Out = Annotated[Path, typer.Option("--out", "-o", help="Result folder; it appears when everything is done.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Threads.", show_default="all cores")]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Dask scheduler whose workers do it, e.g. tcp://10.0.0.5:8786; they see the same files."),
]
DIGITS = {"mm": 3, "in": 4}
UnitName = Annotated[str, typer.Option("--unit", help="Length unit of pictures and report: mm or in.")]


def profile(
    scan: Annotated[Path, typer.Argument(help="Scan folder, or its scan.toml.")],
    out: Out,
    estimator: Annotated[
        str,
        typer.Option(
            help="zero-crossing, parabola (the dissertation's), maximum, threshold, centroid, correlation, steger."
        ),
    ] = "zero-crossing",
    workers: Workers = None,
    scheduler: Scheduler = None,
    unit: UnitName = "mm",
    spacetime: Annotated[
        bool, typer.Option("--spacetime", help="Follow places through pictures closer together than the line is thick.")
    ] = False,
    pictures: Annotated[bool, typer.Option(help="Draw the pictures and the report.")] = True,
    exports: Annotated[
        list[str] | None, typer.Option("--export", help="Also write: text3, csv, netcdf, ply, las or laz (repeatable).")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Measure every cross-section of a scan: diameter, ovality, deflection, each with its uncertainty."""
    from calibore.profiling import profile_scan

    finish = _finisher(unit, pictures=pictures, exports=exports or [])
    with crew_of(workers, scheduler) as crew, probe_made_from(scan) as made:
        options: dict[str, Any] = {"finisher": made.put_beside(finish), "probe": made.probe} if made else {}
        with progress_bar("Profiling", quiet=json) as progress:
            options = {"finisher": finish, "workers": crew, "progress": progress} | options
            summary = profile_scan(scan, out, estimator=estimator, spacetime=spacetime, **options)
    tell(summary, out, unit=unit, json=json)
    if summary["counts"].get("refused_images") or summary["counts"].get("refused_readings"):
        raise typer.Exit(PARTLY_REFUSED)


def _finisher(unit: str, *, pictures: bool, exports: list[str]) -> "Finisher | None":
    """What draws pictures and writes exports; it is not even imported, which takes a second, where neither is asked."""
    if not (pictures or exports) and unit in DIGITS:
        return None
    from calibore.reports import finisher

    with wrong_usage():
        return finisher(unit=unit, pictures=pictures, exports=tuple(exports))


@contextmanager
def crew_of(workers: int | None, scheduler: str | None) -> Iterator["Crew | None"]:
    """Threads of this machine, all where none are given, or the machines behind a scheduler."""
    if scheduler is None:
        yield workers
        return
    if workers is not None:
        raise UsageError("Give either --workers, threads of this machine, or --scheduler.")
    from calibore.crews import Cluster

    with Cluster(scheduler) as cluster:
        yield cluster


@contextmanager
def progress_bar(what: str, *, quiet: bool) -> Iterator["Progress | None"]:
    """A progress bar on standard error while the block runs; nothing when `quiet` or when nobody is watching."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def tell(summary: dict[str, Any], out: Path, *, unit: str, json: bool) -> None:
    """The result in a few lines, or all of the summary as JSON; its warnings on standard error."""
    for warning in summary["warnings"]:
        typer.echo(f"Warning: {warning}", err=True)
    if json:
        typer.echo(as_json(summary))
        return
    for line in brief(summary, unit):
        typer.echo(line)
    report = out / "report.html"
    typer.echo(f"Result: {out}" + (f"   Report: {report}" if report.exists() else ""))


def brief(summary: dict[str, Any], unit: str) -> Iterator[str]:
    """What a contractor wants to read first, with 95 % uncertainties (k = 2)."""
    from calibore.units import parse_quantity

    counts, scale, digits = summary["counts"], parse_quantity(f"1 {unit}", "length"), DIGITS.get(unit, 3)
    source = _counted(counts["images"], "image") if "images" in counts else _counted(counts["readings"], "reading")
    yield (
        f"{_counted(counts['stations'], 'station')} from {source}, "
        f"{100 * summary['fraction_measured']:.1f} % of all positions measured."
    )
    mean, u_mean = summary["mean_diameter_m"] / scale, summary["u_mean_diameter_m"] / scale
    if mean == mean:
        yield f"Mean diameter {mean:.{digits}f} {unit} (U95 {2 * u_mean:.{digits}f})."
    for row in summary["worst_stations"][:1]:
        form = max(("max", "min"), key=lambda f: row[f"ovality_f1216_{f}_percent"])
        name = f"ovality_f1216_{form}_percent"
        if row[name] != row[name]:
            continue
        yield (
            f"Worst ovality {row[name]:.2f} % (U95 {2 * row['u_' + name]:.2f}) at station {row['station']}, "
            f"{row['axial_m'] / scale:.1f} {unit}; deflection there {row['deflection_percent']:.2f} % "
            f"(U95 {2 * row['u_deflection_percent']:.2f})."
        )


def as_json(value: Any, *, indent: int | None = 2) -> str:
    """`value` as JSON that every reader takes: what is not a finite number is null, and only ASCII leaves."""
    return json_encoder.dumps(_finite(value), indent=indent, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"
