"""Differences of two profiles in curves: their distribution, against the radius, and ring by ring."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibore.comparison import Compared
from calibore.plotting._bands import bands_of
from calibore.plotting._figures import (
    FAINT_INK,
    INK,
    LIMIT_COLOUR,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import axial_unit, length_unit, plain_text
from calibore.plotting._stations import Floats

BARS = 61
WIDEST = 5.0
"""Predicted rms to either side of 0 that a histogram shows, at least."""
FACTOR = 1.96
"""Times u: half of a 95 % interval."""
MOST_POINTS = 6000
"""Dots in a cloud."""
BANDS = 30
"""Of the radius, for predicted intervals."""


def histogram_chart(found: Compared, *, unit: str = "mm") -> Figure:
    """How differences are distributed, beside what their stated uncertainties predict."""
    scale = length_unit(unit)
    value, u = _known(found, scale.metres)
    rms, typical = float(np.sqrt(np.mean(value**2))), float(np.median(u))
    end = max(WIDEST * typical, 1.2 * float(np.quantile(np.abs(value), 0.99)))
    beyond = int(np.count_nonzero(np.abs(value) > end))
    word = _word(found)
    notes = [
        f"{value.size} points, rms {plain_text(rms, 3)} {unit}, mean {plain_text(float(value.mean()), 2, sign=True)} "
        f"{unit}" + (f"; {beyond} lie beyond the picture" if beyond else ""),
        "Curve: what the stated uncertainties predict, normal errors with every point's own u; common parts shift "
        "all points together",
    ]
    figure = new_figure(4.2, title=f"Distribution of the {word}s", notes=notes)
    axes = figure.subplots()
    edges = np.linspace(-end, end, BARS + 1)
    axes.hist(value, edges.tolist(), density=True, color=LOWER_COLOUR, alpha=0.55, label="observed")
    grid = np.linspace(-end, end, 401)
    axes.plot(grid, _mixture(grid, u), color=UPPER_COLOUR, linewidth=1.6, label="predicted")
    axes.axvline(0, color=MEAN_COLOUR, linewidth=0.8)
    axes.set_xlim(-end, end)
    style_axes(axes, x_label=f"{word} of the radius [{unit}]", y_label=f"share of points per {unit}")
    axes.legend(fontsize=SMALL_SIZE, frameon=False, labelcolor=FAINT_INK)
    return figure


def radius_chart(found: Compared, *, unit: str = "mm") -> Figure:
    """Differences against the radius with the predicted 95 % interval (Swanbom 2007, figs. 8.13, 8.14)."""
    scale, word = length_unit(unit), _word(found)
    value, u = _known(found, scale.metres)
    known = np.isfinite(found.value) & np.isfinite(found.u)
    radius = (found.difference.radius - found.difference.value)[known] / scale.metres
    figure = new_figure(
        4.4,
        title=f"{word.capitalize()}s against the radius",
        notes=[
            f"Dots: points. Band: 95 % of the {word}s should lie in it; beside edges single points state more",
            f"{100 * np.mean(np.abs(value) <= FACTOR * u):.1f} % of the points lie inside their own 95 % intervals",
        ],
    )
    axes = figure.subplots()
    every = max(1, value.size // MOST_POINTS)
    edges, half, reach = bands_of(radius, value, u, count=BANDS)
    axes.stairs(half, edges, baseline=-half, fill=True, color=UPPER_COLOUR, alpha=0.22, label="predicted, 95 %")
    axes.stairs(half, edges, baseline=-half, color=UPPER_COLOUR, linewidth=1.0)
    axes.plot(radius[::every], value[::every], ".", color=LOWER_COLOUR, markersize=2, alpha=0.5, label="points")
    axes.stairs(reach, edges, baseline=-reach, color=INK, linewidth=1.0, label="observed, 95 % of points")
    end = 1.15 * max(float(np.quantile(np.abs(value), 0.995)), float(np.nanmedian(half)))
    axes.set_ylim(-end, end)
    style_axes(axes, x_label=f"radius of the reference [{unit}]", y_label=f"{word} of the radius [{unit}]")
    _legend(figure, axes)
    return figure


def rings_chart(found: Compared, *, unit: str = "mm") -> Figure | None:
    """Root mean square of every ring, observed and predicted; None of a single ring."""
    rings = list(found.rings.values())
    if len(rings) < 2:
        return None
    scale, word = length_unit(unit), _word(found)
    along = axial_unit(unit, float(np.ptp([one.place for one in rings])))
    place = np.array([one.place for one in rings]) / along.metres
    order = np.argsort(place)
    rms, predicted = (np.array([getattr(one, n) for one in rings]) / scale.metres for n in ("rms", "predicted"))
    plain = [found.away_from_edges(row) for row in found.rings]
    plain_rms, plain_u = (np.array([getattr(one, n) for one in plain]) / scale.metres for n in ("rms", "predicted"))
    worst = rings[int(np.nanargmax(rms))]
    notes = [
        f"Largest {plain_text(worst.rms / scale.metres, 2)} {unit} at axial {worst.place / along.metres:.4g} "
        f"{along.symbol}; predicted: root mean square of the stated uncertainties",
    ]
    figure = new_figure(3.8, title=f"Root mean square {word}, ring by ring", notes=notes)
    axes = figure.subplots()
    mark = "o-" if len(rings) <= 100 else "-"
    for seen, every, colour, label in (
        (plain_rms, rms, LOWER_COLOUR, "observed"),
        (plain_u, predicted, UPPER_COLOUR, "predicted"),
    ):
        axes.plot(place[order], seen[order], mark, color=colour, markersize=3.5, label=f"{label}, edges left out")
        axes.plot(place[order], every[order], "--", color=colour, linewidth=0.9, label=f"{label}, all points")
    overall = found.agreement.overall.rms / scale.metres
    if found.changes is None:
        axes.axhline(overall, color=LIMIT_COLOUR, linestyle=":", label=f"all: {plain_text(overall, 3)} {unit}")
    axes.set_ylim(0, None)
    style_axes(axes, x_label=f"axial position along the reference [{along.symbol}]", y_label=f"rms {word} [{unit}]")
    _legend(figure, axes)
    return figure


def _word(found: Compared) -> str:
    return "error" if found.changes is None else "change"


def _known(found: Compared, metres: float) -> tuple[Floats, Floats]:
    known = np.isfinite(found.value) & np.isfinite(found.u)
    return found.value[known] / metres, found.u[known] / metres


def _mixture(grid: Floats, u: Floats) -> Floats:
    """Density at `grid` (g,) of normal errors, each point with its own `u`, thinned to quantiles."""
    some = np.maximum(np.quantile(u, (np.arange(200) + 0.5) / 200), 1e-12)
    return np.mean(np.exp(-0.5 * (grid[:, None] / some) ** 2) / (some * np.sqrt(2 * np.pi)), axis=1)


def _legend(figure: Figure, axes: Axes) -> None:
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower left", ncols=5, fontsize=SMALL_SIZE, frameon=False,
        labelcolor=FAINT_INK,
    )  # fmt: skip
