"""`write_design`: an analysed design in, a folder of pictures, numbers and one page out."""

import base64
import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from calibore import __version__
from calibore.design import FORMAT, Analysis, plain_analysis
from calibore.folders import listed_in, whole_folder
from calibore.plotting import design_pictures, length_unit, limit_text, parameter_words, save_picture, save_vector
from calibore.reports._design_words import key_facts, verdicts

PAGE, MARKER = "design.html", "design.json"
Progress = Callable[[int, int | None], None]


def write_design(
    design: Analysis, out: Path | str, *, unit: str = "mm", command: str | None = None, progress: Progress | None = None
) -> dict[str, Any]:
    """Writes `out`/design.json, design.html and every picture as PNG and SVG, all or nothing; returns the JSON data."""
    length_unit(unit)
    with whole_folder(out, listed_in(MARKER, FORMAT), what="design") as folder:
        pictures = []
        for done, picture in enumerate(design_pictures(design, unit=unit), start=1):
            path = save_picture(picture.figure, folder / f"{picture.name}.png")
            picture.figure.set_layout_engine("none")  # it is laid out; doing so again takes as long as drawing
            save_vector(picture.figure, folder / f"{picture.name}.svg")
            data = base64.b64encode(path.read_bytes()).decode("ascii")
            pictures.append({"title": picture.title, "caption": picture.caption, "data": data})
            if progress:
                progress(done, None)
        (folder / PAGE).write_text(_page(design, pictures, unit=unit, command=command), encoding="utf-8", newline="\n")
        listed = sorted([path.name for path in folder.iterdir()] + [MARKER])
        plain = design_data(design, unit=unit) | {"files": listed}
        (folder / MARKER).write_text(json.dumps(plain, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return plain


def design_data(design: Analysis, *, unit: str = "mm") -> dict[str, Any]:
    """All numbers of a design in SI, what cannot be known as None, and its verdicts in words."""
    return {**plain_analysis(design), "calibore": __version__, "verdicts": verdicts(design, unit=unit)}


def _page(design: Analysis, pictures: list[dict[str, str]], *, unit: str, command: str | None) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("design.html.jinja").read_text(encoding="utf-8")
    scale = length_unit(unit)
    return environment.from_string(template).render(
        title=f"{design.rig.configuration} rig",
        nominal=f"{2 * design.nominal_radius / scale.metres:.4g} {scale.symbol}",
        version=__version__,
        command=command,
        coverage=f"{design.assumptions.coverage_factor:g}",
        published=not design.assumptions.correlated,
        facts=key_facts(design, unit=unit),
        verdicts=verdicts(design, unit=unit),
        tolerances=_tolerances(design, unit),
        target=_target(design, unit),
        parameters=_parameters(design, unit),
        pictures=pictures,
    )


def _tolerances(design: Analysis, unit: str) -> list[dict[str, str]]:
    scale, asked = length_unit(unit), design.tolerances
    rows = asked.rows if asked else ()
    return [
        {
            "name": parameter_words(row.name),
            "alone": limit_text(row.alone, row.unit, scale),
            "sharing": limit_text(row.sharing, row.unit, scale),
            "limits": "any" if row.limits is None else f"± {limit_text(row.limits, row.unit, scale)}",
        }
        for row in rows
    ]


def _target(design: Analysis, unit: str) -> str:
    if design.tolerances is None:
        return ""
    return limit_text(design.assumptions.coverage_factor * design.tolerances.target, "m", length_unit(unit))


def _parameters(design: Analysis, unit: str) -> list[dict[str, str]]:
    """Values and standard uncertainties of the rig, lengths in the reader's unit, angles in degrees."""
    from calibore.design import unit_of

    scale, rows = length_unit(unit), plain_analysis(design)["rig"]["parameters"]
    shown = []
    for row in rows:
        if row["value"] is None or (row["value"] == 0 and row["u"] is None):
            continue
        kind = unit_of(row["name"])
        factor = {"m": 1 / scale.metres, "rad": float(np.degrees(1.0))}.get(kind, 1.0)
        symbol = {"m": scale.symbol, "rad": "deg", "px": "px"}.get(kind, "")
        u = "not stated" if row["u"] is None else f"{row['u'] * factor:.2g}"
        shown.append({"name": row["name"], "value": f"{row['value'] * factor:.6g}", "u": u, "unit": symbol})
    return shown
