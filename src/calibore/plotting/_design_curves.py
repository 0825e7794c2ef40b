"""Charts of a designed rig: uncertainty round the pipe, against the radius and the lengths it is built to."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy.typing import NDArray

from calibore.design import Analysis, Misalignment, Sweep
from calibore.plotting._figures import (
    FAINT_INK,
    GRID,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import LengthUnit, length_unit

Floats = NDArray[np.float64]
NEAR_FRONTIER = 4.0
LOST = "#c4c4c4"
FEW_CLOCKS = 30  # places of their own, not points of a line
FOUR_COLUMNS = 75  # characters of all legend labels together that still fit side by side
NAMES = {
    "tilt_y": "tilt of the laser plane",
    "aim": "aim",
    "skew": "skew of the sheet",
    "zenith": "direction of the beams",
}


def round_pipe_chart(design: Analysis, *, unit: str = "mm") -> Figure | None:
    """U of R and of H at every clock of the nominal wall; None for heads that turn, which are alike at every clock."""
    ring, scale = design.ring, length_unit(unit)
    if ring.clock.size < 2:
        return None
    k = design.assumptions.coverage_factor
    notes = [
        f"Wall of the nominal radius, {_radius(design, scale)}; U = {k:g} u"
        + "; lasers together" * (len(design.rig.lasers) > 1)
    ]
    figure = new_figure(4.2, title="Uncertainty round the pipe", notes=notes)
    axes = figure.subplots()
    clock = np.append(ring.clock, ring.clock[0] + 2 * np.pi) * 6 / np.pi
    sharp = np.where(ring.margin >= NEAR_FRONTIER, 1.0, np.nan)
    heavier = " (of the laser that weighs most)" if len(design.rig.lasers) == 2 else ""
    lines = (
        (ring.u_radius, "radius R", {"color": MEAN_COLOUR, "linewidth": 1.8}),
        (ring.u_independent, "of it: noise of the line", {"color": LOWER_COLOUR, "linestyle": "--"}),
        (ring.u_common, "of it: calibration, common to all points", {"color": UPPER_COLOUR, "linestyle": "-."}),
        (ring.u_axial, "axial position H" + heavier, {"color": LIMIT_COLOUR, "linestyle": ":"}),
    )
    for (u, label, style), marker in zip(lines, "osD^", strict=True):
        spots = {"marker": marker, "markersize": 5, "linestyle": "none"} if clock.size < FEW_CLOCKS else {}
        axes.plot(clock, _closed(k * u * sharp / scale.metres), label=label, **{**style, **spots})
    _clock_axis(axes, f"U [{scale.symbol}]")
    _frame_log(axes, k * ring.u_radius * sharp / scale.metres)
    _mark_lost(axes, clock[:-1], np.isnan(sharp), "no first order: grazing, or not seen")
    _legend(figure, axes)
    return figure


def limits_chart(design: Analysis, *, unit: str = "mm") -> Figure:
    """The radii measured at every clock."""
    limits, scale = design.limits, length_unit(unit)
    few = limits.clock.size < 2
    clock = np.array([0.0, 12.0]) if few else np.append(limits.clock, limits.clock[0] + 2 * np.pi) * 6 / np.pi
    least, most = (np.repeat(a, 2) if few else _closed(a) for a in (limits.least, limits.most))
    top = 1.1 * min(float(np.nanmax(np.where(np.isfinite(most), most, 0.0), initial=0.0)), 4 * design.nominal_radius)
    top = max(top, 1.5 * design.nominal_radius) / scale.metres
    upward, across, corner = np.degrees([limits.zenith[1], limits.zenith[0], limits.zenith[2]])
    notes = [
        f"Inside the image and at first order (m >= 4). The image sees zeniths up to {across:.1f} deg along u,"
        f" {upward:.1f} deg along v, {corner:.1f} deg in the corners",
        "The same at every clock: the head turns" if few else _everywhere_text(design, scale),
    ]
    figure = new_figure(4.0, title="Measuring limits", notes=notes)
    axes = figure.subplots()
    upper = np.minimum(np.where(np.isinf(most), np.inf, most) / scale.metres, 2 * top)
    lower = least / scale.metres
    if 2 < clock.size < FEW_CLOCKS:
        axes.vlines(clock, lower, upper, color=LOWER_COLOUR, alpha=0.5, linewidth=6, label="measured, along the beams")
    else:
        axes.fill_between(clock, lower, upper, color=LOWER_COLOUR, alpha=0.25, linewidth=0, label="measured")
        axes.plot(clock, lower, color=LOWER_COLOUR, label="smallest radius")
        axes.plot(clock, upper, color=UPPER_COLOUR, linestyle="--", label="largest radius")
    axes.axhline(design.nominal_radius / scale.metres, color=MEAN_COLOUR, linestyle=":", label="nominal radius")
    _clock_axis(axes, f"radius [{scale.symbol}]")
    axes.set_ylim(0, top)
    _legend(figure, axes)
    return figure


def sweep_chart(design: Analysis, sweep: Sweep, *, title: str, label: str, at: float, unit: str = "mm") -> Figure:
    """U of R against one length: the range over the useful clocks, and how much of the pipe is measured."""
    scale, k = length_unit(unit), design.assumptions.coverage_factor
    notes = [f"U = {k:g} u over the clocks that measure well: the best, the middle and the worst of them"]
    figure = new_figure(4.6, title=title, notes=notes)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    best, middle, worst = (k * u / scale.metres for u in (sweep.best, sweep.middle, sweep.worst))
    upper.fill_between(sweep.values, best, worst, color=LOWER_COLOUR, alpha=0.2, linewidth=0)
    if np.nanmax(worst / best, initial=1.0) > 1 + 1e-6:
        upper.plot(sweep.values, worst, color=UPPER_COLOUR, linestyle="--", label="worst clock")
        upper.plot(sweep.values, best, color=LOWER_COLOUR, linestyle="-.", label="best clock")
        upper.plot(sweep.values, middle, color=MEAN_COLOUR, linewidth=1.8, label="middle clock")
    else:
        upper.plot(sweep.values, middle, color=MEAN_COLOUR, linewidth=1.8, label="every clock")
    lower.fill_between(sweep.values, 100 * sweep.fraction, color=GRID, linewidth=0, step="mid")
    for axes in (upper, lower):
        axes.axvline(
            at, color=LIMIT_COLOUR, linestyle=":", linewidth=1.3, label="this design" if axes is upper else None
        )
    style_axes(upper, x_label="", y_label=f"U of R [{scale.symbol}]")
    style_axes(lower, x_label=label, y_label="measured\nround pipe [%]")
    lower.set_ylim(0, 105)
    lower.set_xlim(sweep.values[0], sweep.values[-1])
    _frame_log(upper, np.concatenate([best, worst]))
    _legend(figure, upper)
    return figure


def misalignment_chart(design: Analysis, *, unit: str = "mm") -> Figure | None:
    """What an angle costs as an uncertainty, and as an error that nobody knows of."""
    if not design.misalignment:
        return None
    scale, k = length_unit(unit), design.assumptions.coverage_factor
    notes = ["Left: the angle is a standard uncertainty and counts in U. Right: it is there, and nobody knows."]
    figure = new_figure(4.5, title="Misalignment", notes=notes)
    left, right = figure.subplots(1, 2)
    styles = ({"color": LOWER_COLOUR}, {"color": UPPER_COLOUR, "linestyle": "--"})
    for one, style in zip(design.misalignment, styles, strict=False):
        angle, name = np.degrees(one.angle), _named(one)
        left.plot(angle, k * one.u_radius / scale.metres, label=name, **style)
        right.plot(angle, one.worst_error / scale.metres, label=f"{name}: worst", **style)
        mean = np.abs(one.mean_error) / scale.metres
        right.plot(angle, mean, color=style["color"], linestyle=":", label=f"{name}: mean of the ring")
    style_axes(left, x_label="standard uncertainty of the angle [deg]", y_label=f"U of R, worst clock [{scale.symbol}]")
    style_axes(right, x_label="misalignment [deg]", y_label=f"size of the error of R [{scale.symbol}]")
    for axes in (left, right):
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        _legend_below(axes)
    return figure


def occlusion_chart(design: Analysis, *, unit: str = "mm") -> Figure:
    """Angles between wall and rays, and the shadow behind a bump."""
    scale = length_unit(unit)
    notes = ["Left: a steep ray sees into corners; 90 deg throws no shadow. Right: exact for a straight, thin ridge."]
    figure = new_figure(4.6, title="Occlusion", notes=notes)
    left, right = figure.subplots(1, 2)
    clocks = np.concatenate([one.clock for one in design.occlusion])
    for number, one in enumerate(design.occlusion):
        first = number == 0
        for angle, name, style in (
            (one.camera, "camera", {"color": LOWER_COLOUR}),
            (one.light, "light", {"color": UPPER_COLOUR, "linestyle": "--"}),
        ):
            _angle_line(left, one.clock, angle, name if first else None, style, beams=clocks.size < FEW_CLOCKS)
    _clock_axis(left, "angle between wall and ray [deg]")
    left.set_ylim(0, 95)
    _legend_below(left)
    height = design.shadow.height / scale.metres
    right.plot(height, design.shadow.along / scale.metres, color=LOWER_COLOUR, label="behind a ridge round the pipe")
    around = {"color": UPPER_COLOUR, "linestyle": "--", "label": "beside a ridge along the pipe"}
    right.plot(height, design.shadow.around / scale.metres, **around)
    right.axvline(design.bump / scale.metres, color=LIMIT_COLOUR, linestyle=":", label="given bump")
    style_axes(right, x_label=f"height of the bump [{scale.symbol}]", y_label=f"longest shadow [{scale.symbol}]")
    right.set_xlim(left=0)
    right.set_ylim(bottom=0)
    _legend_below(right)
    return figure


def _angle_line(
    axes: Axes, clock: Floats, angle: Floats, label: str | None, style: dict[str, Any], *, beams: bool
) -> None:
    if beams and clock.size == 1:
        every = np.array([0.0, 12.0]) if clock[0] == 0 and label else None
        if every is not None:
            axes.plot(every, np.degrees(np.repeat(angle, 2)), label=label, **style)
        else:
            axes.plot(clock * 6 / np.pi, np.degrees(angle), "o", color=style["color"], markersize=4)
        return
    around = np.append(clock, clock[0] + 2 * np.pi) * 6 / np.pi
    axes.plot(around, np.degrees(_closed(angle)), label=label, **style)


def _named(one: Misalignment) -> str:
    return NAMES.get(one.name, one.name)


def _everywhere_text(design: Analysis, scale: LengthUnit) -> str:
    least, most = design.limits.everywhere
    if np.isnan(least):
        return f"No radius is measured at every clock; the nominal one at {100 * design.limits.fraction:.0f} % of them"
    upper = "beyond 20 nominal radii" if np.isinf(most) else f"{most / scale.metres:.4g} {scale.symbol}"
    return f"Measured at every clock: {least / scale.metres:.4g} {scale.symbol} to {upper}"


def _radius(design: Analysis, scale: LengthUnit) -> str:
    return f"{design.nominal_radius / scale.metres:.4g} {scale.symbol}"


def _closed(values: Floats) -> Floats:
    return np.append(values, values[0])


def _clock_axis(axes: Axes, y_label: str) -> None:
    style_axes(axes, x_label="clock position [h], looking along travel", y_label=y_label)
    axes.set_xlim(0, 12)
    axes.set_xticks(np.arange(0, 13, 3), ["12", "3", "6", "9", "12"])
    axes.set_xticks(np.arange(13), minor=True)


def _frame_log(axes: Axes, values: Floats) -> None:
    """A logarithmic axis where the values span more than a decade, else from zero."""
    found = values[np.isfinite(values) & (values > 0)]
    if found.size and found.max() > 10 * found.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_ylim(bottom=0)


def _mark_lost(axes: Axes, clock: Floats, lost: NDArray[np.bool_], words: str) -> None:
    if lost.any():
        step = clock[1] - clock[0]
        where = {"transform": axes.get_xaxis_transform(), "color": LOST, "linewidth": 0, "zorder": 0}
        for n, at in enumerate(clock[lost]):
            axes.fill_between([at - step / 2, at + step / 2], 0, 1, label=words if n == 0 else None, **where)


def _legend_below(axes: Axes) -> None:
    axes.legend(
        fontsize=SMALL_SIZE, frameon=False, loc="upper left", bbox_to_anchor=(-0.05, -0.17), labelcolor=FAINT_INK
    )


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    columns = 4 if sum(map(len, labels)) < FOUR_COLUMNS else 3
    figure.legend(
        handles,
        labels,
        loc="outside lower left",
        ncols=columns,
        fontsize=SMALL_SIZE,
        frameon=False,
        labelcolor=FAINT_INK,
    )
