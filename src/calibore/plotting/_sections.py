"""The worst cross-sections against the ideal circle, looking along travel: 12 h at the top, 3 h on the right."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from calibore.geometry import xy_of
from calibore.plotting._figures import (
    COVERAGE_FACTOR,
    FAINT_INK,
    INK,
    MISSING_GREY,
    SMALL_SIZE,
    TEXT_SIZE,
    UPPER_COLOUR,
    new_figure,
)
from calibore.plotting._lengths import LengthUnit, axial_unit, checked_radius, length_unit
from calibore.plotting._rings import column, governing_ovality, worst_stations
from calibore.plotting._stations import Floats
from calibore.plotting._walls import Wall, clock_text, wall_of

EXAGGERATIONS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
ROOM, MOST_ROOM = 0.30, 0.70
"""Shares of the nominal radius that 95 % of the exaggerated deviations, and all of them, fill at most."""

HOUR_ROOM = np.array([0.32, 0.20])
"""Nominal radii beside and above the drawing in which the clock labels stand."""

LABEL_CLOCK = 0.77 * np.pi
"""Where the circles of equal deviation carry their values: about half past four."""


def exaggeration_for(deviation: Any, nominal_radius: float, *, room: float = ROOM, most: float = MOST_ROOM) -> int:
    """The largest factor of 1, 2, 5, 10 ... that keeps `deviation` [m] in the room there is; at least 1.

    95 % of the points stay within `room` x `nominal_radius`, and all within `most` x `nominal_radius`.
    """
    size = np.abs(deviation[np.isfinite(deviation)]) / nominal_radius
    if not size.size:
        return 1
    needed = max(float(np.percentile(size, 95)) / room, float(size.max()) / most)
    return max((factor for factor in EXAGGERATIONS if factor * needed <= 1), default=1)


def worst_sections(
    dataset: Any, rings: Mapping[str, Any], *, nominal_radius: float, unit: str = "mm", count: int = 3
) -> Figure:
    """The `count` worst rings, deviations from the circle of `nominal_radius` [m] exaggerated as the title says.

    Worst means largest governing ovality, places at least one nominal diameter apart if the pipe is long enough.
    """
    scale, wall = length_unit(unit), wall_of(dataset, rings)
    chosen = _chosen(dataset, rings, wall, count=count, apart=2 * checked_radius(nominal_radius))
    deviation = (wall.radius - nominal_radius)[[ring for _, ring in chosen]]
    factor = exaggeration_for(deviation, nominal_radius)
    names = {0: "No measured cross-section", 1: "The worst cross-section"}
    title = names.get(len(chosen), f"The {len(chosen)} worst cross-sections")
    notes = ["Looking along travel; about each ring's fitted centre; by ovality, places a diameter apart if possible"]
    if chosen:
        title += f", deviations enlarged {factor}x" if factor > 1 else ", deviations to scale (1x)"
    figure = new_figure(3.9 if len(chosen) > 1 else 5.6, title=title, notes=notes)
    panels = figure.subplots(1, max(1, len(chosen)), squeeze=False)[0]
    for axes in panels:
        _ground(axes, nominal_radius, scale, factor)
    for axes, (row, ring) in zip(panels, chosen, strict=False):
        _draw_ring(axes, wall, ring, nominal_radius, factor)
        axes.set_title(_caption(rings, row, unit, _worst_clock(wall, ring, nominal_radius)), size=SMALL_SIZE, color=INK)
    _label_hours(list(panels))
    _add_legend(figure, nominal_radius, scale)
    return figure


def _chosen(dataset: Any, rings: Mapping[str, Any], wall: Wall, *, count: int, apart: float) -> list[tuple[int, int]]:
    """(row of `rings`, row of `dataset`) of the worst rings that have points to show."""
    place = {int(station): index for index, station in enumerate(dataset["station"].values)}
    drawable = [int(s) in place and bool(np.isfinite(wall.radius[place[int(s)]]).any()) for s in rings["station"]]
    kept = np.flatnonzero(drawable)
    candidates = {name: np.asarray(values)[kept] for name, values in rings.items()}
    rows = kept[worst_stations(candidates, count=count, apart=apart)]
    return [(int(row), place[int(rings["station"][row])]) for row in rows]


def _ground(axes: Axes, nominal_radius: float, scale: LengthUnit, factor: int) -> None:
    """Ideal circle, centre, and circles of equal deviation with their values; all in units of the nominal radius."""
    axes.set_axis_off()
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(*_page(turn, np.ones(361)), color=INK, linewidth=0.8, linestyle=(0, (4, 3)))
    step = _grid_step(factor, nominal_radius / scale.metres)
    for value in (-step, step):
        radius = 1 + factor * value * scale.metres / nominal_radius
        axes.plot(*_page(turn, np.full(361, radius)), color="#b8b8b8", linewidth=0.6)
        x, y = _page(LABEL_CLOCK, radius + (0.02 if value > 0 else -0.14))
        side: dict[str, Any] = {"ha": "left", "va": "top"} if value > 0 else {"ha": "center", "va": "center"}
        text = f"{value:+g} {scale.symbol}"
        axes.text(float(x), float(y), text, size=SMALL_SIZE - 1, color=FAINT_INK, **side)
    axes.plot([-0.04, 0.04, np.nan, 0, 0], [0, 0, np.nan, -0.04, 0.04], color=FAINT_INK, linewidth=0.8)


def _label_hours(panels: list[Axes]) -> None:
    """Clock labels just outside everything drawn; the same limits, hence the same scale, in all panels."""
    lowest = np.min([axes.dataLim.min for axes in panels], axis=0)
    highest = np.max([axes.dataLim.max for axes in panels], axis=0)
    (left, bottom), (right, top) = lowest - HOUR_ROOM, highest + HOUR_ROOM
    places = {
        "12 h": (0, top, "top"),
        "3 h": (right, 0, "center"),
        "6 h": (0, bottom, "bottom"),
        "9 h": (left, 0, "center"),
    }
    for axes in panels:
        axes.set(aspect="equal", xlim=(left, right), ylim=(bottom, top), anchor="S")
        for name, (x, y, vertical) in places.items():
            side = {right: "right", left: "left"}.get(x, "center")
            axes.text(x, y, name, size=TEXT_SIZE, color=INK, ha=side, va=vertical)


def _grid_step(factor: int, radius: float) -> float:
    """A round deviation that lies near a fifth of the radius once exaggerated."""
    wanted = 0.22 * radius / factor
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= wanted))


def _page(clock: Any, radius: Any) -> tuple[Any, Any]:
    """Page coordinates: x to the right, y up (the pipe frame has y down)."""
    x, y = xy_of(np.asarray(clock, float), np.asarray(radius, float))
    return x, -y


def _draw_ring(axes: Axes, wall: Wall, ring: int, nominal_radius: float, factor: int) -> None:
    radius, expanded = wall.radius[ring], wall.U[ring]
    unit_x, unit_y = wall.x[ring] / radius, -wall.y[ring] / radius
    bands = np.array([[0.0], [-1.0], [1.0]]) * np.nan_to_num(expanded)
    drawn = 1 + factor * (radius + bands - nominal_radius) / nominal_radius
    x, y, middle, inner, outer = (np.append(part, part[0]) for part in (unit_x, unit_y, *drawn))
    _fill_between_circles(axes, x, y, inner, outer)
    axes.plot(x * middle, y * middle, color=UPPER_COLOUR, linewidth=1.3, solid_capstyle="round")
    alone = np.isfinite(radius) & ~np.isfinite(np.roll(radius, 1)) & ~np.isfinite(np.roll(radius, -1))
    axes.plot((unit_x * drawn[0])[alone], (unit_y * drawn[0])[alone], ".", color=UPPER_COLOUR, markersize=2)
    missing = np.where(np.isfinite(radius), np.nan, 1.0)
    arc = np.fmin(missing, np.roll(missing, -1))
    arc_x, arc_y = _page(np.append(wall.clock, wall.clock[0]), np.append(arc, arc[0]))
    axes.plot(arc_x, arc_y, color=MISSING_GREY, linewidth=4, alpha=0.75)


def _fill_between_circles(axes: Axes, x: Floats, y: Floats, inner: Floats, outer: Floats) -> None:
    known = np.isfinite(inner)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(int)))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        part, back = slice(start, end), slice(end - 1, start - 1 if start else None, -1)
        outline_x = np.concatenate([x[part] * outer[part], x[back] * inner[back]])
        outline_y = np.concatenate([y[part] * outer[part], y[back] * inner[back]])
        axes.fill(outline_x, outline_y, color=UPPER_COLOUR, alpha=0.25, linewidth=0)


def _worst_clock(wall: Wall, ring: int, nominal_radius: float) -> float:
    return float(wall.clock[np.nanargmax(np.abs(wall.radius[ring] - nominal_radius))])


def _caption(rings: Mapping[str, Any], row: int, unit: str, furthest: float) -> str:
    axial = column(rings, "axial_m")
    scale = axial_unit(unit, float(np.ptp(axial[np.isfinite(axial)])) if np.isfinite(axial).any() else 0.0)
    ovality, u = governing_ovality(rings)
    lines = [f"station {int(rings['station'][row])}, axial {axial[row] / scale.metres:.4g} {scale.symbol}"]
    lines += [f"ovality {_with_band(ovality[row], u[row])}"]
    deflection = column(rings, "deflection_percent")[row]
    if np.isfinite(deflection):
        lines += [f"deflection {_with_band(deflection, column(rings, 'u_deflection_percent')[row])}"]
    return "\n".join([*lines, f"furthest from nominal at {clock_text(furthest)}"])


def _with_band(value: float, u: float) -> str:
    return f"({value:.2f} ± {COVERAGE_FACTOR * u:.2f}) %" if np.isfinite(u) else f"{value:.2f} %"


def _add_legend(figure: Figure, nominal_radius: float, scale: LengthUnit) -> None:
    ideal = f"ideal circle, diameter {2 * nominal_radius / scale.metres:.1f} {scale.symbol}"
    handles = [
        Line2D([], [], color=UPPER_COLOUR, linewidth=1.3, label="measured"),
        Patch(facecolor=UPPER_COLOUR, alpha=0.25, label="95 % (k = 2)"),
        Line2D([], [], color=INK, linewidth=0.8, linestyle=(0, (4, 3)), label=ideal),
        Line2D([], [], color=MISSING_GREY, linewidth=4, alpha=0.75, label="not measured"),
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=4, fontsize=SMALL_SIZE, frameon=False)
