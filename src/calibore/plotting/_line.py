"""One camera image with the line that was found in it, and close-ups in which line and image can be compared."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from calibore.errors import InputError
from calibore.plotting._figures import INK, SMALL_SIZE, TEXT_SIZE, new_figure, style_axes
from calibore.plotting._stations import Floats
from calibore.status import MEANING, Status

MARKERS: dict[int, tuple[str, str]] = {
    Status.OK: (".", "#00b4f0"),
    Status.RESOLVED: ("^", "#e69f00"),
    Status.SATURATED: ("s", "#ff5fb4"),
    Status.NO_PEAK: ("x", "#ffffff"),
    Status.MULTIPLE: ("d", "#f0e442"),
    Status.OFF_RING: ("+", "#d55e00"),
    Status.NOT_LASER: ("*", "#7fd6b5"),
}
OTHER_MARKER = ("1", "#c9c9c9")
OFFSET = 1.07
"""Rays without a point are marked this far out, in ring radii, so that no mark covers the image of the line."""

CLOSE_UPS = (("A: top", -np.pi / 2), ("B: right", 0.0), ("C: bottom", np.pi / 2), ("D: left", np.pi))
"""Image azimuth from +u towards +v (down)."""

GAMMA = 0.5


def detected_line(image: Any, u: Any, v: Any, status: Any, *, title: str = "Detected line in one image") -> Figure:
    """`image` (h, w) or (h, w, 3) with the points `u`, `v` (n,) [px] and their `status` (n,) in order round the ring.

    Rays without a point (NaN) are marked outside the ring. Four close-ups show single points on single pixels.
    """
    shade, u, v, status = _shade(image), np.asarray(u, float), np.asarray(v, float), np.asarray(status)
    if not u.shape == v.shape == status.shape or u.ndim != 1:
        raise InputError(f"u, v and status must be of one length, got {u.shape}, {v.shape} and {status.shape}.")
    known = np.isfinite(u) & np.isfinite(v)
    share = 100 * known.mean() if len(u) else 0.0
    notes = [f"{int(known.sum())} of {len(u)} rays have a point ({share:.1f} %); brightness is stretched (square root)"]
    figure = new_figure(8.6, title=title, notes=notes)
    main, *small = _panels(figure)
    _show(main, shade)
    style_axes(main, x_label="u [px]", y_label="v [px]", grid=False)
    _mark_points(main, u, v, status, size=1.0, labels=True)
    _mark_missing(main, u, v, status)
    for axes, (name, azimuth) in zip(small, CLOSE_UPS, strict=True):
        _close_up(main, axes, shade, (u, v, status), name, azimuth)
    _add_legend(figure, main)
    return figure


def _shade(image: Any) -> Floats:
    """Brightness 0..1 (h, w): the brightest channel, stretched so that faint parts of the line can be seen."""
    pixels = np.asarray(image, float)
    if pixels.ndim == 3:
        pixels = pixels.max(axis=2)
    if pixels.ndim != 2 or pixels.size == 0:
        raise InputError(f"An image must be (h, w) or (h, w, 3), got shape {np.shape(image)}.")
    low, high = np.percentile(pixels, 1), pixels.max()
    return np.clip((pixels - low) / max(high - low, 1e-12), 0, 1) ** GAMMA


def _panels(figure: Figure) -> list[Axes]:
    grid = figure.add_gridspec(2, 4, height_ratios=(2.7, 1.0))
    return [figure.add_subplot(grid[0, :]), *(figure.add_subplot(grid[1, column]) for column in range(4))]


def _show(axes: Axes, shade: Floats) -> None:
    axes.imshow(shade, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    axes.set_facecolor("black")


def _look(code: int) -> tuple[str, str, str]:
    """Marker, colour and meaning of a status; an unknown one is named by its number."""
    meanings = {int(status): meaning for status, meaning in MEANING.items()}
    return *MARKERS.get(code, OTHER_MARKER), meanings.get(code, f"status {code}")


def _mark_points(axes: Axes, u: Floats, v: Floats, status: Any, *, size: float, labels: bool) -> None:
    for code in np.unique(status[np.isfinite(u)]):
        chosen = np.isfinite(u) & (status == code)
        marker, colour, meaning = _look(int(code))
        label = f"{meaning} ({int(chosen.sum())})" if labels else None
        scale = size if int(code) == Status.OK else 2.6 * size
        axes.plot(u[chosen], v[chosen], marker, color=colour, markersize=scale, markeredgewidth=0, label=label)


def _mark_missing(axes: Axes, u: Floats, v: Floats, status: Any) -> None:
    known = np.isfinite(u) & np.isfinite(v)
    if known.all() or known.sum() < 3:
        return
    at_u, at_v = _beside_ring(u, v, known)
    for code in np.unique(status[~known]):
        chosen = ~known & (status == code)
        marker, colour, meaning = _look(int(code))
        label = f"{meaning} ({int(chosen.sum())}), marked outside the ring"
        style = {"markersize": 3.2, "markeredgewidth": 0.8, "linestyle": "none", "label": label}
        axes.plot(at_u[chosen], at_v[chosen], marker, color=colour, **style)


def _beside_ring(u: Floats, v: Floats, known: Any) -> tuple[Floats, Floats]:
    """Places (n,) just outside the ring for every ray, between its known neighbours in order round the ring."""
    centre_u, centre_v = np.mean(u[known]), np.mean(v[known])
    index, at = np.arange(len(u)), np.flatnonzero(known)
    turn = np.exp(1j * np.arctan2(v[known] - centre_v, u[known] - centre_u))
    radius = np.interp(index, at, np.hypot(u[known] - centre_u, v[known] - centre_v), period=len(u)) * OFFSET
    azimuth = np.unwrap(np.angle(turn))
    whole = np.sign(azimuth[-1] - azimuth[0]) * 2 * np.pi
    turns = np.array([[-1], [0], [1]])
    azimuth = np.interp(index, (at + turns * len(u)).ravel(), (azimuth + turns * whole).ravel())
    return centre_u + radius * np.cos(azimuth), centre_v + radius * np.sin(azimuth)


def _add_legend(figure: Figure, main: Axes) -> None:
    """Marks and their meaning on a dark ground: several of them are light."""
    lines = [line for line in main.lines if not str(line.get_label()).startswith("_")]
    labels = [str(line.get_label()) for line in lines]
    keys = [Line2D([], [], marker=line.get_marker(), color=line.get_color(), linestyle="none") for line in lines]
    style = {"fontsize": SMALL_SIZE, "facecolor": "#2b2b2b", "labelcolor": "white", "edgecolor": "none"}
    figure.legend(keys, labels, loc="outside lower left", ncols=1, **style)


def _close_up(
    main: Axes, axes: Axes, shade: Floats, line: tuple[Floats, Floats, Any], name: str, azimuth: float
) -> None:
    u, v, status = line
    known = np.isfinite(u) & np.isfinite(v)
    if not known.any():
        axes.set_axis_off()
        return
    centre_u, centre_v = np.mean(u[known]), np.mean(v[known])
    away = np.where(known, np.abs(np.angle(np.exp(1j * (np.arctan2(v - centre_v, u - centre_u) - azimuth)))), np.inf)
    at = int(np.argmin(away))
    half = float(np.clip(0.045 * np.ptp(u[known]), 12, 40))
    left, top = u[at] - half, v[at] - half
    _show(axes, shade)
    _mark_points(axes, u, v, status, size=3.5, labels=False)
    axes.set(xlim=(left, left + 2 * half), ylim=(top + 2 * half, top))
    axes.set_title(name, size=TEXT_SIZE, color=INK)
    axes.tick_params(labelsize=SMALL_SIZE - 1)
    axes.locator_params(nbins=3)
    main.add_patch(Rectangle((left, top), 2 * half, 2 * half, fill=False, edgecolor="#f0e442", linewidth=0.9))
    main.text(left + 2 * half, top, f" {name[0]}", color="#f0e442", size=TEXT_SIZE, va="center", ha="left")
