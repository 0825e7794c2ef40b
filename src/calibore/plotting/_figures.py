"""Figures without pyplot: no global state, so pictures may be drawn in several threads at once."""

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox

DOTS_PER_INCH = 150
WIDTH = 8.0
"""Inches; 8 in at 150 dots per inch is a picture 1200 px wide."""

INK, FAINT_INK, GRID = "#1a1a1a", "#595959", "#d9d9d9"
MISSING_GREY = "#8f8f8f"
MEAN_COLOUR, LOWER_COLOUR, UPPER_COLOUR, LIMIT_COLOUR = "#1a1a1a", "#0072b2", "#d55e00", "#a8005c"
"""Black, blue, vermilion after Okabe and Ito, and a dark magenta: told apart with every common colour blindness."""

PLACE_DIGITS = 7
"""Decimals of axes positions, in figure widths; one pixel is about 1e-3."""

TITLE_SIZE, TEXT_SIZE, SMALL_SIZE = 11.5, 9.0, 8.0
COVERAGE_FACTOR = 2.0
"""k of every expanded uncertainty drawn or printed: about 95 % for a normal distribution (JCGM 100, 6.3.3)."""


class _SteadyLayout(ConstrainedLayoutEngine):
    """Constrained layout that places equal figures equally.

    Its solver was seen to give positions that differ in the last bit from one drawing to the next, which now and then
    moves a letter by a pixel; rounded far below a pixel they are the same every time.
    """

    def execute(self, fig: Figure) -> None:
        super().execute(fig)
        for axes in fig.axes:
            place = axes.get_position(original=True)
            steady = Bbox(place.get_points().round(PLACE_DIGITS))
            # The public set_position would take the axes out of the layout for good.
            axes._set_position(steady, which="original")  # pyright: ignore[reportAttributeAccessIssue]


def new_figure(height: float, *, title: str, notes: list[str]) -> Figure:
    """An empty figure `WIDTH` x `height` [in] with a title and, below it, smaller notes, one a line."""
    head = (0.38 + 0.165 * len(notes)) / height
    layout = _SteadyLayout(rect=(0.005, 0.0, 0.99, 1.0 - head), h_pad=0.06, w_pad=0.06)
    figure = Figure(figsize=(WIDTH, height), dpi=DOTS_PER_INCH, layout=layout, facecolor="white")
    FigureCanvasAgg(figure)
    figure.text(0.012, 1 - 0.07 / height, title, size=TITLE_SIZE, weight="bold", color=INK, va="top")
    figure.text(
        0.012, 1 - 0.30 / height, "\n".join(notes), size=SMALL_SIZE, color=FAINT_INK, va="top", linespacing=1.35
    )
    return figure


def style_axes(axes: Axes, *, x_label: str, y_label: str, grid: bool = True) -> None:
    """Labels with units, quiet ticks and, if wanted, a faint grid behind the data."""
    axes.set_xlabel(x_label, size=TEXT_SIZE, color=INK)
    axes.set_ylabel(y_label, size=TEXT_SIZE, color=INK)
    axes.tick_params(labelsize=TEXT_SIZE, color=FAINT_INK, labelcolor=INK)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.set_axisbelow(True)
    if grid:
        axes.grid(color=GRID, linewidth=0.6)


def save_picture(figure: Figure, path: Path) -> Path:
    """`figure` written as PNG, 1200 px wide; the same figure gives the same bytes. Returns `path`."""
    figure.savefig(path, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    return path
