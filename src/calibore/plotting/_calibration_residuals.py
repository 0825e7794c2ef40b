"""What a calibration's model leaves unexplained: over the image, as a histogram, and against the image radius."""

from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from calibore.calibration import Calibration, Observations
from calibore.optics import Camera
from calibore.plotting._calibration_parts import camera_of, image_axes, side_bar
from calibore.plotting._figures import (
    FAINT_INK,
    INK,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import length_unit

Floats = NDArray[Any]
SIGNED_COLOURS = "PuOr_r"
"""Violet to orange: signs are told apart with every common colour blindness."""
SHOWN = 3.0
"""Standard deviations at which colours and histograms end."""
LONGEST = 0.045
"""Of the image's width: the arrow of a large residual."""
BINS, RADIAL_BINS = 41, 14
FEWEST = 12
"""Residuals in a bin from which on its rms says something."""


class Residuals(NamedTuple):
    """Those that count, in the reader's `unit`: place `u`, `v` [px], `value` and its standard deviation `sigma`."""

    u: Floats
    v: Floats
    value: Floats
    sigma: Floats
    unit: str


def residuals_of(seen: Observations, unit: str) -> Residuals:
    scale, symbol = (length_unit(unit).metres, unit) if seen.unit == "m" else (1.0, seen.unit)
    used = (seen.weight > 0) & np.isfinite(seen.residual)
    return Residuals(seen.u[used], seen.v[used], seen.residual[used] / scale, seen.sigma[used] / scale, symbol)


def residual_map(calibration: Calibration, *, unit: str = "mm") -> Figure | None:
    """Residuals where they were seen: arrows where both coordinates of marks are known, else dots coloured by size."""
    camera, found = camera_of(calibration), residuals_of(calibration.observations, unit)
    if camera is None or not np.isfinite(found.u).any():
        return None
    rms = float(np.sqrt((found.value**2).mean()))
    pairs = _pairs(calibration.observations)
    pictures = len({*calibration.observations.file.tolist()})
    notes = [
        f"{found.value.size} residuals of {pictures} picture{'s' * (pictures > 1)}, rms {rms:.2g} {found.unit};"
        " a good model leaves no pattern",
    ]
    figure = new_figure(6.2, title="What the model leaves, over the image", notes=notes)
    axes = figure.subplots()
    image_axes(axes, camera)
    if pairs is None:
        _dots(figure, axes, found)
    else:
        _arrows(figure, axes, pairs, camera)
    return figure


def residual_chart(calibration: Calibration, *, unit: str = "mm") -> Figure | None:
    """The residuals' distribution, and their rms against the distance from the principal point."""
    camera, found = camera_of(calibration), residuals_of(calibration.observations, unit)
    if found.value.size < FEWEST:
        return None
    placed = camera is not None and bool(np.isfinite(found.u).any())
    notes = [f"Noise of one residual {_sigma(found):.3g} {found.unit}; {_tails(found)}"]
    figure = new_figure(3.9, title="Residuals", notes=notes)
    panels = np.atleast_1d(figure.subplots(1, 2 if placed else 1))
    _histogram(panels[0], found)
    if camera is not None and placed:
        _against_radius(panels[1], found, camera)
    return figure


def _pairs(seen: Observations) -> tuple[Floats, Floats] | None:
    """Places (n, 2) and residuals (n, 2) [px] where every mark of every picture has exactly two, of u and of v."""
    used = (seen.weight > 0) & np.isfinite(seen.u)
    if seen.unit != "px" or used.sum() % 2:
        return None
    order = np.lexsort((np.flatnonzero(used), seen.v[used], seen.u[used], seen.file[used]))
    place = np.stack([seen.file[used], seen.u[used], seen.v[used]], axis=1)[order]
    if not (place[::2] == place[1::2]).all() or (place[:-1:2][1:] == place[1::2][:-1]).all(axis=1).any():
        return None
    return place[::2, 1:], seen.residual[used][order].reshape(-1, 2)


def _arrows(figure: Figure, axes: Axes, pairs: tuple[Floats, Floats], camera: Camera) -> None:
    place, value = pairs
    size = np.linalg.norm(value, axis=1)
    large = float(np.quantile(size, 0.95)) or 1.0
    norm = Normalize(0, large)
    scale = large / (LONGEST * camera.width)
    drawn = axes.quiver(
        *place.T, *value.T, size, angles="xy", scale_units="xy", scale=scale, cmap="viridis_r", norm=norm, width=0.0022
    )
    axes.quiverkey(drawn, 0.9, 1.03, large, f"{large:.2g} px", labelpos="W", fontproperties={"size": SMALL_SIZE})
    bar = figure.colorbar(drawn, ax=axes, extend="max", **side_bar())
    bar.set_label(f"size of the residual [px]; arrows {1 / scale:.0f} times as long", size=SMALL_SIZE, color=INK)
    bar.ax.tick_params(labelsize=SMALL_SIZE)


def _dots(figure: Figure, axes: Axes, found: Residuals) -> None:
    limit = SHOWN * _sigma(found)
    norm = Normalize(-limit, limit)
    order = np.argsort(np.abs(found.value))
    area = float(np.clip(3e4 / found.value.size, 1.5, 16))
    axes.scatter(
        found.u[order], found.v[order], c=found.value[order], s=area, cmap=SIGNED_COLOURS, norm=norm, linewidths=0
    )
    bar = figure.colorbar(ScalarMappable(norm, mpl.colormaps[SIGNED_COLOURS]), ax=axes, extend="both", **side_bar())
    bar.set_label(f"measured minus predicted [{found.unit}]", size=SMALL_SIZE, color=INK)
    bar.ax.tick_params(labelsize=SMALL_SIZE)


def _histogram(axes: Axes, found: Residuals) -> None:
    limit = 4 * _sigma(found)
    edges = np.linspace(-limit, limit, BINS)
    kept = np.clip(found.value, edges[0], edges[-1])
    axes.hist(kept, edges.tolist(), color=LOWER_COLOUR, alpha=0.55, label="found (beyond the ends: in the last bars)")
    x = np.linspace(-limit, limit, 400)
    density = np.exp(-0.5 * (x / _sigma(found)) ** 2) / (_sigma(found) * np.sqrt(2 * np.pi))
    axes.plot(x, density * found.value.size * (edges[1] - edges[0]), color=MEAN_COLOUR, label="normal, of that noise")
    style_axes(axes, x_label=f"measured minus predicted [{found.unit}]", y_label="residuals")
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10], symmetric=True))
    _legend_below(axes)


