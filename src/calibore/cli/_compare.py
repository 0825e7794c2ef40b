"""`calibore compare A B`: errors of a measurement against a reference, or what has changed between two epochs."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from calibore.cli._compare_options import alignment_of, date_of, outlier_rule_of, years_between
from calibore.cli._failure import PARTLY_REFUSED, wrong_usage
from calibore.cli._probe import probe_made_from
from calibore.cli._profile import UnitName, Workers, as_json, progress_bar
from calibore.errors import InputError

if TYPE_CHECKING:
    from datetime import date

    from calibore.scans import Profile

Input = "result folder of `calibore profile`, or scan folder (it is profiled first)"
REFUSED = ("refused_images", "refused_readings")


@dataclass
class _Side:
    """One of the two inputs, and whether part of it was refused."""

    path: Path
    kind: str
    tactile: bool
    name: str
    partly: bool = False


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help=f"First {Input}.")],
    b: Annotated[Path, typer.Argument(metavar="B", help=f"Second {Input}.")],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Folder of the result.", show_default="A-B")] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            help="a or b: errors of the other one against it; none: change from A to B.",
            show_default="the only tactile scan of both, else none",
        ),
    ] = None,
    free: Annotated[
        str,
        typer.Option(
            help="What may move: rigid (roll, shift_x, shift_y, axial, tilt_x, tilt_y), none, or names with commas; "
            "stretch and scale too."
        ),
    ] = "rigid",
    start: Annotated[str, typer.Option(help='Known motion onto the reference: "roll=0.3 deg, axial=2 mm".')] = "",
    search: Annotated[bool, typer.Option(help="Try motions round the start, or keep to it.")] = True,
    per_ring: Annotated[bool, typer.Option("--per-ring", help="Let every ring turn and shift a little.")] = False,
    outliers: Annotated[str, typer.Option(help='Errors that do not count: "0.15 in", or "4 sigma".')] = "0.15 in",
    false_alarm: Annotated[float, typer.Option(help="Probability that an unchanged pipe shows any change.")] = 0.05,
    date_a: Annotated[
        str | None, typer.Option(help="Day of A, for rates per year: 2024-05-31.", show_default="date in scan.toml")
    ] = None,
    date_b: Annotated[str | None, typer.Option(help="Day of B.", show_default="date in scan.toml")] = None,
    workers: Workers = None,
    unit: UnitName = "mm",
    pictures: Annotated[bool, typer.Option(help="Draw the pictures and the report.")] = True,
    json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Compare two scans of one pipe: the error of a measurement, or the change between two epochs, with uncertainty."""
    with wrong_usage():
        alignment = alignment_of(free, start, search=search, per_ring=per_ring)
        rule = outlier_rule_of(outliers)
        days = date_of(date_a, "--date-a"), date_of(date_b, "--date-b")
        years_between(*days)
        _check(reference, false_alarm, unit)
    from calibore.comparison import Compared, compared
    from calibore.reports import write_comparison

    sides = _sides(a, b)
    which = _reference(reference, sides)
    with wrong_usage():
        if which is not None and any(days):
            raise InputError("Dates give a rate of change, not of errors; leave them out or add --reference none.")
    out = out or Path(f"{sides[0].name}-{sides[1].name}")
    _keep_apart(out, sides)

    def make(folder: Path) -> Compared:
        profiles = [
            _profile(side, folder / place, workers=workers, quiet=json)
            for side, place in zip(sides, ("profile-a", "profile-b"), strict=True)
        ]
        still = 0 if which is None else which
        names = sides[1 - still].name, sides[still].name
        years = None if which is not None else _years(days, profiles)
        options = {"rule": rule, "false_alarm": false_alarm, "years": years, **alignment}
        return compared(profiles[1 - still], profiles[still], epochs=which is None, names=names, **options)

    _tell(write_comparison(make, out, unit=unit, pictures=pictures), out, json=json)
    if any(side.partly for side in sides):
        raise typer.Exit(PARTLY_REFUSED)


def _years(days: "tuple[date | None, date | None]", profiles: "list[Profile]") -> float | None:
    """Between both epochs, by the options where they are given, else by the scans' own dates."""
    known = [day or profile.date for day, profile in zip(days, profiles, strict=True)]
    if any(days) and not all(known):
        lacks = "AB"[known.index(None)]
        raise InputError(
            f"A rate needs both dates; give --date-{lacks.lower()} too, or date in the scan.toml of {lacks}."
        )
    return years_between(known[0], known[1])


def _check(reference: str | None, false_alarm: float, unit: str) -> None:
    from calibore.plotting import length_unit

    length_unit(unit)
    if reference is not None and reference.lower() not in ("a", "b", "none"):
        raise InputError(f'--reference must be a, b or none, got "{reference}".')
    if not 0 < false_alarm < 1:
        raise InputError(f"--false-alarm is a probability between 0 and 1, got {false_alarm:g}.")


def _sides(a: Path, b: Path) -> tuple[_Side, _Side]:
    from calibore.comparison import is_tactile_result, kind_of
    from calibore.scans import read_scan

    found = []
    for path in (a, b):
        kind = kind_of(path)
        tactile = is_tactile_result(path) if kind == "result" else read_scan(path).tactile is not None
        folder = path.resolve()
        found.append(_Side(path, kind, tactile, folder.parent.name if folder.is_file() else folder.name))
    one, other = found
    if one.name == other.name and one.path.resolve() != other.path.resolve():
        one.name, other.name = (f"{s.path.resolve().parent.name}-{s.name}" for s in found)
    return one, other


def _reference(asked: str | None, sides: tuple[_Side, _Side]) -> int | None:
    """Which side is the reference; None where two epochs are compared."""
    if asked is not None:
        return {"a": 0, "b": 1, "none": None}[asked.lower()]
    touched = [side.tactile for side in sides]
    return touched.index(True) if sum(touched) == 1 else None


def _keep_apart(out: Path, sides: tuple[_Side, _Side]) -> None:
    """What is compared must not lie where the result goes: an earlier one there is replaced as a whole."""
    for side in sides:
        if out.resolve() in (side.path.resolve(), *side.path.resolve().parents):
            raise InputError(f"{side.path} lies in the result folder {out}, which is replaced; choose another --out.")


def _profile(side: _Side, place: Path, *, workers: int | None, quiet: bool) -> "Profile":
    """The profile of one side, measured into `place` first where it is a scan."""
    from calibore.scans import read_profile

    if side.kind == "result":
        return read_profile(side.path)
    from calibore.profiling import profile_scan
    from calibore.reports import finisher

    finish = finisher(pictures=False)
    with probe_made_from(side.path) as made, progress_bar(f"Profiling {side.name}", quiet=quiet) as progress:
        options: dict[str, Any] = {"finisher": made.put_beside(finish), "probe": made.probe} if made else {}
        options = {"finisher": finish, "workers": workers, "progress": progress} | options
        summary = profile_scan(side.path, place, **options)
    for warning in summary["warnings"]:
        typer.echo(f"Warning: {side.name}: {warning}", err=True)
    side.partly = any(summary["counts"].get(name) for name in REFUSED)
    return read_profile(place)


def _tell(summary: dict[str, Any], out: Path, *, json: bool) -> None:
    for warning in summary["warnings"]:
        typer.echo(f"Warning: {warning}", err=True)
    if json:
        typer.echo(as_json(summary))
        return
    for sentence in summary["answer"]:
        typer.echo(sentence)
    report = out / "report.html"
    typer.echo(f"Comparison: {out}" + (f"   Report: {report}" if report.exists() else ""))
