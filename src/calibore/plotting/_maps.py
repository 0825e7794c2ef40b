"""Unrolled maps: axial position across, clock position upwards with the crown in the middle, as seen from inside."""

from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.image import PcolorImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from calibore.errors import InputError
from calibore.plotting._figures import FAINT_INK, INK, MISSING_GREY, SMALL_SIZE, TEXT_SIZE, new_figure, style_axes
from calibore.plotting._lengths import LengthUnit, checked_radius, length_unit
from calibore.plotting._stations import Floats, Layout, block_extremes, block_starts, lay_out, thinned, thinning_note
from calibore.plotting._walls import CLOCK_TICKS, centred_clock, clock_text, wall_of

DEVIATION_COLOURS = "RdBu_r"
UNCERTAINTY_COLOURS = "viridis"
"""Colour-blind safe, and without the grey that stands for a missing point."""
LONE_WIDTH = 0.1
"""A lone station is drawn this many nominal radii wide."""

MOST_CLOCK_ROWS = 720
FEW_STATIONS = 60
"""Up to this many stations each is marked above the map: a column is wider than the ring that was measured."""

GAP_HATCH = "#c4c4c4"
STATION_MARK: dict[str, Any] = {"color": INK, "markersize": 4, "markeredgewidth": 0, "clip_on": False, "zorder": 6}
ROUNDING = 1e-6
"""mm or in; deviations below this are rounding, not shape."""

NICE_STEPS = np.array([1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])


@dataclass(frozen=True)
class Raster:
    """A map ready to draw: `values` (clock, column) in display units, edges of both axes;
    `layout` is `full` gathered into the columns drawn.
    """

    layout: Layout
    full: Layout
    clock_edges: Floats
    values: Floats
    notes: list[str]


def deviation_map(
    dataset: Any, rings: Any, *, nominal_radius: float, unit: str = "mm", limit: float | None = None
) -> Figure:
    """Map of radius minus nominal radius, blue inwards, red outwards; colours end at +-`limit` [m] (default: robust).

    `dataset` and `rings` as `calibore.scans` gives them, `nominal_radius` [m], `unit` "mm" or "in".
    """
    scale, wall = length_unit(unit), wall_of(dataset, rings)
    deviation = (wall.radius - checked_radius(nominal_radius)) / scale.metres
    places = dataset["axial"].values, dataset["station"].values, wall.clock
    raster = raster_of(*places, deviation, unit=unit, lone_width=LONE_WIDTH * nominal_radius)
    end = limit / scale.metres if limit else robust_limit(deviation)
    notes = [
        f"Radius about the {wall.origin} minus nominal radius {nominal_radius / scale.metres:.2f} {scale.symbol}"
        + _beyond(deviation, end, scale),
        _extremes(raster.full, deviation[raster.full.order], wall.clock, scale),
    ]
    figure = new_figure(4.9, title="Deviation of the wall from nominal, unrolled", notes=notes + raster.notes)
    label = f"deviation [{scale.symbol}], + outward"
    draw_raster(figure, raster, Normalize(-end, end), DEVIATION_COLOURS, label, deviation)
    return figure


def uncertainty_map(dataset: Any, rings: Any, *, nominal_radius: float, unit: str = "mm") -> Figure:
    """Map of the expanded uncertainty (k = 2) of every point, independent and common parts combined."""
    scale, wall = length_unit(unit), wall_of(dataset, rings)
    expanded = wall.U / scale.metres
    places = dataset["axial"].values, dataset["station"].values, wall.clock
    raster = raster_of(*places, expanded, unit=unit, lone_width=LONE_WIDTH * checked_radius(nominal_radius))
    found = expanded[np.isfinite(expanded)]
    common = 2 * np.asarray(dataset["u_common"].values, float)[np.isfinite(wall.radius)] / scale.metres
    notes = ["Expanded uncertainty of each radius (k = 2, about 95 %), independent and common parts combined"]
    if found.size:
        shared = f"; the part common to the whole scan is {np.nanmedian(common):.3g} {scale.symbol}"
        notes += [f"Median {np.median(found):.3g} {scale.symbol}" + shared * bool(np.isfinite(common).any())]
    figure = new_figure(4.9, title="Uncertainty of the wall points, unrolled", notes=notes + raster.notes)
    low, high = (float(end) for end in np.percentile(found, [1, 99])) if found.size else (0.0, 1.0)
    # Colours that span less than a factor of two would make much of differences that do not matter.
    norm = Normalize(min(low, high / 2), high or 1.0)
    draw_raster(figure, raster, norm, UNCERTAINTY_COLOURS, f"U of one point (k = 2) [{scale.symbol}]", expanded)
    return figure


