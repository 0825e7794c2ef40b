"""What a calibration's covariance means: in pixels over the image, in millimetres on the wall."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from calibore.calibration import projection_uncertainty, wall_map, wall_uncertainty
from calibore.optics import Camera
from calibore.plotting._calibration_parts import (
    image_axes,
    image_lattice,
    log_axis,
    shade_outside,
    shade_radii,
    shown_radii,
    side_bar,
)
from calibore.plotting._figures import (
    COVERAGE_FACTOR,
    FAINT_INK,
    INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import length_unit, plain_text
from calibore.rigs import Rig, ValidRegion
from calibore.uncertainty import Covariance

Floats = NDArray[Any]
COLOURS = "viridis"
EDGE = 0.85
"""Of the highest colour: contours beyond would only follow the edge of what is drawn."""
HARDLY, FARTHEST = 0.1, 3.0
SPAN = 12.0
"""Colours and contours end at so many times the median: extrapolated corners would drown the rest."""


def projection_chart(camera: Camera, covariance: Covariance, valid: ValidRegion | None) -> Figure | None:
    """Standard uncertainty of directions over the image [px]; None for a line sensor."""
    if camera.height == 1 or not set(covariance.names) & set(camera.parameter_names):
        return None
    u, v = image_lattice(camera)
    grid = np.meshgrid(u, v)
    found = projection_uncertainty(camera, covariance, grid[0].ravel(), grid[1].ravel(), valid=valid)
    notes = [
        "Standard uncertainty (k = 1) of the direction behind a pixel, in pixels, where it is largest; a turn of the",
        "whole camera is taken out, because no picture of a target whose pose is unknown could tell it",
    ]
    figure = new_figure(6.5, title="How well directions are known, over the image", notes=notes)
    axes = figure.subplots()
    image_axes(axes, camera)
    _surface(figure, axes, (u, v, found.sd.reshape(grid[0].shape)), "u of the direction [px]")
    _legend(figure, [shade_outside(axes, camera, valid)])
    return figure


def wall_chart(rig: Rig, valid: ValidRegion | None, *, nominal_radius: float, unit: str = "mm") -> Figure:
    """Expanded uncertainty of the radius against the radius, with the correlations of the calibration and without."""
    scale = length_unit(unit)
    radii = shown_radii(valid, nominal_radius)
    found = wall_uncertainty(rig, radii=np.union1d(radii, [nominal_radius]))
    at = int(np.argmin(np.abs(found.radius - nominal_radius)))
    true, alone = (COVERAGE_FACTOR * a / scale.metres for a in (found.mean, found.mean_uncorrelated))
    notes = [
        f"U = {COVERAGE_FACTOR:g} u, shared by all points of a scan; root of the mean variance round the clock",
        f"At R = {nominal_radius / scale.metres:.4g} {unit}: {plain_text(true[at], 2)} {unit}; "
        f"{_times(alone[at] / true[at])}",
    ]
    figure = new_figure(4.4, title="Uncertainty on the wall, from the calibration", notes=notes)
    axes = figure.subplots()
    x = found.radius / scale.metres
    axes.plot(x, true, color=LOWER_COLOUR, linewidth=2.0, label="with all correlations: what is true")
    axes.plot(x, alone, color=UPPER_COLOUR, linestyle="--", label="if correlations are ignored: wrong")
    axes.axvline(nominal_radius / scale.metres, color=LIMIT_COLOUR, linestyle=":", label="nominal radius")
    style_axes(axes, x_label=f"radius of the wall [{unit}]", y_label=f"U of R [{unit}]")
    axes.set_xlim(x[0], x[-1])
    log_axis(axes.yaxis, np.concatenate([true, alone]))
    shade_radii(axes, valid, scale)
    handles, _ = axes.get_legend_handles_labels()
    _legend(figure, handles, columns=2)
    return figure


def wall_map_chart(rig: Rig, valid: ValidRegion | None, *, nominal_radius: float, unit: str = "mm") -> Figure | None:
    """Expanded uncertainty of the radius over the image of the first laser; None for a line sensor."""
    if rig.camera.height == 1:
        return None
    scale = length_unit(unit)
    found = wall_map(rig, nominal_radius=nominal_radius)
    notes = [
        f"U = {COVERAGE_FACTOR:g} u of the radius that a line found at a pixel tells, from the calibration alone; "
        "contours carry",
        f"their values; white: no wall within {FARTHEST:g} nominal radii",
    ]
    figure = new_figure(6.5, title="Uncertainty on the wall, where it is seen in the image", notes=notes)
    axes = figure.subplots()
    image_axes(axes, rig.camera)
    reached = found.radius <= FARTHEST * nominal_radius
    values = np.where(reached, COVERAGE_FACTOR * found.uncertainty / scale.metres, np.nan)
    _surface(figure, axes, (found.u, found.v, values), f"U of R [{unit}]")
    axes.plot(*found.line, color=UPPER_COLOUR, linewidth=1.8)
    words = f"wall of R = {nominal_radius / scale.metres:.4g} {unit}"
    wall = Line2D([], [], color=UPPER_COLOUR, linewidth=1.8, label=words)
    _legend(figure, [wall, shade_outside(axes, rig.camera, valid)])
    return figure


def _surface(figure: Figure, axes: Axes, found: tuple[Floats, Floats, Floats], name: str) -> None:
    u, v, values = found
    there = values[np.isfinite(values) & (values > 0)]
    if not there.size:
        return
    middle = float(np.median(there))
    low, high = max(float(there.min()), middle / SPAN), min(float(there.max()), middle * SPAN)
    norm = LogNorm(low, max(high, 1.2 * low))
    colours = mpl.colormaps[COLOURS].with_extremes(bad="white")
    axes.pcolormesh(u, v, np.ma.masked_invalid(values), cmap=colours, norm=norm, shading="nearest", rasterized=True)
    levels = _levels(low, EDGE * high)
    if levels.size and there.max() > 1.001 * there.min():
        lines = axes.contour(u, v, np.clip(values, low, 2 * high), levels=levels, colors=INK, linewidths=0.7)
        for words in axes.clabel(lines, fmt="%g", fontsize=SMALL_SIZE, inline=True, inline_spacing=3):
            words.set_path_effects([withStroke(linewidth=1.8, foreground="white")])
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, extend="both", **side_bar())
    bar.set_label(name, size=SMALL_SIZE, color=INK)
    bar.set_ticks(levels.tolist(), labels=[f"{level:g}" for level in levels])
    bar.ax.minorticks_off()
    bar.ax.tick_params(labelsize=SMALL_SIZE)


def _levels(low: float, high: float) -> Floats:
    """1, 2, 5 of every decade, or finer where few of them lie inside."""
    decades = 10.0 ** np.arange(-9, 9)[:, None]
    for steps in ((1, 2, 5), (1, 1.5, 2, 3, 4, 5, 7), tuple(np.arange(10, 100) / 10)):
        levels = np.unique((decades * np.array(steps)).round(12))
        inside = levels[(levels >= low) & (levels <= high)]
        if inside.size >= 3:
            return inside[:: max(1, inside.size // 8)]
    return np.array([], dtype=np.float64)


def _times(ratio: float) -> str:
    if not np.isfinite(ratio):
        return "not seen there"
    if abs(ratio - 1) < HARDLY:
        return "correlations hardly matter here"
    if ratio >= 1:
        return f"without correlations it would seem {plain_text(ratio, 2)} times as large"
    return f"without correlations it would seem {plain_text(1 / ratio, 2)} times too small"


def _legend(figure: Figure, handles: Sequence[Artist | None], *, columns: int = 2) -> None:
    shown = [handle for handle in handles if handle is not None]
    if shown:
        place = {"loc": "outside lower left", "fontsize": SMALL_SIZE, "frameon": False, "labelcolor": FAINT_INK}
        figure.legend(handles=shown, ncols=columns, **place)
