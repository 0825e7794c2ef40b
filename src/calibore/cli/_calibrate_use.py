"""`calibore calibrate show | diff | plan`: what a calibration means, whether it still holds, which picture is next."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._calibrate_words import METRES, aligned, check_unit, plain, result_lines, significant
from calibore.cli._failure import wrong_usage
from calibore.cli._profile import as_json
from calibore.errors import InputError

UnitName = Annotated[str, typer.Option("--unit", help="Unit of printed lengths: mm or in.")]
Json = Annotated[bool, typer.Option("--json", help="Print everything as JSON.")]
Page = Annotated[Path | None, typer.Option("--out", "-o", help="Folder for a page with pictures.")]
Radius = Annotated[str, typer.Option(help="Nominal radius of the pipe.")]
NOT_ALIKE = 1


def show(
    file: Annotated[Path, typer.Argument(help="Calibration file.")],
    out: Page = None,
    inputs: Annotated[Path | None, typer.Option(help="Folder of its pictures: are they still the same?")] = None,
    radius: Annotated[str | None, typer.Option(help="Nominal radius of the pipe, for what it means there.")] = None,
    unit: UnitName = "mm",
    json: Json = False,
) -> None:
    """What a calibration means. Parameters, uncertainty on the wall and over the image, evidence; pictures too."""
    check_unit(unit)
    from calibore.calibration import read_calibration
    from calibore.cli._calibrate_meaning import meaning, meaning_lines

    found = read_calibration(file)
    for warning in found.warnings:
        typer.echo(f"Warning: {warning}", err=True)
    nominal = _radius(radius) if radius else None
    said = meaning(found, inputs=inputs, radius=nominal, file=file, length=unit)
    if out is not None:
        from calibore.reports import write_calibration_page

        said["page"] = str(write_calibration_page(found, out, nominal_radius=nominal, unit=unit))
    if json:
        typer.echo(as_json({**plain(found, file), **said}))
        return
    for line in (*result_lines(found, unit), *meaning_lines(said, unit)):
        typer.echo(line)
    if "page" in said:
        typer.echo(f"Page: {said['page']}")


def diff(
    first: Annotated[Path, typer.Argument(help="Calibration or rig file.")],
    second: Annotated[Path, typer.Argument(help="Another one, of the same camera or rig.")],
    radius: Radius = "6 in",
    out: Page = None,
    unit: UnitName = "mm",
    json: Json = False,
) -> None:
    """Whether it is the same camera as last year. Differences over the image and on the wall, with significance."""
    check_unit(unit)
    nominal = _radius(radius)
    from calibore.calibration import difference
    from calibore.rigs import read_rig_or_camera

    a, b = (read_rig_or_camera(one, drift=False) for one in (first, second))
    found = difference(a, b, nominal_radius=nominal)
    said = _plain_difference(found)
    if out is not None:
        from calibore.reports import write_difference_page

        said["page"] = str(write_difference_page(found, out, unit=unit))
    if json:
        typer.echo(as_json(said))
        return
    typer.echo(found.verdict(unit))
    if "page" in said:
        typer.echo(f"Page: {said['page']}")


def plan(
    rig: Annotated[Path, typer.Argument(help="Rig file with what is known of it now.")],
    target: Annotated[Path, typer.Argument(help="target.toml of the target at hand, or its folder.")],
    count: Annotated[int, typer.Option(min=1, help="How many pictures.")] = 3,
    radius: Radius = "6 in",
    out: Page = None,
    unit: UnitName = "mm",
    json: Json = False,
) -> None:
    """Which pictures to take next so that the wall is known best."""
    check_unit(unit)
    nominal = _radius(radius)
    from calibore.calibration import plan as planned
    from calibore.calibration import read_planned_target
    from calibore.rigs import read_rig

    found = planned(read_rig(rig), read_planned_target(target), nominal_radius=nominal, count=count)
    page = {}
    if out is not None:
        from calibore.reports import write_plan_page

        page = {"page": str(write_plan_page(found, out, unit=unit))}
    if json:
        steps = [{"picture": step.shot.said(unit), "u_m": step.u} for step in found.steps]
        said = {"nominal_radius_m": nominal, "before_u_m": found.before, "steps": steps, "advice": found.advice(unit)}
        typer.echo(as_json(said | page))
        return
    for line in _plan_lines(found, unit):
        typer.echo(line)
    if page:
        typer.echo(f"Page: {page['page']}")


def _plan_lines(found: Any, unit: str) -> Iterator[str]:
    size = METRES[unit]
    before = significant(found.before / size)
    yield f"On a wall of {found.nominal_radius / size:.4g} {unit} u of the radius is {before} {unit} now."
    steps = enumerate(found.steps, start=1)
    rows = [(f"{n}.", one.shot.said(unit), f"{significant(one.u / size)} {unit}") for n, one in steps]
    yield from aligned([("", "photograph the target", "then u is"), *rows], left=2)
    yield found.advice(unit)


def _radius(text: str) -> float:
    from calibore.units import parse_quantity

    with wrong_usage():
        radius = parse_quantity(text, "length")
        if not radius > 0:
            raise InputError(f'The nominal radius must be positive, not "{text}"; write e.g. "150 mm".')
        return radius


def _plain_difference(found: Any) -> dict[str, Any]:
    wall = found.wall
    return {
        "verdict": found.verdict(),
        "p": found.p,
        "nominal_radius_m": found.nominal_radius,
        "image": {"rms_px": found.directions.rms, "expected_px": found.directions.expected},
        "wall": wall
        and {"radius_m": wall.radius.tolist(), "rms_m": wall.rms.tolist(), "expected_m": wall.expected.tolist()},
        "changes": [{**one._asdict(), "sigmas": one.sigmas} for one in found.changes],
    }
