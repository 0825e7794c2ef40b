"""How a calibration's parameters hang together, and why its model was chosen."""

import matplotlib as mpl
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from calibore.calibration import Calibration
from calibore.plotting._calibration_parts import log_axis, side_bar
from calibore.plotting._calibration_residuals import SIGNED_COLOURS
from calibore.plotting._design_build import parameter_words
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
from calibore.uncertainty import Covariance

DARK = 0.6
"""Correlations beyond which the square is dark and its number white."""
ALL_BUT_ONE = 0.99
ASIDE, SPREAD = 0.13, 4.0
"""Rows by which markers step aside, and the ratio of errors beyond which their axis is logarithmic."""
MOST = 16
"""Parameters up to which numbers fit into the squares."""


def correlation_chart(covariance: Covariance) -> Figure | None:
    """Every pair of parameters; None for a single one."""
    n = len(covariance.names)
    if n < 2:
        return None
    matrix = covariance.correlations
    names = [parameter_words(name) for name in covariance.names]
    notes = [
        "Numbers in per cent; near 100 two parameters can hardly be told apart, only their combination is known",
        _strongest(matrix, names),
    ]
    figure = new_figure(1.9 + 0.42 * max(n, 4), title="Which parameters are known only together", notes=notes)
    axes, beside = figure.subplots(1, 2, width_ratios=[1, max(0.01, 0.8 - 0.06 * n)])
    beside.set_axis_off()
    colours, norm = mpl.colormaps[SIGNED_COLOURS], Normalize(-1, 1)
    axes.imshow(matrix, cmap=colours, norm=norm, aspect="equal")
    axes.set_xticks(range(n), names, rotation=40, ha="right", rotation_mode="anchor", size=SMALL_SIZE)
    axes.set_yticks(range(n), names, size=SMALL_SIZE)
    axes.tick_params(length=0)
    for i, j in np.ndindex(n, n) if n <= MOST else ():
        ink = "white" if abs(matrix[i, j]) > DARK else INK
        text = "" if i == j else _percent(float(matrix[i, j]))
        axes.text(j, i, text, ha="center", va="center", size=SMALL_SIZE - 0.5, color=ink)
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, **side_bar())
    bar.set_label("correlation", size=SMALL_SIZE, color=INK)
    bar.ax.tick_params(labelsize=SMALL_SIZE)
    return figure


def model_chart(calibration: Calibration) -> Figure | None:
    """Every model that was tried: its residuals, its error where it was not fitted, and what the data say for it."""
    models = calibration.models
    if len(models) < 2:
        return None
    unit = models[0].unit
    rmse, outside = np.array([[one.rmse, one.cross_validated] for one in models]).T
    checked = bool(np.isfinite(outside).any())
    error = "cross-validated is what counts, the error of data left out" if checked else "the error of the fit"
    notes = [
        f"Left: {error}. In brackets: how many parameters the model has",
        "Right: 0 is the best by AICc or BIC, and 10 means practically no support",
    ]
    figure = new_figure(1.9 + 0.33 * len(models), title="Which model describes the data", notes=notes)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[1.2, 1])
    rows = np.arange(len(models))
    left.plot(rmse, rows - ASIDE, "o", color=LOWER_COLOUR, markersize=6, label="rms of residuals")
    if checked:
        left.plot(outside, rows + ASIDE, "D", color=UPPER_COLOUR, markersize=5, label="cross-validated")
    for values, aside, marker, colour, name in (
        (np.array([one.aicc for one in models]), -ASIDE, "o", LOWER_COLOUR, "AICc"),
        (np.array([one.bic for one in models]), ASIDE, "D", UPPER_COLOUR, "BIC"),
    ):
        right.plot(values - np.nanmin(values), rows + aside, marker, color=colour, markersize=5.5, label=name)
    left.set_yticks(rows, [f"{one.model} ({one.parameters})" for one in models], size=TEXT_SIZE)
    style_axes(left, x_label=f"error [{unit}]", y_label="")
    style_axes(right, x_label="above the best", y_label="")
    left.set_ylim(len(models) - 0.5, -0.5)
    if np.nanmax(rmse) > SPREAD * np.nanmin(rmse):
        log_axis(left.xaxis, rmse)
    else:
        left.set_xlim(0, 1.1 * np.nanmax(np.append(rmse, outside)))
    right.set_xscale("symlog", linthresh=10)
    right.set_xlim(-1, 2 * max(10.0, np.nanmax([one.bic for one in models]) - np.nanmin([one.bic for one in models])))
    right.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for axes, side in ((left, "left"), (right, "right")):
        place = {"loc": f"outside lower {side}", "fontsize": SMALL_SIZE, "frameon": False, "labelcolor": FAINT_INK}
        figure.legend(*axes.get_legend_handles_labels(), ncols=2, **place)
    return figure


def _strongest(matrix: np.ndarray, names: list[str]) -> str:
    upper = np.abs(np.triu(matrix, 1))
    i, j = np.unravel_index(int(np.argmax(upper)), upper.shape)
    return f"Strongest: {names[i]} and {names[j]}, {_precise(float(matrix[i, j]))}"


def _precise(value: float) -> str:
    return f"{value:.6f}".rstrip("0") if abs(value) > ALL_BUT_ONE else f"{value:.2f}"


def _percent(value: float) -> str:
    if abs(value) > ALL_BUT_ONE:
        return f"{100 * value:.4g}"
    return f"{round(100 * value):d}"
