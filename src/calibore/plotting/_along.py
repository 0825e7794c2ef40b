"""Ring quantities along the pipe: ovality and diameters with their 95 % bands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibore.plotting._figures import (
    COVERAGE_FACTOR,
    FAINT_INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import checked_radius, length_unit
from calibore.plotting._rings import GOVERNING_OVALITY, OVALITY_DEFINITIONS, column, governing_ovality
from calibore.plotting._stations import Floats, Layout, lay_out

FEW_STATIONS = 60
"""Up to this many stations are drawn as single markers with error bars, more as a line with a band."""

DIAMETERS = (
    ("max", "largest", UPPER_COLOUR, "^"),
    ("mean", "mean", MEAN_COLOUR, "o"),
    ("min", "smallest", LOWER_COLOUR, "v"),
)
LIMIT_REACH = 4.0
"""A limit more than this many data heights away would flatten the data; it is named in the legend instead of drawn."""


@dataclass(frozen=True)
class _Series:
    """One quantity along the pipe: `values`, `expanded` (n,) in display units, in the order of the layout."""

    label: str
    values: Floats
    expanded: Floats
    colour: str
    marker: str


def ovality_along(
    dataset: Any,
    rings: Mapping[str, Any],
    *,
    nominal_radius: float,
    unit: str = "mm",
    limit: float | None = None,
    definitions: Sequence[str] = ("governing", "harmonic"),
) -> Figure:
    """Ovality [%] at every station with its 95 % band; `limit` [%] draws a line.

    `definitions` from "governing" (the larger form of ASTM F1216) and the names in `OVALITY_DEFINITIONS`.
    """
    layout = _layout(rings, unit, checked_radius(nominal_radius))
    styles = ((MEAN_COLOUR, "o"), (LOWER_COLOUR, "s"), (UPPER_COLOUR, "^"), (FAINT_INK, "D"))
    series = [
        _Series(*_ovality(rings, name, layout), colour, marker)
        for name, (colour, marker) in zip(definitions, styles, strict=False)
    ]
    notes = [f"Ovality: {GOVERNING_OVALITY}"] if "governing" in definitions else []
    figure = new_figure(4.1, title="Ovality along the pipe", notes=[*notes, *_band_note(layout)])
    axes = figure.add_subplot()
    _draw(axes, layout, series)
    style_axes(axes, x_label=layout.label, y_label="ovality [% of mean diameter]")
    _frame(axes, layout, series, level=limit, name="" if limit is None else f"limit {limit:g} %", floor=0.0)
    _legend(figure, axes)
    return figure


def diameter_along(
    dataset: Any, rings: Mapping[str, Any], *, nominal_radius: float, unit: str = "mm", limit: float | None = None
) -> Figure:
    """Mean, smallest and largest diameter at every station with 95 % bands, the nominal, and `limit` [m] if given."""
    scale, nominal = length_unit(unit), 2 * checked_radius(nominal_radius)
    layout = _layout(rings, unit, nominal_radius)
    series = []
    for kind, name, colour, marker in DIAMETERS:
        values, u = (column(rings, f"{prefix}diameter_{kind}_m")[layout.order] / scale.metres for prefix in ("", "u_"))
        series.append(_Series(name, values, COVERAGE_FACTOR * u, colour, marker))
    figure = new_figure(4.1, title="Diameter along the pipe", notes=_band_note(layout))
    axes = figure.add_subplot()
    _draw(axes, layout, series)
    style_axes(axes, x_label=layout.label, y_label=f"diameter [{scale.symbol}]")
    _frame(axes, layout, series, level=None, name="", floor=None)
    level, text = nominal / scale.metres, f"{nominal / scale.metres:.1f} {scale.symbol}"
    _add_level(axes, level, f"nominal {text}", FAINT_INK, (0, (1, 2)))
    if limit is not None:
        _add_level(axes, limit / scale.metres, f"limit {limit / scale.metres:.1f} {scale.symbol}", LIMIT_COLOUR, "--")
    _legend(figure, axes)
    return figure


def _layout(rings: Mapping[str, Any], unit: str, nominal_radius: float) -> Layout:
    return lay_out(rings["axial_m"], rings["station"], unit=unit, lone_width=0.1 * nominal_radius)


def _ovality(rings: Mapping[str, Any], name: str, layout: Layout) -> tuple[str, Floats, Floats]:
    if name == "governing":
        values, u = governing_ovality(rings)
        return "ovality, larger F1216 form", values[layout.order], COVERAGE_FACTOR * u[layout.order]
    values, u = (column(rings, f"{prefix}ovality_{name}_percent") for prefix in ("", "u_"))
    return OVALITY_DEFINITIONS[name], values[layout.order], COVERAGE_FACTOR * u[layout.order]


def _band_note(layout: Layout) -> list[str]:
    count = len(layout.position)
    kind = "Bars" if count <= FEW_STATIONS else "Bands"
    return [f"{kind}: 95 % (k = 2) for each station on its own; {count} station{'s' * (count != 1)}, none left out"]


def _draw(axes: Axes, layout: Layout, series: list[_Series]) -> None:
    few = len(layout.position) <= FEW_STATIONS
    width = layout.limits[1] - layout.limits[0]
    for number, one in enumerate(series):
        # Bars of several quantities at one station would hide each other; a shift of 0.4 % of the axis separates them.
        shift = (number - (len(series) - 1) / 2) * 0.004 * width if few else 0.0
        (_bars if few else _band)(axes, layout, one, shift)
    silent = ~np.isfinite(np.array([one.values for one in series])).any(axis=0)
    count = int(silent.sum())
    if silent.any():
        label = f"no value ({count} station{'s' * (count != 1)})"
        at = layout.position[silent]
        style = {"color": FAINT_INK, "marker": "x", "linestyle": "none", "markersize": 5, "clip_on": False}
        axes.plot(at, np.zeros(len(at)), transform=axes.get_xaxis_transform(), label=label, zorder=5, **style)


def _bars(axes: Axes, layout: Layout, one: _Series, shift: float) -> None:
    at = layout.position + shift
    axes.plot(*_broken(layout, at, one.values), color=one.colour, linewidth=0.7, alpha=0.6)
    bars = np.where(np.isfinite(one.expanded), one.expanded, 0.0)
    style = {"fmt": one.marker, "markersize": 4.5, "capsize": 2.5, "elinewidth": 1.0}
    axes.errorbar(at, one.values, yerr=bars, color=one.colour, label=one.label, **style)


def _band(axes: Axes, layout: Layout, one: _Series, shift: float) -> None:
    at, values = _broken(layout, layout.position + shift, one.values)
    _, expanded = _broken(layout, layout.position, one.expanded)
    axes.fill_between(at, values - expanded, values + expanded, color=one.colour, alpha=0.22, linewidth=0)
    axes.plot(at, values, color=one.colour, linewidth=1.1, label=one.label)
    known = np.concatenate([[False], np.isfinite(values), [False]])
    alone = known[1:-1] & ~known[:-2] & ~known[2:]
    axes.plot(at[alone], values[alone], ".", color=one.colour, markersize=2.5)


def _broken(layout: Layout, at: Floats, values: Floats) -> tuple[Floats, Floats]:
    """`at` and `values` with a NaN in every gap between stations, so that no line bridges what was not measured."""
    gaps = np.flatnonzero(~layout.joined) + 1
    return np.insert(at, gaps, np.nan), np.insert(values, gaps, np.nan)


def _frame(
    axes: Axes, layout: Layout, series: list[_Series], *, level: float | None, name: str, floor: float | None
) -> None:
    """Axis limits that hold every value and nearly every band, and a limit line unless it lies far away."""
    axes.set_xlim(*layout.limits)
    if len(layout.position) == 1:
        axes.set_xticks([layout.position[0]])
    low, high = _reach(series)
    if level is not None and low - LIMIT_REACH * (high - low) <= level <= high + LIMIT_REACH * (high - low):
        low, high = min(low, level), max(high, level)
    elif level is not None:
        name += " (outside this picture)"
    margin = 0.07 * (high - low)
    axes.set_ylim(low - margin if floor is None else max(floor - margin / 3, low - margin), high + margin)
    if level is not None:
        axes.axhline(level, color=LIMIT_COLOUR, linestyle="--", linewidth=1.3, label=name)


def _reach(series: list[_Series]) -> tuple[float, float]:
    values = np.concatenate([one.values for one in series])
    if not np.isfinite(values).any():
        return 0.0, 1.0
    expanded = np.concatenate([np.nan_to_num(one.expanded) for one in series])
    lowest, highest = float(np.nanmin(values)), float(np.nanmax(values))
    low = min(lowest, float(np.nanpercentile(values - expanded, 1)))
    high = max(highest, float(np.nanpercentile(values + expanded, 99)))
    if high - low > 0:
        return low, high
    return low - 0.01 * abs(low) - 1e-6, high + 0.01 * abs(high) + 1e-6


def _add_level(axes: Axes, level: float, name: str, colour: str, line: Any) -> None:
    low, high = axes.get_ylim()
    reach = LIMIT_REACH * (high - low)
    if not low - reach <= level <= high + reach:
        name += " (outside this picture)"
    else:
        margin = 0.05 * (high - low)
        axes.set_ylim(min(low, level - margin), max(high, level + margin))
    axes.axhline(level, color=colour, linestyle=line, linewidth=1.3, label=name, zorder=1.5)


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower left", ncols=5, fontsize=SMALL_SIZE, frameon=False)
