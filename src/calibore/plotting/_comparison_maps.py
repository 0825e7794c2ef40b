"""Two profiles compared, unrolled: the difference, and how far beyond chance it is."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from calibore.comparison import Compared
from calibore.plotting._figures import FAINT_INK, INK, SMALL_SIZE, TEXT_SIZE, new_figure
from calibore.plotting._lengths import length_unit, plain_text
from calibore.plotting._maps import DEVIATION_COLOURS, LONE_WIDTH, Raster, draw_raster, raster_of, robust_limit
from calibore.plotting._stations import Floats
from calibore.plotting._walls import centred_clock, clock_text

FULL_COLOUR = 2.0
"""Of the threshold of significance, or of the 95 % interval: where colours end."""
NAMED = 3
"""Regions that a note names."""


def difference_map(found: Compared, *, unit: str = "mm") -> Figure:
    """Radius of the moving profile minus the reference's; blue: less radius, red: more."""
    scale, change = length_unit(unit), found.changes is not None
    value = found.value / scale.metres
    raster, shown = _raster(found, value, unit)
    end = robust_limit(shown)
    rms = found.agreement.overall.rms / scale.metres
    what = f"{found.names[0]} minus {found.names[1]}"
    notes = [
        f"{what}, after registration" + (", what calibration errors explain taken out" if change else ""),
        f"rms {plain_text(rms, 3)} {unit}" * (not change) + _regions_note(found, unit) * change,
        *raster.notes,
    ]
    title = "Change of the radius, unrolled" if change else "Error of the radius, unrolled"
    figure = new_figure(4.9, title=title, notes=notes)
    label = f"{'change' if change else 'error'} [{unit}], + outward"
    axes = draw_raster(figure, raster, Normalize(-end, end), DEVIATION_COLOURS, label, shown)
    _outline(axes, found, raster)
    return figure


def significance_map(found: Compared, *, unit: str = "mm") -> Figure:
    """How far beyond chance: significance with its threshold and regions, or normalised error En."""
    raster, shown = _raster(found, found.normalised, unit)
    if found.changes is None:
        end, title = FULL_COLOUR, "Errors over their 95 % uncertainty, unrolled"
        inside = 100 * found.agreement.overall.inside
        notes = [f"En between -1 and 1: inside what is stated; {inside:.1f} % of the points are, 95 % were expected"]
        label = "normalised error En"
    else:
        end, title = FULL_COLOUR * found.changes.threshold, "Significance of change, unrolled"
        notes = [
            f"Greatest mean around each point over its uncertainty; an unchanged pipe exceeds "
            f"{found.changes.threshold:.1f} anywhere with a probability of {100 * found.changes.false_alarm:g} %",
            _regions_note(found, unit),
        ]
        label = "standard uncertainties, + outward"
    figure = new_figure(4.9, title=title, notes=[*notes, *raster.notes])
    axes = draw_raster(figure, raster, Normalize(-end, end), DEVIATION_COLOURS, label, shown)
    _outline(axes, found, raster)
    return figure


def _raster(found: Compared, values: Floats, unit: str) -> tuple[Raster, Floats]:
    """Rings that have a counterpart, along the reference."""
    rows = np.flatnonzero(np.isfinite(found.axial))
    lone = LONE_WIDTH * found.reference.typical_radius
    shown = values[rows]
    return raster_of(found.axial[rows], rows, found.clock, shown, unit=unit, lone_width=lone), shown


def _outline(axes: Axes, found: Compared, raster: Raster) -> None:
    """Regions outlined along the edges of their points, numbered."""
    if found.changes is None or not found.changes.regions:
        return
    rows = np.flatnonzero(np.isfinite(found.axial))
    clock = centred_clock(found.clock)
    turn = np.argsort(clock)
    step = 2 * np.pi / clock.size
    layout = raster.full
    for number, region in enumerate(found.changes.regions, start=1):
        cells = region.cells[rows][layout.order][:, turn]
        _edges(axes, cells, layout.left, layout.right, clock[turn], step)
        strongest = int(np.argmax(cells.sum(axis=1)))
        columns = np.flatnonzero(cells[strongest])
        axes.annotate(
            str(number), (layout.position[strongest], clock[turn][columns[len(columns) // 2]]), ha="center",
            va="center", size=TEXT_SIZE, weight="bold", color=INK, zorder=7,
            bbox={"boxstyle": "circle,pad=0.25", "facecolor": "white", "edgecolor": INK, "linewidth": 0.8},
        )  # fmt: skip
    handle = Patch(facecolor="none", edgecolor=INK, label="outlined: regions of significant change")
    axes.figure.legend(
        handles=[handle], loc="outside lower right", fontsize=SMALL_SIZE, frameon=False, labelcolor=FAINT_INK
    )


def _edges(axes: Axes, cells: np.ndarray, left: Floats, right: Floats, clock: Floats, step: float) -> None:
    """The lines between cells (n, m) that belong and those that do not."""
    beside = np.pad(cells, ((1, 1), (0, 0)))
    around = np.concatenate([cells[:, -1:], cells, cells[:, :1]], axis=1)
    style = {"colors": INK, "linewidth": 1.2, "zorder": 6}
    for i, j in zip(*np.nonzero(cells), strict=True):
        low, high = clock[j] - step / 2, clock[j] + step / 2
        if not beside[i, j]:
            axes.vlines(left[i], low, high, **style)
        if not beside[i + 2, j]:
            axes.vlines(right[i], low, high, **style)
        if not around[i, j]:
            axes.hlines(low, left[i], right[i], **style)
        if not around[i, j + 2]:
            axes.hlines(high, left[i], right[i], **style)


def _regions_note(found: Compared, unit: str) -> str:
    regions = found.changes.regions if found.changes else ()
    scale = length_unit(unit)
    if not regions:
        return "No region of significant change"
    said = [
        f"{n}: depth {plain_text(one.depth.value / scale.metres, 2, sign=True)} {unit} at axial "
        f"{one.axial.value / scale.metres:.4g} {unit}, {clock_text(one.clock.value)}"
        for n, one in enumerate(regions[:NAMED], start=1)
    ]
    return "; ".join(said) + (f"; and {len(regions) - NAMED} more" if len(regions) > NAMED else "")
