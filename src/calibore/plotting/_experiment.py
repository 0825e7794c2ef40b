"""The experiment's pictures: points of the wall seen from outside, errors against baseline and radius."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibore.experiment import EXACT, INCH, NOMINAL_RADIUS, SPREAD, TABLE_8_3, LaserOutcome, Outcome
from calibore.plotting._bands import bands_of
from calibore.plotting._design import DesignPicture
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
from calibore.plotting._stations import Floats

MOST_POINTS = 5000
BANDS = 24
"""Of the radius."""
TURN, RISE = np.radians(32.0), np.radians(24.0)
"""From where a pipe is looked at in three dimensions."""


def experiment_pictures(found: Outcome) -> Iterator[DesignPicture]:
    """In the order of the chapters."""
    planes, heads, cones = (found.of_kind(kind) for kind in ("plane", "side", "cone"))
    for name, title, draw, lasers, caption in (
        ("figure_6_21", "Figure 6.21: three-dimensional views", solid_views, planes,
         "Darker: nearer to the axis than the nominal radius. What hides from the camera leaves gaps, the more the "
         "longer the baseline."),
        ("figure_6_22", "Figure 6.22: top and front views", plain_views, planes,
         "Seen along the pipe, a noisier profile is a thicker ring."),
        ("figure_7_27", "Figure 7.27: side-facing head, front and top views", plain_views, heads,
         "The head sees the wall at right angles: little hides from it."),
        ("figure_8_13", "Figure 8.13: error against baseline", baseline_chart, planes,
         "Left: as published, bars one standard deviation of the absolute errors to either side of the rms. Right: "
         "ours, against the tactile profile, rig files exact."),
        ("table_8_04", "Table 8.4: errors against radii, perpendicular plane", radius_charts, planes,
         "Dots: points, rig file exact, against the tactile profile. Shaded: what is predicted to hold 95 % of them."),
        ("figure_8_14", "Figure 8.14: errors against radii, side-facing head", radius_charts, heads,
         "As above."),
        ("cone", "Errors against radii, cone beside the camera", radius_charts, cones,
         "Not in the dissertation's experiment; its chapter 3 predicts it."),
    ):  # fmt: skip
        if lasers:
            yield DesignPicture(name, title, caption, draw(lasers))


def solid_views(lasers: Sequence[LaserOutcome]) -> Figure:
    """Every measured point from above and beside, for each laser."""
    figure = new_figure(6.4, title="Measured points of the test pipe", notes=["Travel to the upper right; inches"])
    for axes, laser in zip(figure.subplots(2, 2).ravel(), lasers, strict=False):
        x, y, z, deviation = _points(laser)
        across, up = (
            x * np.cos(TURN) + z * np.sin(TURN),
            -y * np.cos(RISE) + (z * np.cos(TURN) - x * np.sin(TURN)) * np.sin(RISE),
        )
        depth = np.argsort(-(z * np.cos(TURN) - x * np.sin(TURN)))
        some = _thinned(depth)
        _cloud(axes, across[some], up[some], deviation[some])
        axes.set_title(laser.instrument.title, size=TEXT_SIZE, color=INK)
        axes.set_axis_off()
    return figure


def plain_views(lasers: Sequence[LaserOutcome]) -> Figure:
    """Front (along the pipe) and top view of each."""
    notes = ["Front: seen along travel, crown up. Top: seen from above, the upper half only"]
    figure = new_figure(4.3, title="Measured points, front and top", notes=notes)
    grid = figure.subplots(2, len(lasers), squeeze=False) if len(lasers) > 1 else figure.subplots(1, 2).reshape(2, 1)
    for (front, top), laser in zip(grid.T, lasers, strict=True):
        x, y, z, deviation = _points(laser)
        some = _thinned(np.arange(x.size))
        _cloud(front, x[some], -y[some], deviation[some])
        upper = some[y[some] < 0]
        _cloud(top, x[upper], z[upper], deviation[upper])
        style_axes(front, x_label="x [in]", y_label="up [in]", grid=False)
        style_axes(top, x_label="x [in]", y_label="axial [in]", grid=False)
        front.set_title(laser.instrument.title, size=TEXT_SIZE, color=INK)
    return figure


def baseline_chart(lasers: Sequence[LaserOutcome]) -> Figure:
    """Observed and predicted uncertainty of the plane rigs against their baseline."""
    figure = new_figure(
        3.9,
        title="Error and prediction against the baseline",
        notes=["rms: root mean square error, eq. 8-4; predicted: theirs for the worst case, ours rms of the stated u"],
    )
    left, right = figure.subplots(1, 2)
    theirs = [TABLE_8_3[one.name] for one in lasers]
    ours = [one.by_touch[EXACT] for one in lasers]
    baseline = np.array([one.instrument.baseline for one in lasers])
    # rms + sd = worst case, and sd is "about 60 %" of rms (8.4.2.1)
    rms = np.array([one.worst_case for one in theirs]) / (1 + SPREAD)
    _against_baseline(left, baseline, rms, SPREAD * rms, np.array([one.predicted for one in theirs]), "published")
    own = np.array([[one.rms, one.spread, one.predicted] for one in ours]).T / INCH
    _against_baseline(right, baseline, own[0], own[1], own[2], "ours")
    figure.legend(
        *left.get_legend_handles_labels(), loc="outside lower left", ncols=3, fontsize=SMALL_SIZE, frameon=False
    )
    return figure


def _against_baseline(axes: Axes, baseline: Floats, rms: Floats, spread: Floats, predicted: Floats, title: str) -> None:
    axes.errorbar(
        baseline,
        rms,
        yerr=spread,
        color=LOWER_COLOUR,
        marker="o",
        capsize=3,
        label="observed rms, ± standard deviation of |error|",
    )
    axes.plot(baseline, predicted, "s--", color=UPPER_COLOUR, label="predicted")
    axes.set_xscale("log")
    axes.set_xticks(baseline, [f"{value:g}" for value in baseline])
    axes.minorticks_off()
    axes.set_ylim(0, None)
    style_axes(axes, x_label="nominal baseline [in]", y_label="error [in]")
    axes.set_title(title, size=TEXT_SIZE, color=INK)


def radius_charts(lasers: Sequence[LaserOutcome]) -> Figure:
    """Errors of every point against the radius of the tactile profile there, one panel for each."""
    count = len(lasers)
    figure = new_figure(
        5.6 if count > 1 else 3.6,
        title="Errors against the radius",
        notes=["Shaded: predicted to hold 95 % of the points of a band of radii; line: what holds 95 % of them"],
    )
    panels = figure.subplots(2, 2, squeeze=False).ravel() if count > 1 else [figure.subplots()]
    for axes, laser in zip(panels, lasers, strict=False):
        one = laser.by_touch[EXACT]
        radius, value = one.radius / INCH, one.value / INCH
        edges, half, reach = bands_of(radius, value, one.u / INCH, count=BANDS)
        axes.stairs(half, edges, baseline=-half, fill=True, color=UPPER_COLOUR, alpha=0.22, label="predicted, 95 %")
        some = _thinned(np.arange(radius.size))
        axes.plot(
            radius[some], value[some], ".", color=LOWER_COLOUR, markersize=2, alpha=0.5, label="points", rasterized=True
        )
        axes.stairs(reach, edges, baseline=-reach, color=INK, linewidth=1.0, label="observed, 95 % of points")
        end = 1.2 * max(float(np.quantile(np.abs(value), 0.995)), float(np.nanmedian(half)))
        axes.set_ylim(-end, end)
        style_axes(axes, x_label="radius, tactile [in]", y_label="error [in]")
        axes.set_title(
            f"{laser.instrument.title}: rms {one.rms / INCH:.4f} in, {100 * one.inside:.1f} % inside",
            size=TEXT_SIZE,
            color=INK,
        )
    style = {"fontsize": SMALL_SIZE, "frameon": False, "labelcolor": FAINT_INK}
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower left", ncols=3, **style)
    return figure


def _points(laser: LaserOutcome) -> tuple[Floats, Floats, Floats, Floats]:
    """x, y, z of every measured point and how far it is from the nominal radius [in], all (p,)."""
    profile = laser.profile
    row, column = np.nonzero(profile.measured)
    radius, clock = profile.radius[row, column] / INCH, profile.clock[column]
    z = profile.axial_position[row, column] / INCH
    return radius * np.sin(clock), -radius * np.cos(clock), z, radius - NOMINAL_RADIUS / INCH


def _thinned(order: np.ndarray) -> np.ndarray:
    return order[:: max(1, order.size // MOST_POINTS)]


def _cloud(axes: Axes, x: Floats, y: Floats, deviation: Floats) -> None:
    axes.scatter(x, y, c=deviation, s=1.2, cmap="cividis", vmin=-1.2, vmax=0.4, linewidths=0, rasterized=True)
    axes.set_aspect("equal")
