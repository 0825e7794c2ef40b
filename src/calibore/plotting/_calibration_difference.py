"""Two calibrations compared: over the image, on the wall, and parameter by parameter."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from calibore.calibration import Difference
from calibore.plotting._calibration_parts import SHADE, side_bar
from calibore.plotting._design_build import parameter_words
from calibore.plotting._figures import (
    FAINT_INK,
    INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import length_unit, plain_text

LONGEST = 0.06
"""Of the image's width: the longest arrow."""
VISIBLE = 0.02
"""Of the band."""
LEAST = 1e-6
"""px; smaller differences are rounding."""
MOST_TIMES = 1e6
"""Arrows longer than that show nothing that could matter."""
FARTHEST = 99.0
"""Standard uncertainties beyond which bars end."""
SIGNIFICANT = 2.0
"""Standard uncertainties beyond which a change is drawn as one."""


def direction_difference_chart(found: Difference) -> Figure:
    """Where the second camera images what the first sees at a pixel, as arrows, coloured by how much chance allows."""
    along = found.directions
    size = np.linalg.norm(along.difference, axis=1)
    large = max(float(size.max()), LEAST)
    turn = float(np.degrees(np.linalg.norm(along.turn)))
    notes = [
        f"{plain_text(along.rms, 2)} px rms, {plain_text(along.expected, 2)} px expected of two calibrations of one"
        f" camera; a turn of {plain_text(turn, 2)} deg is taken out",
        "Colour: the difference over the standard uncertainty there; above 2 to 3 it is more than chance",
    ]
    figure = new_figure(6.5, title="Second camera minus first, over the image", notes=notes)
    axes = figure.subplots()
    _frame(axes, along.u, along.v)
    spread = np.sqrt(along.uncertainty.covariance.trace(axis1=1, axis2=2))
    ratio = size / np.where(spread > 0, spread, np.inf)
    width = float(np.ptp(along.u)) or 1.0
    scale = large / (LONGEST * width)
    drawn = axes.quiver(
        along.u, along.v, *along.difference.T, ratio, angles="xy", scale_units="xy", scale=scale, cmap="viridis_r",
        norm=Normalize(0, 4), width=0.0024,
    )  # fmt: skip
    axes.quiverkey(
        drawn, 0.9, 1.03, large, f"{plain_text(large, 2)} px", labelpos="W", fontproperties={"size": SMALL_SIZE}
    )
    bar = figure.colorbar(drawn, ax=axes, extend="max", **side_bar())
    bar.set_label(f"difference over its uncertainty; {_long(1 / scale)}", size=SMALL_SIZE, color=INK)
    bar.ax.tick_params(labelsize=SMALL_SIZE)
    return figure


def wall_difference_chart(found: Difference, *, unit: str = "mm") -> Figure | None:
    """What the second rig makes of the first one's pictures, against the radius, with the band of no change."""
    if found.wall is None or found.nominal_radius is None:
        return None
    wall, scale = found.wall, length_unit(unit)
    at = int(np.argmin(np.abs(wall.radius - found.nominal_radius)))
    mean, band = wall.mean / scale.metres, wall.coverage * wall.u_mean / scale.metres
    where = f"At R = {found.nominal_radius / scale.metres:.4g} {unit}"
    notes = [
        "The same pictures measured with the second calibration, less with the first; ring centres fitted in both",
        f"{where}: the mean radius differs by {plain_text(mean[at], 2, sign=True)} {unit}; 95 % of unchanged rigs stay"
        f" within {plain_text(band[at], 2)} {unit}",
    ]
    figure = new_figure(4.4, title="Second rig minus first, on the wall", notes=notes)
    axes = figure.subplots()
    x = wall.radius / scale.metres
    seen = np.where(np.isfinite(wall.difference), wall.difference, np.nan) / scale.metres
    some = np.isfinite(seen).any(axis=1)
    axes.fill_between(x, -band, band, color=SHADE, linewidth=0, label="95 % band of no change (mean)")
    if wall.clock.size > 1:
        low, high = (np.full(x.size, np.nan) for _ in range(2))
        low[some], high[some] = np.nanmin(seen[some], axis=1), np.nanmax(seen[some], axis=1)
        if np.nanmax(high - low) > VISIBLE * np.nanmax(band):
            axes.fill_between(x, low, high, color=LOWER_COLOUR, alpha=0.22, linewidth=0, label="from clock to clock")
    axes.plot(x, mean, "o-", color=LOWER_COLOUR, markersize=4, label="mean of the ring")
    axes.axhline(0, color=MEAN_COLOUR, linewidth=0.8)
    axes.axvline(found.nominal_radius / scale.metres, color=LIMIT_COLOUR, linestyle=":", label="nominal radius")
    style_axes(axes, x_label=f"radius of the wall [{unit}]", y_label=f"difference of R [{unit}]")
    if some.sum() > 1:
        axes.set_xlim(x[some][0], x[some][-1])
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower left", ncols=4, fontsize=SMALL_SIZE, frameon=False,
        labelcolor=FAINT_INK,
    )  # fmt: skip
    return figure


