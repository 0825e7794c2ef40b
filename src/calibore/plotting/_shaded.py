"""The wall as a solid: two half pipes, cut open lengthwise, shaded and coloured by deviation.

Drawn with two-dimensional polygons: parallel projection, the half that faces the viewer removed, so that nothing hides
anything and no three-dimensional toolkit is needed. The two views together show the whole wall once.
"""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from calibore.geometry import xy_of
from calibore.plotting._figures import FAINT_INK, INK, MISSING_GREY, SMALL_SIZE, TEXT_SIZE, new_figure
from calibore.plotting._lengths import checked_radius, length_unit
from calibore.plotting._maps import DEVIATION_COLOURS, LONE_WIDTH, add_colour_bar, robust_limit
from calibore.plotting._sections import exaggeration_for
from calibore.plotting._solid import Mesh, View, mesh_of
from calibore.plotting._stations import Floats, Layout, block_extremes, block_starts, lay_out, thinned, thinning_note
from calibore.plotting._walls import wall_of

MOST_RINGS, MOST_FACES_ROUND = 160, 200
SHORTEST, LONGEST = 1.2, 5.0
"""Drawn length in diameters; a pipe outside this range is stretched or compressed lengthwise, and a note says so."""

BESIDE = 4.0
"""Halves shorter than this many radii stand side by side, longer ones above each other."""

LEAST_WIDTH = 2.8
"""Nominal radii; a single ring is narrower than the words about it."""

RULER = 1.45
"""Depth of the axial ruler below the axis, in nominal radii."""


def shaded_view(
    dataset: Any, rings: Any, *, nominal_radius: float, unit: str = "mm", limit: float | None = None
) -> Figure:
    """The wall as two opened halves coloured by deviation; colours end at +-`limit` [m] (default: as in the map)."""
    scale, wall = length_unit(unit), wall_of(dataset, rings)
    deviation = wall.radius - checked_radius(nominal_radius)
    lone_width = LONE_WIDTH * nominal_radius
    full = lay_out(dataset["axial"].values, dataset["station"].values, unit=unit, lone_width=lone_width)
    layout, columns = thinned(full, MOST_RINGS)
    rows = block_starts(deviation.shape[1], MOST_FACES_ROUND)
    shown = block_extremes(block_extremes(deviation[full.order], columns), rows, axis=1)
    stretch, stretch_note = _axial_stretch(layout, nominal_radius)
    factor = exaggeration_for(deviation, nominal_radius, room=0.15, most=0.35)
    mesh = mesh_of(layout, _row_edges(wall.clock, rows), shown / nominal_radius, exaggeration=factor, stretch=stretch)
    beside = float(layout.right[-1] - layout.left[0]) * stretch < BESIDE
    drawn = f"enlarged {factor}x" if factor > 1 else "to scale (1x)"
    notes = [f"{stretch_note}; deviations {drawn}; parallel projection; together the two halves show the whole wall"]
    figure = new_figure(
        4.6 if beside else 7.0,
        title="Shaded view of the wall, cut open lengthwise",
        notes=notes + thinning_note(len(full.position), len(columns)),
    )
    end = limit / scale.metres if limit else robust_limit(deviation / scale.metres)
    colours = ScalarMappable(Normalize(-end, end), mpl.colormaps[DEVIATION_COLOURS].with_extremes(bad=MISSING_GREY))
    panels = list(np.ravel(figure.subplots(1, 2) if beside else figure.subplots(2, 1)))
    for axes, side in zip(panels, (1, -1), strict=True):
        view = View.of(side)
        _draw_half(axes, view, mesh, colours, nominal_radius / scale.metres)
        _draw_ruler(axes, view, layout, stretch)
        _label_hours(axes, view, float(layout.left[0] - layout.right[-1]) / 2 * stretch)
    label = f"deviation from nominal [{scale.symbol}], + outward"
    _add_colours(figure, panels, colours, label, deviation / scale.metres)
    return figure