def _against_radius(axes: Axes, found: Residuals, camera: Camera) -> None:
    away = np.hypot(found.u - camera.principal_point[0], found.v - camera.principal_point[1])
    edges = np.linspace(0, float(np.nanmax(away)) * (1 + 1e-9), RADIAL_BINS + 1)
    where = np.digitize(away, edges) - 1
    middle, mean, rms = [], [], []
    for number in range(RADIAL_BINS):
        inside = found.value[where == number]
        if inside.size >= FEWEST:
            middle.append(edges[number : number + 2].mean())
            mean.append(inside.mean())
            rms.append(np.sqrt((inside**2).mean()))
    axes.axhline(0, color=FAINT_INK, linewidth=0.8)
    axes.axhline(_sigma(found), color=MEAN_COLOUR, linewidth=1, linestyle=":", label="noise of one residual")
    axes.plot(middle, rms, "o-", color=LOWER_COLOUR, markersize=4, label="rms")
    axes.plot(middle, mean, "s--", color=UPPER_COLOUR, markersize=4, label="mean: a trend is the model's")
    style_axes(axes, x_label="distance from the principal point [px]", y_label=f"residual [{found.unit}]")
    axes.set_xlim(left=0)
    _legend_below(axes)


def _legend_below(axes: Axes) -> None:
    axes.legend(
        fontsize=SMALL_SIZE, frameon=False, loc="upper left", bbox_to_anchor=(-0.05, -0.2), labelcolor=FAINT_INK
    )


def _sigma(found: Residuals) -> float:
    return float(np.sqrt(np.median(found.sigma**2))) or float(np.sqrt((found.value**2).mean())) or 1.0


def _tails(found: Residuals) -> str:
    beyond = 100 * float((np.abs(found.value) > SHOWN * found.sigma).mean())
    return f"{beyond:.2g} % lie beyond {SHOWN:g} standard deviations (0.27 % if normal)"
