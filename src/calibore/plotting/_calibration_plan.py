"""What the next pictures would bring."""

import numpy as np
from matplotlib.figure import Figure

from calibore.calibration import Plan
from calibore.plotting._calibration_parts import log_axis
from calibore.plotting._figures import (
    COVERAGE_FACTOR,
    FAINT_INK,
    INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import length_unit, plain_text

FIRST = 8
"""Of the ranking that are drawn."""


def plan_chart(plan: Plan, *, unit: str = "mm") -> Figure:
    """Uncertainty on the wall before and after the planned pictures, step by step and against the radius."""
    scale, k = length_unit(unit), COVERAGE_FACTOR
    u = k * np.array([plan.before, *(step.u for step in plan.steps)]) / scale.metres
    names = ["now", *(f"{n}. {step.shot.said(unit)}" for n, step in enumerate(plan.steps, start=1))]
    notes = [
        f"U = {k:g} u of the radius, from the calibration alone; each picture is the best that can follow those before",
        f"At R = {plan.nominal_radius / scale.metres:.4g} {unit} from {plain_text(u[0])} to {plain_text(u[-1])} {unit}",
    ]
    figure = new_figure(4.7 + 0.3 * len(names), title="What to photograph next", notes=notes)
    steps, curves = figure.subfigures(2, 1, height_ratios=[0.7 + 0.3 * len(names), 3.2], squeeze=False)[:, 0]
    upper, lower = steps.subplots(), curves.subplots()
    rows = np.arange(len(names))
    colours = [UPPER_COLOUR, *[LOWER_COLOUR] * len(plan.steps)]
    upper.barh(rows, u, color=colours, alpha=0.8, height=0.62)
    for row, value in zip(rows, u, strict=True):
        upper.text(value + 0.012 * u.max(), row, f"{plain_text(value)} {unit}", va="center", size=SMALL_SIZE, color=INK)
    upper.set_yticks(rows, names, size=TEXT_SIZE)
    upper.invert_yaxis()
    style_axes(upper, x_label=f"U of R at the nominal radius [{unit}]", y_label="", grid=False)
    upper.set_xlim(0, 1.25 * u.max())
    x = plan.radius / scale.metres
    lower.plot(x, k * plan.u_before / scale.metres, color=UPPER_COLOUR, linestyle="--", label="now")
    after = f"after {len(plan.steps)} pictures" if len(plan.steps) > 1 else "after the picture"
    lower.plot(x, k * plan.u_after / scale.metres, color=LOWER_COLOUR, linewidth=2.0, label=after)
    lower.axvline(plan.nominal_radius / scale.metres, color=LIMIT_COLOUR, linestyle=":", label="nominal radius")
    style_axes(lower, x_label=f"radius of the wall [{unit}]", y_label=f"U of R [{unit}]")
    lower.set_xlim(x[0], x[-1])
    log_axis(lower.yaxis, k * np.concatenate([plan.u_before, plan.u_after]) / scale.metres)
    curves.legend(
        *lower.get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=SMALL_SIZE, frameon=False,
        labelcolor=FAINT_INK,
    )  # fmt: skip
    return figure


def ranking_chart(plan: Plan, *, unit: str = "mm") -> Figure:
    """The pictures that could come first, the best first."""
    scale, k = length_unit(unit), COVERAGE_FACTOR
    shown = plan.ranking[:FIRST]
    notes = [f"Of {len(plan.ranking)} pictures considered, the {len(shown)} best; dotted: now"]
    figure = new_figure(1.5 + 0.32 * len(shown), title="Which single picture tells most", notes=notes)
    axes = figure.subplots()
    u = k * np.array([step.u for step in shown]) / scale.metres
    axes.plot(u, range(len(shown)), "o", color=LOWER_COLOUR, markersize=6)
    axes.axvline(k * plan.before / scale.metres, color=UPPER_COLOUR, linestyle=":")
    axes.set_yticks(range(len(shown)), [step.shot.said(unit) for step in shown], size=TEXT_SIZE)
    axes.invert_yaxis()
    axes.set_ylim(len(shown) - 0.5, -0.5)
    style_axes(axes, x_label=f"U of R at the nominal radius after it [{unit}]", y_label="")
    axes.set_xlim(0, 1.06 * max(k * plan.before / scale.metres, float(u.max())))
    return figure