def changes_chart(found: Difference) -> Figure | None:
    """Every parameter's change in standard uncertainties, and how much of the whole it would explain alone."""
    if not found.changes:
        return None
    names = [parameter_words(one.name) for one in found.changes]
    rows = np.arange(len(names))
    sigmas = np.array([np.clip(one.sigmas, -FARTHEST, FARTHEST) for one in found.changes])
    notes = [
        "Left: each parameter by itself, whatever the others did. Right: how much of the whole difference it explains",
        "if it is the only one that changed; correlated parameters explain the same",
    ]
    figure = new_figure(1.9 + 0.36 * len(names), title="What changed", notes=notes)
    left, right = figure.subplots(1, 2, sharey=True)
    beyond = np.abs(sigmas) > SIGNIFICANT
    left.axvspan(-SIGNIFICANT, SIGNIFICANT, color=SHADE, linewidth=0, zorder=0)
    left.axvline(0, color=INK, linewidth=0.8)
    left.barh(rows, sigmas, color=[UPPER_COLOUR if one else LOWER_COLOUR for one in beyond], alpha=0.8, height=0.6)
    right.barh(rows, [100 * one.share for one in found.changes], color=LOWER_COLOUR, alpha=0.8, height=0.6)
    for row, one in zip(rows, found.changes, strict=True):
        text = f"{100 * one.share:.{0 if one.share > 0.1 else 1}f} %"
        right.text(100 * one.share + 1.5, row, text, va="center", size=SMALL_SIZE, color=INK)
    left.set_yticks(rows, names, size=TEXT_SIZE)
    left.invert_yaxis()
    style_axes(left, x_label="change [standard uncertainties]", y_label="")
    style_axes(right, x_label="of chi-square, alone [%]", y_label="")
    right.set_xlim(0, 118)
    reach = max(3.0, float(np.abs(sigmas).max(initial=0.0)) * 1.1)
    left.set_xlim(-reach, reach)
    for row, one in zip(rows, found.changes, strict=True):
        if abs(one.sigmas) > FARTHEST:
            left.text(-0.03 * reach * np.sign(one.sigmas), row, plain_text(one.sigmas, 2, sign=True),
                      ha="left" if one.sigmas < 0 else "right", va="center", size=SMALL_SIZE, color=INK)  # fmt: skip
    return figure


def _frame(axes: Axes, u: np.ndarray, v: np.ndarray) -> None:
    style_axes(axes, x_label="u [px]", y_label="v [px]", grid=False)
    margin = (LONGEST + 0.02) * (float(np.ptp(u)) or 1.0)
    axes.set_xlim(u.min() - margin, u.max() + margin)
    axes.set_ylim(v.max() + margin, v.min() - margin)
    axes.set_aspect("equal")


def _long(times: float) -> str:
    if times > MOST_TIMES:
        return "there is none but rounding"
    return f"arrows {plain_text(times, 2)} times as long"
