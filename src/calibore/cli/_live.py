"""`calibore live SOURCE --out OUT`: pictures that are being taken in, a measured pipe out."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from calibore.cli._failure import PARTLY_REFUSED, wrong_usage
from calibore.cli._live_watch import watch_of
from calibore.cli._profile import Out, UnitName, Workers, as_json, tell

if TYPE_CHECKING:
    from threading import Event


class Drop(StrEnum):
    """What becomes of pictures that come faster than they can be measured."""

    OLDEST = "oldest"
    NEVER = "never"


def live(
    source: Annotated[
        str, typer.Argument(help="Folder that is being filled, its scan.toml, rtsp://... or a device: 0, /dev/video0.")
    ],
    out: Out,
    scan: Annotated[Path | None, typer.Option(help="scan.toml that describes the source.")] = None,
    rig: Annotated[Path | None, typer.Option(help="Rig file, where a stream has no scan.toml.")] = None,
    radius: Annotated[
        str | None, typer.Option(help='Nominal radius, e.g. "6 in", where there is no scan.toml.')
    ] = None,
    step: Annotated[str | None, typer.Option(help='Travel from picture to picture, e.g. "2 mm".')] = None,
    speed: Annotated[str | None, typer.Option(help='Speed of travel, e.g. "100 mm/s".')] = None,
    odometry: Annotated[Path | None, typer.Option(help="Table time_s,axial_m[,roll_rad]; it may be growing.")] = None,
    drop: Annotated[
        Drop | None,
        typer.Option(help="When pictures come too fast: oldest or never.", show_default="streams: oldest"),
    ] = None,
    waiting: Annotated[int, typer.Option(min=1, help="Pictures that may wait to be measured.")] = 4,
    count: Annotated[int | None, typer.Option(min=1, help="Stop after so many rings.")] = None,
    duration: Annotated[float | None, typer.Option(min=0.0, help="Stop after so many seconds.")] = None,
    idle: Annotated[float | None, typer.Option(min=0.0, help="Stop after so many seconds without a picture.")] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where a run was killed.")] = False,
    finish: Annotated[bool, typer.Option("--finish", help="Only write out what a killed run had measured.")] = False,
    estimator: Annotated[str, typer.Option(help="As of calibore profile.")] = "zero-crossing",
    workers: Workers = None,
    unit: UnitName = "mm",
    pictures: Annotated[bool, typer.Option(help="Draw the pictures and the report at the end.")] = True,
    exports: Annotated[list[str] | None, typer.Option("--export", help="As of calibore profile.")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Nothing on standard output.")] = False,
    json: Annotated[bool, typer.Option("--json", help="A line of JSON for every ring, the summary last.")] = False,
) -> None:
    """Measure pictures while they are taken: camera, network stream, folder that is being filled. Ctrl-C ends it."""
    from calibore.acquisition import Limits, Wanted, default_workers, described, live_scan, speed_of
    from calibore.reports import finisher
    from calibore.units import parse_quantity

    with wrong_usage():
        finishing = finisher(unit=unit, pictures=pictures, exports=tuple(exports or ()))
        wanted = Wanted(
            source,
            scan,
            rig,
            None if radius is None else parse_quantity(radius, "length"),
            None if step is None else parse_quantity(step, "length"),
            None if speed is None else speed_of(speed),
            odometry,
            estimator,
            workers or default_workers(),
            waiting,
            None if drop is None else drop is Drop.NEVER,
            idle,
        )
    job, opened = described(wanted)
    limits = Limits(count, duration)
    with stopping(limits.stop), watch_of(unit=unit, json=json, quiet=quiet) as watch:
        options: dict[str, Any] = {"limits": limits, "watch": watch, "finisher": finishing}
        summary = live_scan(job, opened, out, resume=resume, finish_only=finish, **options)
    if json or quiet:
        for warning in summary["warnings"]:
            typer.echo(f"Warning: {warning}", err=True)
    if json:
        typer.echo(as_json({"summary": summary}, indent=None))
    elif not quiet:
        tell(summary, out, unit=unit, json=False)
    if summary["counts"]["refused_images"]:
        raise typer.Exit(PARTLY_REFUSED)


@contextmanager
def stopping(stop: "Event") -> Iterator[None]:
    """Ctrl-C, or a polite request to end, finishes the run with a whole result; a second one gives it up."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.getsignal(number) for number in numbers}

    def ask(number: int, frame: object) -> None:
        stop.set()
        for number in numbers:
            signal.signal(number, before[number])

    for number in numbers:
        signal.signal(number, ask)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, before[number])
