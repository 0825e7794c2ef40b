"""`calibore design CONFIGURATION --out DIR`: how well a rig will measure, before it is built."""

import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import typer

from calibore.cli._design_options import INPUTS, RIG, SAID, SAID_OF_RIG, TAKES, WISHES, with_options
from calibore.cli._failure import wrong_usage
from calibore.cli._optimise import optimise
from calibore.cli._profile import as_json, progress_bar

if TYPE_CHECKING:
    from calibore.design import Analysis, Assumptions, Wishes

design = typer.Typer(
    name="design",
    help="How well a rig will measure before it is built: maps, limits, charts, tolerances.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


def _study(configuration: str, given: dict[str, Any]) -> None:
    with wrong_usage():
        radius, limits, wishes = _common(given)
        kind = _numbers_of(given, radius)
        _check_unit(given["unit"])
    from calibore.design import Study, analyse

    assumptions = _assumptions(given, limits)

    across = given.get("view_across") or ("long" if given["as_published"] else "short")
    study = Study(configuration, radius, **kind, across=across, inputs=assumptions)
    _tell(analyse(study, wishes), given)


def _numbers_of(given: dict[str, Any], radius: float) -> dict[str, Any]:
    """What a `Study` takes, from the options that were given: lengths in nominal radii."""
    from calibore.errors import InputError
    from calibore.units import parse_quantity

    if given.get("view_across") not in (None, "short", "long"):
        raise InputError(f'--view-across must be short or long, got "{given["view_across"]}".')
    baseline = given.get("baseline") or given.get("offset")
    numbers: dict[str, Any] = {name: given[name] for name in ("width", "height", "lens", "beams") if name in given}
    if baseline is not None:
        numbers["baseline"] = _in_radii(baseline, radius)
    if given.get("projection") is not None:
        numbers["projection"] = _in_radii(given["projection"], radius)
    if "maximum" in given:
        numbers["maximum_radius"] = _in_radii(given["maximum"], radius)
    if "second_clock" in given:
        numbers["second_clock"] = parse_quantity(given["second_clock"], "angle")
    return numbers


def _of_file(given: dict[str, Any]) -> None:
    with wrong_usage():
        radius, limits, wishes = _common({**given, "length_limits": "0.001"})
        _check_unit(given["unit"])
    from calibore.design import analyse_rig
    from calibore.rigs import read_rig

    found = read_rig(given["file"])
    noise = found.stripe if given["pixel_noise"] is None else given["pixel_noise"]
    assumptions = _assumptions({"as_published": False, "pixel_noise": noise}, limits)
    _tell(analyse_rig(found, nominal_radius=radius, assumptions=assumptions, wishes=wishes), given)


def _common(given: dict[str, Any]) -> "tuple[float, float, Wishes]":
    """Nominal radius [m], limits of lengths in nominal radii, and wishes; raises InputError for text that is none."""
    from calibore.design import Wishes
    from calibore.units import parse_quantity

    radius = parse_quantity(given["radius"], "length")

    def length(name: str) -> float | None:
        return None if given[name] is None else _in_radii(given[name], radius) * radius

    wishes = Wishes(
        target=length("target"),
        manhole=parse_quantity(given["manhole"], "length"),
        body_length=length("body_length"),
        body_height=length("body_height"),
        bump=length("bump"),
    )
    return radius, _in_radii(given["length_limits"], radius), wishes


def _assumptions(given: dict[str, Any], limits: float) -> "Assumptions":
    from calibore.design import AS_PUBLISHED, HONEST

    noise = 1.0 if given["pixel_noise"] is None else given["pixel_noise"]
    if given["as_published"]:
        return replace(AS_PUBLISHED, length=limits, u_pixel=noise)
    return replace(HONEST, length=limits / 3**0.5, u_pixel=noise)


def _in_radii(text: str, radius: float) -> float:
    """A pure number of nominal radii, or a length over the nominal radius."""
    from calibore.units import parse_quantity

    try:
        return float(text)
    except ValueError:
        return parse_quantity(text, "length") / radius


def _check_unit(unit: str) -> None:
    from calibore.plotting import length_unit

    length_unit(unit)


def _tell(found: "Analysis", given: dict[str, Any]) -> None:
    from calibore.reports import write_design

    out, unit, json = given["out"], given["unit"], given["json"]
    command = " ".join(["calibore", *(f'"{word}"' if " " in word else word for word in sys.argv[1:])])
    with progress_bar("Drawing", quiet=json) as progress:
        plain = write_design(found, out, unit=unit, command=command, progress=progress)
    if json:
        typer.echo(as_json(plain))
        return
    for sentence in plain["verdicts"]:
        typer.echo(sentence)
    typer.echo(f"Design: {out}   Page: {out / 'design.html'}")


def _command(configuration: str) -> Any:
    names = ("out", "radius", *TAKES[configuration], *INPUTS, *WISHES)
    return with_options(lambda **given: _study(configuration, given), names, SAID[configuration])


for name in TAKES:
    design.command(name)(_command(name))
design.command("rig")(with_options(lambda **given: _of_file(given), RIG, SAID_OF_RIG))
design.command("optimise")(optimise)