def robust_limit(values: Floats) -> float:
    """Where symmetric colours end: nine points in ten, and six median magnitudes, are inside; at most the extreme.

    A rail or an opening (a few per cent of the points, far out) must not flatten the picture of everything else.
    """
    size = np.abs(values[np.isfinite(values)])
    if size.size == 0 or not size.max() > ROUNDING:
        return 1.0
    common = max(float(np.percentile(size, 90)), 6 * float(np.median(size)))
    return _nice_above(min(float(size.max()), common) if common > ROUNDING else float(size.max()))


def _nice_above(value: float) -> float:
    decade = 10.0 ** np.floor(np.log10(value))
    return float(decade * NICE_STEPS[np.searchsorted(NICE_STEPS, value / decade * (1 - 1e-9))])


def raster_of(axial: Floats, station: Any, clock: Floats, values: Floats, *, unit: str, lone_width: float) -> Raster:
    """`values` (n, m) in display units at `axial` (n,) [m] of stations (n,) and `clock` (m,) [rad], ready to draw."""
    full = lay_out(axial, station, unit=unit, lone_width=lone_width)
    layout, columns = thinned(full)
    clock = centred_clock(clock)
    turn = np.argsort(clock, kind="stable")
    rows = block_starts(len(turn), MOST_CLOCK_ROWS)
    cells = block_extremes(block_extremes(values[full.order][:, turn], columns), rows, axis=1).T
    notes = thinning_note(len(full.position), len(columns))
    lost = int((~np.isfinite(values).any(axis=1)).sum())
    if lost:
        notes = [*notes, f"{lost} of {len(full.position)} stations have no usable ring"]
    return Raster(layout, full, *_closed(clock[turn], rows, cells), notes)


def _closed(clock: Floats, rows: np.ndarray, cells: Floats) -> tuple[Floats, Floats]:
    """Row edges and rows, the last repeated below and the first above, so that the map fills the whole turn."""
    lower = ((np.append(clock[-1] - 2 * np.pi, clock[:-1]) + clock) / 2)[rows]
    upper_end = lower[0] + 2 * np.pi
    return np.concatenate([[-4.0], lower, [upper_end, 8.0]]), np.vstack([cells[-1:], cells, cells[:1]])


def draw_raster(figure: Figure, raster: Raster, norm: Normalize, colours: str, label: str, values: Floats) -> Axes:
    """The map on the figure with its colour bar called `label` and its legend."""
    axes = figure.add_subplot()
    colour_map: Colormap = mpl.colormaps[colours].with_extremes(bad=MISSING_GREY)
    edges, cells, gaps = _with_gaps(raster.layout, raster.values)
    image = PcolorImage(
        axes, edges, raster.clock_edges, np.ma.masked_invalid(cells), cmap=colour_map, norm=norm, zorder=1
    )
    image.set_in_layout(False)
    axes.add_image(image)
    for left, right in gaps:
        axes.axvspan(left, right, facecolor="white", edgecolor=GAP_HATCH, hatch="////", linewidth=0)
    axes.patch.set(facecolor="white", hatch="////", edgecolor=GAP_HATCH)
    axes.set_xlim(*raster.layout.limits)
    style_axes(axes, x_label=raster.layout.label, y_label="clock position [h], looking along travel", grid=False)
    label_clock(axes)
    if len(raster.layout.position) == 1:
        axes.set_xticks([raster.layout.position[0]])
    if len(raster.layout.position) <= FEW_STATIONS:
        at = raster.layout.position
        axes.plot(at, np.full(len(at), 1.015), "v", transform=axes.get_xaxis_transform(), **STATION_MARK)
    add_colour_bar(figure, axes, ScalarMappable(norm, colour_map), label, values)
    _add_legend(figure, float(np.isfinite(values).mean()), raster.layout)
    return axes


