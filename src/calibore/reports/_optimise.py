"""`write_optimisation`: rigs for a requirement in, a folder of rig files, chart, numbers and one page out."""

import base64
import json
from collections.abc import Mapping
from contextlib import AbstractContextManager
from importlib.resources import files
from pathlib import Path
from typing import Any

from calibore import __version__
from calibore.design import PARETO_FORMAT, Optimised, Verification, numbered, plain_optimisation
from calibore.folders import listed_in, whole_folder
from calibore.plotting import design_chart, length_unit, save_picture, save_vector
from calibore.reports._optimise_words import alternatives, budgets, recommendation, row
from calibore.rigs import write_rig

PARETO, PAGE, CHART, RIGS, RECOMMENDED = "pareto.json", "optimise.html", "pareto", "rigs", "recommended.toml"


def optimisation_folder(out: Path | str) -> AbstractContextManager[Path]:
    """A folder to be filled, that gets the name `out` when the block ends well. Raises OutputError before the block
    where `out` holds anything else.
    """
    return whole_folder(out, listed_in(PARETO, PARETO_FORMAT), what="choice of designs")


def write_optimisation(
    found: Optimised, out: Path | str, *, verified: Mapping[str, Verification], unit: str = "mm"
) -> dict[str, Any]:
    """`fill_optimisation` for a folder `out` that appears whole."""
    with optimisation_folder(out) as folder:
        return fill_optimisation(found, folder, verified=verified, unit=unit)


def fill_optimisation(
    found: Optimised, folder: Path, *, verified: Mapping[str, Verification], unit: str = "mm"
) -> dict[str, Any]:
    """Writes pareto.json, optimise.html, the chart as PNG and SVG, and every design as a rig file into `folder`;
    returns the JSON data. `verified`: by configuration, as `calibore.design.verify_best` gives it.
    """
    length_unit(unit)
    (folder / RIGS).mkdir()
    for name, option in numbered(found).items():
        write_rig(option.design.candidate.rig(found.wanted), folder / RIGS / f"{name}.toml")
    write_rig(found.recommended.design.candidate.rig(found.wanted), folder / RECOMMENDED)
    figure = design_chart(found, unit=unit)
    picture = save_picture(figure, folder / f"{CHART}.png")
    save_vector(figure, folder / f"{CHART}.svg")
    page = _page(found, verified, picture, unit)
    (folder / PAGE).write_text(page, encoding="utf-8", newline="\n")
    listed = sorted([path.name for path in folder.iterdir()] + [PARETO])
    plain = optimisation_data(found, verified, unit=unit) | {"files": listed}
    text = json.dumps(plain, indent=1, allow_nan=False) + "\n"
    (folder / PARETO).write_text(text, encoding="utf-8", newline="\n")
    return plain


def optimisation_data(found: Optimised, verified: Mapping[str, Verification], *, unit: str = "mm") -> dict[str, Any]:
    """All designs in SI, and the recommendation in words."""
    words = {"recommendation": recommendation(found, unit=unit), "alternatives": alternatives(found, unit=unit)}
    return {**plain_optimisation(found, verified), "calibore": __version__, **words}


def _page(found: Optimised, verified: Mapping[str, Verification], picture: Path, unit: str) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("optimise.html.jinja").read_text(encoding="utf-8")
    scale, names = length_unit(unit), {id(option): name for name, option in numbered(found).items()}

    def named(option: Any) -> dict[str, str]:
        return {"name": names[id(option)], **row(option, scale)}

    return environment.from_string(template).render(
        title=found.wanted.name,
        version=__version__,
        recommendation=recommendation(found, unit=unit),
        meets=found.recommended.meets,
        alternatives=alternatives(found, unit=unit),
        best=[named(option) for option in found.by_configuration.values()],
        budgets=budgets(found, unit=unit),
        cameras=[(name, named(option) if option else None) for name, option in found.by_camera.items()],
        designs=[named(option) for option in (*found.options, *found.partly)],
        verified=[(name, f"{one.ratio:.3f}", one.places, one.draws) for name, one in verified.items()],
        chart=base64.b64encode(picture.read_bytes()).decode("ascii"),
        stripe=f"{found.wanted.noise.stripe:g}",
        limit=f"{found.wanted.noise.length.at(found.wanted.nominal_radius) / scale.metres:.3g} {unit}",
    )
