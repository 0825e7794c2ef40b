"""The standard pictures of a profile, in the order in which a report shows them; a caption says how to read each."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from calibore.plotting._along import diameter_along, ovality_along
from calibore.plotting._maps import deviation_map, uncertainty_map
from calibore.plotting._sections import worst_sections
from calibore.plotting._shaded import shaded_view


@dataclass(frozen=True)
class Picture:
    """A standard picture: file `name` without ending, `title`, `caption`, and the function that draws it."""

    name: str
    title: str
    caption: str
    draw: Callable[..., Figure]

    def __call__(self, dataset: Any, rings: Any, *, nominal_radius: float, unit: str = "mm", **options: Any) -> Figure:
        return self.draw(dataset, rings, nominal_radius=nominal_radius, unit=unit, **options)


DETECTED_LINE_TITLE = "Detected line"
DETECTED_LINE_CAPTION = (
    "One camera image with the points found on the laser line. Rays without a point are marked outside the "
    "ring, each kind of mark one reason. The close-ups show single pixels: the points should run along the "
    "middle of the bright line."
)

STANDARD_PICTURES: tuple[Picture, ...] = (
    Picture(
        "deviation_map",
        "Deviation map",
        "The wall cut open along the invert and laid flat, seen from inside: travel to the right, crown in "
        "the middle, 3 h above it and 9 h below. Red lies outside the nominal radius, blue inside, white on "
        "it. Grey was not measured: it says nothing about the wall.",
        deviation_map,
    ),
    Picture(
        "worst_sections",
        "Worst cross-sections",
        "Looking along travel, 12 h at the top and 3 h on the right. The dashed circle is the nominal pipe; "
        "the title says how many times deviations from it are enlarged, and the thin circles carry their "
        "size. Thick grey arcs were not measured.",
        worst_sections,
    ),
    Picture(
        "ovality_along",
        "Ovality along the pipe",
        "Where the ovality of the diameters rises above that of the second harmonic, the section is not an "
        "ellipse: look for a dent, a deposit or an opening there. Bands are 95 % for each station on its own.",
        ovality_along,
    ),
    Picture(
        "diameter_along",
        "Diameters along the pipe",
        "Mean, smallest and largest diameter of every ring. The part of the band that the whole scan has in "
        "common moves all curves together: differences between stations are known better than the bands suggest.",
        diameter_along,
    ),
    Picture(
        "shaded_view",
        "Shaded view",
        "Both halves of the pipe, cut open lengthwise, coloured as the deviation map. Grey faces were not "
        "measured and are drawn at the nominal radius.",
        shaded_view,
    ),
    Picture(
        "uncertainty_map",
        "Uncertainty map",
        "Expanded uncertainty (k = 2) of every radius, laid out as the deviation map. A deviation smaller "
        "than this is not evidence of anything.",
        uncertainty_map,
    ),
)
