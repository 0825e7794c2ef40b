"""The pictures of a design, in the order in which its page shows them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from calibore.design import Analysis
from calibore.plotting._design_build import budget_chart, deployment_chart, tolerance_chart
from calibore.plotting._design_curves import (
    limits_chart,
    misalignment_chart,
    occlusion_chart,
    round_pipe_chart,
    sweep_chart,
)
from calibore.plotting._design_maps import design_map


@dataclass(frozen=True)
class DesignPicture:
    """A drawn `figure` with its file `name`, `title` and `caption`."""

    name: str
    title: str
    caption: str
    figure: Figure


CAPTIONS = {
    "map": "Orange: where a wall of the nominal radius appears. Where hatched or grey, the picture says why a pixel "
    "tells less, or nothing. Rows: measurement, expanded uncertainty.",
    "limits": "Between the curves a wall is seen, lit, and far enough from the frontier for first-order uncertainty.",
    "round_pipe": "Independent noise averages down over a ring; the common part moves all points together and stays.",
    "against_radius": "The walls it may meet: from half to twice the nominal radius.",
    "against_baseline": "Every baseline is a rig of its own, its camera opened as far as its limits ask.",
    "against_projection": "Every projection is a rig of its own, its camera opened as far as its limits ask.",
    "misalignment": "Uncertainty that is stated can be lived with; a misalignment that nobody knows of is an error.",
    "occlusion": "Shallow rays see less behind bumps. The longest shadow over all clocks counts.",
    "budget": "What to improve first: the longest bar.",
    "tolerances": "The limits are half widths of rectangular tolerances; the page's table has them alone and shared.",
    "deployment": "A stiff body; a hinge would let it pass, at a price in uncertainty.",
}


def design_pictures(design: Analysis, *, unit: str = "mm") -> Iterator[DesignPicture]:
    """Every picture that this design has, one after the other."""
    for one in design.maps:
        several = len(design.maps) > 1
        name, title = (f"map_laser_{one.laser + 1}", f"Maps of laser {one.laser + 1}") if several else ("map", "Maps")
        yield DesignPicture(name, title, CAPTIONS["map"], design_map(design, one, unit=unit))
    for name, title, figure in _charts(design, unit):
        if figure is not None:
            yield DesignPicture(name, title, CAPTIONS[name], figure)


def save_vector(figure: Figure, path: Path) -> Path:
    """`figure` as SVG; the same figure gives the same bytes. Returns `path`."""
    with mpl.rc_context({"svg.hashsalt": "calibore"}):
        figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
    return path


def _charts(design: Analysis, unit: str) -> Iterator[tuple[str, str, Figure | None]]:
    yield "limits", "Field of view and measuring limits", limits_chart(design, unit=unit)
    yield "round_pipe", "Uncertainty round the pipe", round_pipe_chart(design, unit=unit)
    sweep = design.radius
    title, label = "Uncertainty against measurement", "radius of the wall, in nominal radii"
    yield "against_radius", title, sweep_chart(design, sweep, title=title, label=label, at=1.0, unit=unit)
    yield from _built_anew(design, unit)
    yield "misalignment", "Misalignment", misalignment_chart(design, unit=unit)
    yield "occlusion", "Occlusion", occlusion_chart(design, unit=unit)
    yield "budget", "Budget", budget_chart(design, unit=unit)
    yield "tolerances", "Tolerances", tolerance_chart(design, unit=unit)
    yield "deployment", "Through the manhole", deployment_chart(design, unit=unit)


def _built_anew(design: Analysis, unit: str) -> Iterator[tuple[str, str, Figure | None]]:
    study = design.study
    if study is None:
        return
    if design.baseline is not None:
        label, at = f"{study.kind.baseline_name}, in nominal radii", float(study.baseline or 0.0)
        title = "Uncertainty against baseline"
        yield (
            "against_baseline",
            title,
            sweep_chart(design, design.baseline, title=title, label=label, at=at, unit=unit),
        )
    if design.projection is not None:
        title, at = "Uncertainty against projection", float(study.projection or 0.0)
        label = "projection: from the laser to where the nominal ring falls, in nominal radii"
        yield (
            "against_projection",
            title,
            sweep_chart(design, design.projection, title=title, label=label, at=at, unit=unit),
        )