def _axial_stretch(layout: Layout, nominal_radius: float) -> tuple[float, str]:
    """Nominal radii per unit of the axis, and the sentence that says how the axis is drawn."""
    length = float(layout.right[-1] - layout.left[0])
    if layout.unit is None:
        return 2 * LONGEST / length / 2, "No axial positions: stations drawn side by side"
    true = layout.unit.metres / nominal_radius
    if len(layout.position) == 1:
        return true, f"A single ring, drawn {LONE_WIDTH:g} radii wide"
    drawn = float(np.clip(length * true, 2 * SHORTEST, 2 * LONGEST))
    factor = drawn / (length * true)
    if abs(factor - 1) < 1e-9:
        return true, "Axial and radial scale equal"
    change = f"stretched {factor:.3g}x" if factor > 1 else f"compressed {1 / factor:.3g}x"
    return true * factor, f"Axial scale {change}"


def _row_edges(clock: Floats, rows: Any) -> Floats:
    lower = (clock - np.diff(clock, prepend=clock[-1] - 2 * np.pi) / 2)[rows]
    return np.append(lower, lower[0] + 2 * np.pi)


def _draw_half(axes: Axes, view: View, mesh: Mesh, colours: ScalarMappable, display_radius: float) -> None:
    seen = np.flatnonzero(mesh.visible_from(view))
    seen = seen[np.argsort(mesh.corners[seen].mean(axis=1) @ view.towards)]
    tint = np.asarray(colours.to_rgba(np.ma.masked_invalid(mesh.deviation[seen] * display_radius)))
    tint[:, :3] *= mesh.brightness(view)[seen, None]
    faces = PolyCollection(list(view.page(mesh.corners[seen])), facecolors=tint, edgecolors=tint, linewidths=0.35)
    axes.add_collection(faces)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set_title(f"the {view.hour} h half, seen from the {12 - view.hour} h side", size=TEXT_SIZE, color=INK)


def _draw_ruler(axes: Axes, view: View, layout: Layout, stretch: float) -> None:
    """A ruler under the invert with the axial positions, and an arrow along travel."""
    low, high = float(layout.left[0]), float(layout.right[-1])
    middle = (low + high) / 2

    def at(position: float, depth: float) -> Floats:
        return view.page(np.array([0.0, depth, (position - middle) * stretch]))

    axes.plot(*np.transpose([at(low, RULER), at(high, RULER)]), color=FAINT_INK, linewidth=0.9)
    lone = len(layout.position) == 1
    ticks = np.asarray(layout.position if lone else MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high))
    for tick in ticks[(ticks >= low) & (ticks <= high)]:
        axes.plot(*np.transpose([at(tick, RULER), at(tick, RULER + 0.07)]), color=FAINT_INK, linewidth=0.9)
        x, y = at(tick, RULER + 0.11)
        axes.text(x, y, f"{tick:g}", size=SMALL_SIZE, color=INK, ha="center", va="top")
    symbol = "station number" if layout.unit is None else f"axial [{layout.unit.symbol}]"
    x, y = at(middle, RULER + 0.60)
    arrow = ("", " \u2192") if view.right[2] > 0 else ("\u2190 ", "")
    axes.text(x, y, f"{arrow[0]}{symbol}, travel{arrow[1]}", size=SMALL_SIZE, color=INK, ha="center", va="top")


def _label_hours(axes: Axes, view: View, start: float) -> None:
    for hour in (12, view.hour, 6):
        x, y = xy_of(hour * np.pi / 6, 1.17)
        place = view.page(np.array([float(x), float(y), start]))
        axes.text(place[0], place[1], f"{hour} h", size=SMALL_SIZE, color=INK, ha="center", va="center")
    axes.margins(0.06)
    axes.autoscale_view()
    low, high = axes.get_xlim()
    room = max(0.0, LEAST_WIDTH - (high - low)) / 2
    axes.set_xlim(low - room, high + room)


def _add_colours(figure: Figure, panels: list[Axes], colours: ScalarMappable, label: str, values: Floats) -> None:
    add_colour_bar(figure, panels, colours, label, values)
    missing = [Patch(facecolor=MISSING_GREY, label="grey: not measured, drawn at the nominal radius")]
    figure.legend(handles=missing, loc="outside lower left", fontsize=SMALL_SIZE, frameon=False)
