"""The designs that an optimisation found: accuracy against what it costs."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibore.design import Optimised, Option
from calibore.plotting._figures import FAINT_INK, INK, LIMIT_COLOUR, SMALL_SIZE, new_figure, style_axes
from calibore.plotting._lengths import LengthUnit, length_unit

STYLES = {
    "perpendicular-plane": ("o", "#0072b2"),
    "single-cone": ("v", "#e69f00"),
    "dual-cone": ("^", "#d55e00"),
    "side-facing": ("s", "#009e73"),
    "coaxial-cone": ("D", "#cc79a7"),
    "asymmetric-cone": ("<", "#8c6d1f"),
    "reversed-cone": ("P", "#56b4e9"),
    "rotating-spot": ("X", "#595959"),
}
"""Marker and colour, Okabe and Ito: shapes tell the configurations apart without colour."""
LEAST_AREA, MOST_AREA = 24.0, 84.0
"""Points squared, for occlusion angles of 0 and 90 deg."""
KEYS = (15, 45, 75)
"""Degrees shown in the legend."""


def design_chart(found: Optimised, *, unit: str = "mm") -> Figure:
    """U95 against the smallest measurable radius and against the length, one marker per design: shape = configuration,
    area = occlusion angle, hollow = another configuration is better in everything, ring = recommended.
    """
    scale, wanted = length_unit(unit), found.wanted
    notes = [
        "Lower and further left is better. A marker: a design that no other of its configuration beats in everything.",
        "Hollow: another configuration beats it in everything. Cross: covers only this part of the circumference.",
    ]
    figure = new_figure(5.2, title=f"Designs for {wanted.name}", notes=notes)
    left, right = figure.subplots(1, 2, sharey=True)
    _draw(left, found, lambda one: one.design.smallest_radius / scale.metres, scale)
    _draw(right, found, lambda one: one.design.length / scale.metres, scale)
    label = f"largest U95 of a radius [{scale.symbol}]"
    style_axes(left, x_label=f"smallest measurable radius [{scale.symbol}]", y_label=label)
    style_axes(right, x_label=f"length of the rig [{scale.symbol}]", y_label="")
    left.set_yscale("log")
    _steady_ticks(left)
    if wanted.requirement.deflection:
        _limit(left, wanted.smallest_wanted / scale.metres)
    _limit(right, wanted.crawler.length / scale.metres)
    _legend(figure, found)
    return figure


def _draw(axes: Axes, found: Optimised, along: Callable[[Option], float], scale: LengthUnit) -> None:
    axes.axhline(found.wanted.budget / scale.metres, color=LIMIT_COLOUR, linestyle="--", linewidth=1.2, zorder=1.5)
    for option in (*found.options, *found.partly):
        marker, colour = STYLES[option.design.candidate.configuration]
        partial = option in found.partly
        at = along(option), option.design.u95 / scale.metres
        face = colour if option.on_front else "none"
        area = _area(np.degrees(option.design.occlusion))
        if partial:
            axes.scatter(*at, s=area, linewidths=1.4, zorder=3, marker="x", c=colour)
        else:
            shape: Any = {"marker": marker, "facecolors": face, "edgecolors": "white" if option.on_front else colour}
            axes.scatter(*at, s=area, linewidths=0.8, zorder=3, **shape)
        if partial and axes is axes.figure.axes[0]:
            text = f"{100 * option.design.coverage:.0f} % "
            axes.annotate(text, at, size=SMALL_SIZE, color=FAINT_INK, ha="right", va="center", xytext=(-5, 0),
                          textcoords="offset points")  # fmt: skip
    chosen = found.recommended
    axes.scatter(along(chosen), chosen.design.u95 / scale.metres, s=240, marker="o", facecolors="none", edgecolors=INK,
                 linewidths=1.6, zorder=4)  # fmt: skip


def _area(degrees: float) -> float:
    return LEAST_AREA + (MOST_AREA - LEAST_AREA) * degrees / 90


def _limit(axes: Axes, at: float) -> None:
    axes.axvline(at, color=LIMIT_COLOUR, linestyle="--", linewidth=1.2, zorder=1.5)
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, 0.0), max(high, 1.05 * at))


def _steady_ticks(axes: Axes) -> None:
    """1, 2, 5 in every decade, written as people write numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _legend(figure: Figure, found: Optimised) -> None:
    from matplotlib.lines import Line2D

    shown = dict.fromkeys(one.design.candidate.configuration for one in (*found.options, *found.partly))
    partly = {one.design.candidate.configuration for one in found.partly}
    handles = [_handle("x" if name in partly else STYLES[name][0], STYLES[name][1], name, 7.0) for name in shown]
    handles += [_handle("o", FAINT_INK, f"occlusion angle {key} deg", float(np.sqrt(_area(key)))) for key in KEYS]
    handles.append(Line2D([], [], color=LIMIT_COLOUR, linestyle="--", label="required"))
    ring = {"markerfacecolor": "none", "markeredgecolor": INK, "markeredgewidth": 1.6, "linestyle": "none"}
    handles.append(Line2D([], [], marker="o", markersize=9, label="recommended", **ring))
    figure.legend(handles=handles, loc="outside lower left", ncols=4, fontsize=SMALL_SIZE, frameon=False)


def _handle(marker: str, colour: str, label: str, size: float):
    from matplotlib.lines import Line2D

    return Line2D([], [], marker=marker, color=colour, linestyle="none", label=label, markersize=size)
