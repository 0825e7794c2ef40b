"""A published map: values in steps of colour, regions without a value, lines of equal value."""

from collections.abc import Iterator, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, LinearSegmentedColormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from calibore.plotting._figures import INK, SMALL_SIZE, TEXT_SIZE
from calibore.plotting._published_charts import LINE_STYLES, TONES
from calibore.published import Level, Map, Region

STEPS, SIGNED_STEPS = 10, 12
"""Colours of a bar; every second boundary carries a number, as in the source."""

REGION_LOOKS: dict[Region, tuple[str, str]] = {
    Region.COMPLEX: ("#5e4fa2", "no meeting (complex)"),
    Region.NEGATIVE: ("#7cc4ee", "behind the camera (negative)"),
    Region.GRAZING: ("#8f8f8f", "too grazing to measure"),
    Region.UNSEEN: ("#e4e4e4", "beyond 90 deg"),
}
ABOVE = "white"


def colours_of(shown: Map) -> tuple[Colormap, BoundaryNorm]:
    """Light to dark for quantities above zero, two-sided for signed ones; both hold for the colour-blind."""
    signed = shown.low < 0
    base = mpl.colormaps["PuOr_r" if signed else "YlOrBr"]
    steps = SIGNED_STEPS if signed else STEPS
    part = np.linspace(0.08, 0.92, steps) if signed else np.linspace(0.12, 0.97, steps)
    colours = LinearSegmentedColormap.from_list("steps", base(part), steps).with_extremes(over=ABOVE, under=base(0.0))
    return colours, BoundaryNorm(np.linspace(shown.low, shown.high, steps + 1), steps)


def draw_map(figure: Figure, axes: Axes, shown: Map, *, small: bool) -> None:
    """The image of `shown`, its lines and, if it has one, its own bar."""
    axes.imshow(
        _painted(shown),
        extent=_extent(shown),
        origin="lower" if shown.y[0] < shown.y[-1] else "upper",
        interpolation="nearest",
    )
    width = 0.8 if small else 1.2
    for level in shown.levels:
        _draw_level(axes, shown, level, width=width)
    for line in shown.lines:
        drawn = axes.plot(line.x, line.y, color=TONES[line.tone], linewidth=width, label=line.label)
        drawn[0].set_path_effects([_casing(width)])
    left, right, bottom, top = _extent(shown)
    axes.set(xlim=(left, right), ylim=(bottom, top))
    axes.set_aspect("equal")
    axes.tick_params(labelsize=SMALL_SIZE - 2 if small else SMALL_SIZE - 1, pad=1.5, length=2.5)
    axes.locator_params(nbins=3 if small else 5)
    if shown.title:
        axes.set_title(shown.title, size=TEXT_SIZE, color=INK)
    if shown.bar:
        map_bar(figure, axes, shown, shown.bar, above=shown.has_above)


def map_bar(figure: Figure, axes: Axes | Sequence[Axes], shown: Map, label: str, *, above: bool) -> None:
    """The bar of the colours of `shown`, beside `axes`."""
    colours, norm = colours_of(shown)
    extend = "max" if above else "neither"
    one = isinstance(axes, Axes)
    place = {"fraction": 0.06, "pad": 0.02, "aspect": 22} if one else {"fraction": 0.03, "pad": 0.015, "aspect": 34}
    bar = figure.colorbar(ScalarMappable(norm, colours), ax=axes, extend=extend, **place)
    marks = norm.boundaries[::2]
    bar.set_ticks(list(marks), labels=[_short(value) for value in marks])
    bar.set_label(label, size=TEXT_SIZE, color=INK)
    bar.ax.tick_params(labelsize=SMALL_SIZE)


def region_patches(maps: Sequence[Map]) -> Iterator[Artist]:
    """What the colours outside the bars mean, of those that occur."""
    for region, (colour, meaning) in REGION_LOOKS.items():
        if any((shown.regions == region).any() for shown in maps):
            yield Patch(facecolor=colour, label=meaning)
    if any(shown.has_above for shown in maps):
        yield Patch(facecolor=ABOVE, edgecolor=INK, linewidth=0.6, label="above the bar")


def _painted(shown: Map) -> NDArray[np.float64]:
    """(h, w, 4) colours."""
    colours, norm = colours_of(shown)
    painted = np.array(colours(norm(np.nan_to_num(shown.values, nan=shown.low))))
    for region, (colour, _) in REGION_LOOKS.items():
        painted[shown.regions == region] = to_rgba(colour)
    return painted


def _extent(shown: Map) -> tuple[float, float, float, float]:
    """Outer edges: the coordinates are centres of pixels."""
    half_x, half_y = (abs(float(a[1] - a[0])) / 2 for a in (shown.x, shown.y))
    left, right = float(shown.x.min()) - half_x, float(shown.x.max()) + half_x
    return left, right, float(shown.y.min()) - half_y, float(shown.y.max()) + half_y


def _draw_level(axes: Axes, shown: Map, level: Level, *, width: float) -> None:
    values = np.ma.masked_invalid(level.values)
    if not values.min() < level.at < values.max():
        return
    line = axes.contour(
        shown.x,
        shown.y,
        values,
        [level.at],
        colors=[TONES[level.tone]],
        linewidths=width,
        linestyles=[LINE_STYLES[level.style]],
    )
    line.set_path_effects([_casing(width)])


def _casing(width: float) -> patheffects.withStroke:
    """A light edge: the line must stand out on dark colours too."""
    return patheffects.withStroke(linewidth=width + 1.2, foreground="white", alpha=0.85)


def _short(value: float) -> str:
    if abs(value) < 1e-9:
        return "0"
    return f"{value:.3g}" if abs(value) >= 1e-3 else f"{value:.2e}".replace("e-0", "e-")
