"""The options of `calibore design`, and which configuration takes which."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

SIZES = "As a length with its unit, or as a number of nominal radii."
OPTIONS: dict[str, tuple[Any, Any]] = {
    "file": (Annotated[Path, typer.Argument(help="A rig file.")], ...),
    "out": (Annotated[Path, typer.Option("--out", "-o", help="Folder for pictures, numbers and the page.")], ...),
    "radius": (Annotated[str, typer.Option(help="Nominal radius of the pipe.")], "6 in"),
    "baseline": (Annotated[str | None, typer.Option(help=f"From camera to light. {SIZES}")], None),
    "offset": (Annotated[str | None, typer.Option(help=f"From camera to the cone's apex, ahead. {SIZES}")], None),
    "projection": (Annotated[str | None, typer.Option(help=f"From laser to where the ring falls. {SIZES}")], None),
    "second_clock": (Annotated[str, typer.Option(help="Where the second laser stands, from the crown.")], "-90 deg"),
    "beams": (Annotated[int, typer.Option(min=1, help="Number of beams, evenly round.")], 8),
    "maximum": (Annotated[str, typer.Option(help=f"Largest radius the camera must see. {SIZES}")], "2"),
    "view_across": (
        Annotated[str | None, typer.Option(help="Axis of the image that holds the field of view: short or long.")],
        None,
    ),
    "width": (Annotated[int, typer.Option(min=1, help="Pixels.")], 1024),
    "height": (Annotated[int, typer.Option(min=1, help="Pixels.")], 768),
    "lens": (
        Annotated[str, typer.Option(help="perspective, stereographic, equidistant, sine-law or equisolid-angle.")],
        "equidistant",
    ),
    "pixel_noise": (
        Annotated[float | None, typer.Option(help="Standard uncertainty of a line position, px (1).")],
        None,
    ),
    "length_limits": (
        Annotated[str, typer.Option("--length-uncertainty", help=f"Limits to which lengths are known. {SIZES}")],
        "0.001",
    ),
    "as_published": (
        Annotated[bool, typer.Option("--as-published", help="The dissertation's assumptions instead of honest ones.")],
        False,
    ),
    "target": (Annotated[str | None, typer.Option(help=f"Wanted U of R (0.005 radii). {SIZES}")], None),
    "manhole": (Annotated[str, typer.Option(help="Diameter of the manhole.")], "24 in"),
    "body_length": (Annotated[str | None, typer.Option(help=f"Of the crawler (2 radii). {SIZES}")], None),
    "body_height": (Annotated[str | None, typer.Option(help=f"Of the crawler (1 radius). {SIZES}")], None),
    "bump": (Annotated[str | None, typer.Option(help=f"Height of a bump (0.02 radii). {SIZES}")], None),
    "unit": (Annotated[str, typer.Option("--unit", help="Length unit of pictures and page: mm or in.")], "mm"),
    "json": (Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")], False),
}
CAMERA = ("width", "height", "lens")
INPUTS = ("pixel_noise", "length_limits", "as_published")
WISHES = ("target", "manhole", "body_length", "body_height", "bump", "unit", "json")
RIG = ("file", "out", "radius", "pixel_noise", *WISHES)
SAID_OF_RIG = "Any rig that a rig file describes, with the uncertainties it states."
CONE = ("baseline", "projection", "view_across")
TAKES: dict[str, tuple[str, ...]] = {
    "perpendicular-plane": ("baseline", "maximum", *CAMERA),
    "single-cone": (*CONE, *CAMERA),
    "dual-cone": (*CONE, "second_clock", *CAMERA),
    "side-facing": ("baseline", "maximum", *CAMERA),
    "coaxial-cone": ("offset", "projection", "maximum", *CAMERA),
    "asymmetric-cone": (*CONE, *CAMERA),
    "reversed-cone": ("offset", "projection", "maximum", *CAMERA),
    "rotating-spot": ("baseline", "maximum", "width", "lens"),
    "spot-array": ("baseline", "maximum", "beams", *CAMERA),
}
"""Besides --out, --radius, the inputs and the wishes, which all take."""
SAID = {
    "perpendicular-plane": "A plane of light across the pipe, ahead of the camera.",
    "single-cone": "One cone of light from a laser beside the camera.",
    "dual-cone": "Two cones of light from lasers beside the camera.",
    "side-facing": "A camera beside a sheet of light, on a head that turns.",
    "coaxial-cone": "A cone of light about the camera's axis.",
    "asymmetric-cone": "A cone of light beside the camera, axes parallel.",
    "reversed-cone": "A cone of light from ahead, falling back.",
    "rotating-spot": "A turning spot of light, seen by a line sensor.",
    "spot-array": "Single beams, evenly round the pipe.",
}


def with_options(command: Callable[..., None], names: tuple[str, ...], said: str) -> Callable[..., None]:
    """`command(**options)` as a function whose signature Typer can read: the options of `names`, by keyword."""

    def run(**given: Any) -> None:
        command(**given)

    parameters, annotations = [], {}
    for name in names:
        annotation, default = OPTIONS[name]
        default = inspect.Parameter.empty if default is ... else default
        parameters.append(
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        )
        annotations[name] = annotation
    run.__signature__ = inspect.Signature(parameters)  # pyright: ignore[reportFunctionMemberAccess]
    run.__annotations__, run.__doc__ = annotations, said
    return run
