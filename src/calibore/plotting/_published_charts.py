"""Curves of a published figure over one or two scales."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from calibore.plotting._figures import INK, TEXT_SIZE, style_axes
from calibore.published import Chart, Curve

TONES = {
    "blue": "#0072b2",
    "red": "#d55e00",
    "green": "#009e73",
    "purple": "#a04f85",
    "orange": "#e69f00",
    "black": "#1a1a1a",
    "grey": "#6e6e6e",
}
"""After Okabe and Ito; every curve also has a line style of its own."""

LINE_STYLES: dict[str, Any] = {
    "solid": "-",
    "dashed": (0, (5, 2)),
    "dotted": (0, (1, 1.4)),
    "dash-dot": (0, (6, 2, 1, 2)),
}
BAND = "#d9d9d9"


def draw_chart(axes: Axes, chart: Chart) -> None:
    """Curves, shaded bands, and the second scale if the chart has one."""
    style_axes(axes, x_label=chart.x_label, y_label=chart.y_label)
    for number, (left, right) in enumerate(chart.bands):
        axes.axvspan(left, right, color=BAND, linewidth=0, label=chart.band_label if number == 0 else "_", zorder=0.5)
    other = _second_scale(axes, chart) if chart.right_label else axes
    for curve in chart.curves:
        _draw_curve(other if curve.right else axes, curve)
    axes.set(xlim=chart.x_limits, ylim=chart.y_limits)
    if chart.title:
        axes.set_title(chart.title, size=TEXT_SIZE, color=INK)
    if chart.equal:
        axes.set_aspect("equal")
    if chart.x_limits == (-180, 180):
        axes.set_xticks(np.arange(-180, 181, 45))


def _second_scale(axes: Axes, chart: Chart) -> Axes:
    other = axes.twinx()
    other.set_ylabel(chart.right_label, size=TEXT_SIZE, color=INK)
    other.set_ylim(chart.right_limits)
    other.tick_params(labelsize=TEXT_SIZE)
    other.spines["top"].set_visible(False)
    return other


def _draw_curve(axes: Axes, curve: Curve) -> None:
    axes.plot(
        curve.x,
        curve.y,
        color=TONES[curve.tone],
        linestyle=LINE_STYLES[curve.style],
        linewidth=1.8,
        label=curve.label or "_",
    )
