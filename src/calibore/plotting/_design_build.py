"""Charts of building and deploying a designed rig: budget, tolerances, and the way through the manhole."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle

from calibore.design import Analysis, Tolerance
from calibore.plotting._figures import (
    FAINT_INK,
    GRID,
    INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    SMALL_SIZE,
    TEXT_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import LengthUnit, length_unit

STEPS = {"m": (1e-4, "0.1 mm"), "rad": (np.radians(0.1), "0.1 deg"), "px": (0.1, "0.1 px"), "1": (1e-3, "0.001")}
"""What a careful workshop can hold or see, for comparing parameters of different units."""
GROUND = "#e6ddcf"


def parameter_words(name: str) -> str:
    """`laser.half_angle` as people say it."""
    table, _, last = name.rpartition(".")
    return f"{last.replace('_', ' ')}{f' ({table})' if table else ''}"


def budget_chart(design: Analysis, *, unit: str = "mm") -> Figure | None:
    """Shares of the variance of R round the nominal wall."""
    if not design.shares:
        return None
    scale, k = length_unit(unit), design.assumptions.coverage_factor
    names = [" + ".join(parameter_words(part) for part in name.split(" + ")) for name in design.shares]
    shares = 100 * np.array(list(design.shares.values()))
    notes = [
        "Mean over the clocks that measure at first order; correlated inputs stand together",
        f"U of R at the worst useful clock: {k * design.u_worst / scale.metres:.3g} {scale.symbol} (k = {k:g})",
    ]
    figure = new_figure(1.6 + 0.42 * len(names), title="Budget: what makes the uncertainty of R", notes=notes)
    axes = figure.subplots()
    _bars(axes, names, shares, [f"{share:.3g} %" for share in shares], LOWER_COLOUR)
    style_axes(axes, x_label="share of the variance [%]", y_label="", grid=False)
    axes.set_xlim(0, 118)
    axes.set_xticks(np.arange(0, 101, 20))
    return figure


def tolerance_chart(design: Analysis, *, unit: str = "mm") -> Figure | None:
    """How far R goes wrong by a small step of each parameter, and which limits the target allows."""
    if design.tolerances is None:
        return None
    scale, asked = length_unit(unit), design.tolerances
    rows = sorted((row for row in asked.rows if row.sharing is not None), key=lambda row: -_step_effect(row))
    target = design.assumptions.coverage_factor * asked.target / scale.metres
    notes = [
        f"Target: U of R <= {target:.3g} {scale.symbol} at every useful clock of the nominal wall"
        f" ({100 * asked.fraction:.0f} % of the clocks)",
        "Bars: what a small step of one parameter does to R. Text: limits that meet the target when all share it",
    ]
    figure = new_figure(1.7 + 0.4 * len(rows), title="How well must it be built", notes=notes)
    axes = figure.subplots()
    names = [f"{parameter_words(row.name)}, {STEPS[row.unit][1]}" for row in rows]
    effects = np.array([_step_effect(row) for row in rows]) / scale.metres
    _bars(axes, names, effects, [f"±{limit_text(row.limits, row.unit, scale)}" for row in rows], UPPER_COLOUR)
    style_axes(axes, x_label=f"change of R at the clock where it is largest [{scale.symbol}]", y_label="", grid=False)
    axes.set_xlim(0, 1.3 * max(effects.max(), 1e-12))
    return figure


def limit_text(value: float | None, unit: str, scale: LengthUnit) -> str:
    """A tolerance in the reader's unit: lengths in mm or in, angles in degrees."""
    if value is None:
        return "any"
    if unit == "m":
        return f"{value / scale.metres:.2g} {scale.symbol}"
    return f"{np.degrees(value):.2g} deg" if unit == "rad" else f"{value:.2g} px" if unit == "px" else f"{value:.2g}"


def deployment_chart(design: Analysis, *, unit: str = "mm") -> Figure:
    """The body where the turn from the shaft into the pipe is tightest."""
    one, scale = design.deployment, length_unit(unit)
    verdict = "fits" if one.fits else "does not fit"
    longest = f"the longest that passes is {one.longest / scale.metres:.4g} {scale.symbol}"
    notes = [
        f"Body {one.length / scale.metres:.4g} x {one.height / scale.metres:.4g} {scale.symbol} {verdict}: {longest}",
        "Drawn where the turn is tightest, in the plane of both axes",
    ]
    figure = new_figure(4.6, title="Through the manhole", notes=notes)
    axes = figure.subplots()
    pipe, manhole, height = (a / scale.metres for a in (one.pipe, one.manhole, one.height))
    length, shaft = one.length / scale.metres, 1.2 * max(one.length, one.longest) / scale.metres
    for corner, wide, high in (
        ((-0.5 * manhole, pipe), 0.5 * manhole, shaft),
        ((manhole, pipe), 1.6 * shaft, shaft),
        ((-0.5 * manhole, -0.12 * pipe), manhole * 1.5 + 1.6 * shaft, 0.12 * pipe),
    ):
        axes.add_patch(Rectangle(corner, wide, high, facecolor=GROUND, edgecolor=INK, linewidth=0.8))
    tilt = _tightest(one.manhole, one.pipe, one.height)
    along, across = np.array([np.cos(tilt), -np.sin(tilt)]), np.array([np.sin(tilt), np.cos(tilt)])
    top = np.array([0.0, length * np.sin(tilt)])
    corners = [top, top + length * along, top + length * along + height * across, top + height * across]
    colour = LOWER_COLOUR if one.fits else LIMIT_COLOUR
    axes.add_patch(Polygon(corners, facecolor=colour, alpha=0.45, edgecolor=colour, linewidth=1.5))
    axes.set_xlim(-0.35 * manhole, max(manhole, length) * 1.35)
    axes.set_ylim(-0.12 * pipe, max(pipe + 0.6 * shaft, length * np.sin(tilt) + height))
    axes.set_aspect("equal")
    axes.annotate("shaft", (manhole / 2, axes.get_ylim()[1]), ha="center", va="top", size=SMALL_SIZE, color=FAINT_INK)
    axes.annotate("pipe", (axes.get_xlim()[1], pipe / 2), ha="right", va="center", size=SMALL_SIZE, color=FAINT_INK)
    style_axes(axes, x_label=f"along the pipe [{scale.symbol}]", y_label=f"height [{scale.symbol}]", grid=False)
    return figure


def _tightest(manhole: float, pipe: float, height: float) -> float:
    angle = np.linspace(0, np.pi / 2, 2002)[1:-1]
    return float(angle[np.argmin((manhole * np.sin(angle) + pipe * np.cos(angle) - height) / np.sin(2 * angle))])


def _step_effect(row: Tolerance) -> float:
    return row.sensitivity * STEPS[row.unit][0]


def _bars(axes: Axes, names: list[str], values: np.ndarray, texts: list[str], colour: str) -> None:
    at = list(range(len(names)))
    axes.barh(at, values, color=colour, alpha=0.75, height=0.62)
    axes.set_yticks(at, names, size=TEXT_SIZE)
    axes.invert_yaxis()
    span = float(np.max(values, initial=0.0)) or 1.0
    for place, value, text in zip(at, values, texts, strict=True):
        axes.text(max(value, 0) + 0.012 * span, place, text, va="center", size=SMALL_SIZE, color=INK)
    axes.axvline(0, color=GRID, linewidth=0.8)