def _with_gaps(layout: Layout, cells: Floats) -> tuple[Floats, Floats, list[tuple[float, float]]]:
    """Column edges, cells with an empty column in every gap, and the gaps as (left, right)."""
    at = np.flatnonzero(~layout.joined)
    edges = np.append(np.insert(layout.left, at + 1, layout.right[at]), layout.right[-1])
    gaps = [(float(layout.right[i]), float(layout.left[i + 1])) for i in at]
    return edges, np.insert(cells, at + 1, np.nan, axis=1), gaps


def label_clock(axes: Axes) -> None:
    """The upward axis as clock positions: 6 h, 9 h, 12 h, 3 h, 6 h, a small tick every hour."""
    axes.set_ylim(-np.pi, np.pi)
    axes.set_yticks([at for at, _ in CLOCK_TICKS], [name for _, name in CLOCK_TICKS])
    axes.set_yticks(np.arange(-6, 7) * np.pi / 6, minor=True)


def add_colour_bar(
    figure: Figure, axes: Axes | list[Axes], colours: ScalarMappable, label: str, values: Floats
) -> None:
    """A colour bar with `label`; it ends in an arrow where some of `values` lie beyond the colours."""
    low, high = colours.get_clim()
    if low is None or high is None:
        raise InputError("A colour bar needs colours with limits; give the mappable a norm with both ends.")
    with np.errstate(invalid="ignore"):
        below, above = bool((values < low).any()), bool((values > high).any())
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[below, above]
    bar = figure.colorbar(colours, ax=axes, extend=extend, fraction=0.05, pad=0.02, aspect=28)
    bar.set_label(label, size=TEXT_SIZE, color=INK)
    bar.ax.tick_params(labelsize=TEXT_SIZE)


def _add_legend(figure: Figure, measured: float, layout: Layout) -> None:
    missing = 100 * (1 - measured)
    share = "none here" if missing == 0 else f"{missing:.1f} % of points" if missing >= 0.05 else "< 0.1 % of points"
    handles: list[Artist] = [Patch(facecolor=MISSING_GREY, label=f"grey: not measured ({share})")]
    if len(layout.position) <= FEW_STATIONS:
        handles += [Line2D([], [], marker="v", linestyle="none", label="station", **STATION_MARK)]
    if len(layout.position) == 1 or not layout.joined.all():
        handles += [Patch(facecolor="white", edgecolor=GAP_HATCH, hatch="////", label="hatched: no station here")]
    figure.legend(
        handles=handles, loc="outside lower left", ncols=3, fontsize=SMALL_SIZE, frameon=False, labelcolor=FAINT_INK
    )


def _beyond(deviation: Floats, end: float, scale: LengthUnit) -> str:
    with np.errstate(invalid="ignore"):
        share = 100 * float((np.abs(deviation) > end).sum()) / max(1, int(np.isfinite(deviation).sum()))
    return f"; {share:.1f} % of the points lie beyond the colours (±{end:g} {scale.symbol})" if share else ""


def _extremes(layout: Layout, deviation: Floats, clock: Floats, scale: LengthUnit) -> str:
    """Largest deviation outwards and inwards with their places; `deviation` in the order of `layout`'s stations."""
    if not np.isfinite(deviation).any():
        return "No point was measured"
    places = []
    for name, index in (("outward", int(np.nanargmax(deviation))), ("inward", int(np.nanargmin(deviation)))):
        row, column = divmod(index, deviation.shape[1])
        place = f"{layout.text(layout.position[row])}, {clock_text(clock[column])}"
        places.append(f"{name} {deviation[row, column]:+.3g} {scale.symbol} ({place})")
    return "Furthest " + ", furthest ".join(places)
