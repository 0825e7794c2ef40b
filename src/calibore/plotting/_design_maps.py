"""What a designed rig measures at every pixel of its image, and how well."""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from calibore.design import Analysis, ImageMap, Region, predict_on_wall
from calibore.plotting._figures import (
    FAINT_INK,
    INK,
    LOWER_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import LengthUnit, length_unit

Floats = NDArray[np.float64]
MEASURE_COLOURS, UNCERTAINTY_COLOURS = "cividis", "viridis"
SHADES: dict[Region, tuple[str, str, str]] = {
    Region.AMBIGUOUS: ("none", "...", "ambiguous: two meetings may be the wall"),
    Region.MONTE_CARLO: ("none", "\\\\\\\\", "near the frontier (1 < m < 4): Monte Carlo"),
    Region.NOT_MEASURABLE: ("#5c5c5c", "////", "grazing, not measurable (m <= 1)"),
    Region.NO_MEETING: ("#d0d0d0", "", "no meeting: the ray passes the light"),
    Region.OUTSIDE_LENS: ("#ffffff", "xxx", "outside the lens"),
}
"""Face, hatch and words of every region but the measured one: told apart without colour."""
MOST_SHOWN = 3.0  # nominal radii; farther walls are beyond what is designed for
CONTOURS, FEWEST = 6, 3
LEAST_TOLD = 1e-3
FLAT = 1e-6  # of the largest value: differences below are rounding
NOMINAL: dict[str, Any] = {"color": UPPER_COLOUR, "linewidth": 1.6}


def design_map(design: Analysis, one: ImageMap, *, unit: str = "mm") -> Figure:
    """R, H and their expanded uncertainties over the image of one laser; curves along u for a line sensor."""
    scale = length_unit(unit)
    title = f"What the line of laser {one.laser + 1} tells" if len(design.rig.lasers) > 1 else "What the image tells"
    if one.v.size == 1:
        return _along_row(design, one, scale)
    notes = [
        f"At every pixel where the line may be found; prior: a wall of radius {_length(design.nominal_radius, scale)}",
        f"U = {design.assumptions.coverage_factor:g} u for {design.assumptions.u_pixel:g} px of noise"
        " and the stated inputs; contours carry their values",
    ]
    figure = new_figure(7.9, title=f"{title}, and how well", notes=notes)
    grid = figure.subplots(2, 2, sharex=True, sharey=True)
    found, k = one.prediction, design.assumptions.coverage_factor
    for axes, values, name in zip(grid[0], (found.radius, found.axial), ("radius R", "axial position H"), strict=True):
        _panel(figure, axes, one, one.valued(values) / scale.metres, _linear(one, values, design, scale), name, scale)
    for axes, values, name in zip(grid[1], (found.u_radius, found.u_axial), ("U of R", "U of H"), strict=True):
        shown = k * one.valued(values) / scale.metres
        _panel(figure, axes, one, shown, _logarithmic(one, shown, design), name, scale)
    lines = _nominal_lines(design, one.laser)
    for axes in grid.flat:
        axes.plot(*lines, **NOMINAL)
        _finish(axes, one)
    for axes in grid[1]:
        axes.set_xlabel("u [px]")
    for axes in grid[:, 0]:
        axes.set_ylabel("v [px]")
    _legend(figure, one)
    return figure


def _panel(
    figure: Figure, axes: Axes, one: ImageMap, values: Floats, norm: Normalize, name: str, scale: LengthUnit
) -> None:
    colours = MEASURE_COLOURS if name[0] in "ra" else UNCERTAINTY_COLOURS
    extent = (one.u[0], one.u[-1], one.v[-1], one.v[0])
    colour_map = mpl.colormaps[colours].with_extremes(bad="white")
    axes.imshow(np.ma.masked_invalid(values), extent=extent, cmap=colour_map, norm=norm, interpolation="nearest")
    levels = _levels(norm)
    inside = np.where((values >= 0.5 * levels[0]) | (levels[0] <= 0), values, np.nan)
    if np.isfinite(inside).any() and np.nanmax(inside) - np.nanmin(inside) > FLAT * np.abs(levels).max():
        lines = axes.contour(one.u, one.v, inside, levels=levels, colors=INK, linewidths=0.6)
        for words in axes.clabel(lines, fmt="%g", fontsize=6.5, inline=True, inline_spacing=2):
            words.set_path_effects([withStroke(linewidth=1.6, foreground="white")])
    _shade(axes, one)
    style_axes(axes, x_label="", y_label="", grid=False)
    bar = figure.colorbar(
        ScalarMappable(norm, colour_map), ax=axes, extend="both", location="top", shrink=0.9, aspect=28, pad=0.02
    )
    bar.set_label(f"{name} [{scale.symbol}]", size=TEXT_SIZE, color=INK)
    bar.set_ticks(levels.tolist(), labels=[f"{level:g}" for level in levels])
    bar.ax.minorticks_off()
    bar.ax.tick_params(labelsize=SMALL_SIZE)


def _shade(axes: Axes, one: ImageMap) -> None:
    for region, (face, hatch, _) in SHADES.items():
        mask = one.region == region
        if not mask.any():
            continue
        drawn = axes.contourf(
            one.u, one.v, mask.astype(float), levels=[0.5, 1.5], colors=[face], hatches=[hatch or None]
        )
        drawn.set_edgecolor(INK)
        drawn.set_linewidth(0.0)
        drawn.set_hatch_linewidth(0.45)


def _levels(norm: Normalize) -> Floats:
    """Round numbers within the colours; of a logarithmic scale 1, 2, 5, 10 where they are enough."""
    low, high = float(norm.vmin or 0.0), float(norm.vmax or 1.0)
    even = np.asarray(MaxNLocator(CONTOURS, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high), dtype=np.float64)
    steps = (10.0 ** np.arange(-12, 12))[:, None] * np.array([1.0, 2.0, 5.0])
    ticks = steps.ravel() if isinstance(norm, LogNorm) else even
    inside = ticks[(ticks >= low) & (ticks <= high)]
    inside = inside[:: max(1, -(-inside.size // CONTOURS))]
    chosen = inside if inside.size >= FEWEST else even[(even >= low) & (even <= high)].round(12)
    return np.array(chosen, dtype=np.float64)


def _linear(one: ImageMap, values: Floats, design: Analysis, scale: LengthUnit) -> Normalize:
    """From the least to the most that is measured in the range designed for."""
    kept = values[_designed(one, design) & np.isfinite(values)] / scale.metres
    low, high = (float(kept.min()), float(kept.max())) if kept.size else (0.0, 1.0)
    if high - low > FLAT * max(abs(high), abs(low)):
        return Normalize(low, high)
    middle = (low + high) / 2 or 1.0
    return Normalize(middle - 0.05 * abs(middle), middle + 0.05 * abs(middle))


def _logarithmic(one: ImageMap, values: Floats, design: Analysis) -> LogNorm:
    kept = values[_designed(one, design) & np.isfinite(values) & (values > 0)]
    low, high = (float(end) for end in np.percentile(kept, [1, 97])) if kept.size else (0.1, 1.0)
    return LogNorm(low, max(high, 1.5 * low))


def _designed(one: ImageMap, design: Analysis) -> NDArray[np.bool_]:
    measured = one.region <= Region.AMBIGUOUS
    return measured & (one.prediction.radius <= MOST_SHOWN * design.nominal_radius)


def _nominal_lines(design: Analysis, laser: int) -> tuple[Floats, Floats]:
    """Where a wall of the nominal radius appears: round the clock, or along a side-facing sheet."""
    turn, reach = np.linspace(0, 2 * np.pi, 721), np.linspace(-1, 1, 721) * design.nominal_radius
    found = predict_on_wall(design.rig, turn, design.nominal_radius, axial=reach, laser=laser)
    hidden = ~found.in_image | ~np.isfinite(found.radius)
    return np.where(hidden, np.nan, found.u), np.where(hidden, np.nan, found.v)


def _finish(axes: Axes, one: ImageMap) -> None:
    axes.set_xlim(one.u[0], one.u[-1])
    axes.set_ylim(one.v[-1], one.v[0])
    axes.set_aspect("equal")


def _legend(figure: Figure, one: ImageMap) -> None:
    handles: list[Any] = [Line2D([], [], **NOMINAL, label="wall of the nominal radius")]
    for region, (face, hatch, words) in SHADES.items():
        if (one.region == region).any():
            share = f" ({_percent(one.fraction(region))} of the image)"
            shown = "white" if face == "none" else face
            handles.append(
                Patch(
                    facecolor=shown,
                    edgecolor=INK,
                    hatch=hatch,
                    linewidth=0.4,
                    hatch_linewidth=0.45,
                    label=words + share,
                )
            )
    figure.legend(
        handles=handles, loc="outside lower left", ncols=2, fontsize=SMALL_SIZE, frameon=False, labelcolor=FAINT_INK
    )


def _percent(fraction: float) -> str:
    return f"{100 * fraction:.2g} %" if fraction >= LEAST_TOLD else "< 0.1 %"


def _along_row(design: Analysis, one: ImageMap, scale: LengthUnit) -> Figure:
    found, k = one.prediction, design.assumptions.coverage_factor
    notes = [f"One row of pixels; U = {k:g} u for {design.assumptions.u_pixel:g} px of noise and the stated inputs"]
    figure = new_figure(5.2, title="What the line sensor measures, and how well", notes=notes)
    upper, lower = figure.subplots(2, 1, sharex=True)
    for axes, values, name in ((upper, found.radius, "radius R"), (lower, k * found.u_radius, "U of R")):
        axes.plot(one.u, one.valued(values)[0] / scale.metres, color=LOWER_COLOUR)
        style_axes(axes, x_label="", y_label=f"{name} [{scale.symbol}]")
        axes.set_xlim(one.u[0], one.u[-1])
    lower.set_xlabel("u [px]")
    upper.axhline(design.nominal_radius / scale.metres, linestyle="--", label="nominal radius", **NOMINAL)
    upper.legend(fontsize=SMALL_SIZE, frameon=False)
    return figure


def _length(metres: float, scale: LengthUnit) -> str:
    return f"{metres / scale.metres:.4g} {scale.symbol}"
