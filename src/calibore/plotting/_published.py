"""Tables and figures of the source drawn anew: layout and legends."""

from collections.abc import Iterator
from textwrap import wrap

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from calibore.plotting._figures import INK, SMALL_SIZE, TEXT_SIZE, WIDTH, new_figure
from calibore.plotting._published_charts import LINE_STYLES, TONES, draw_chart
from calibore.plotting._published_maps import draw_map, map_bar, region_patches
from calibore.published import Chart, Map, Picture

LINE_LENGTH = 128
CHART_HEIGHT, SQUARE, HIGHEST_MAP = 3.4, 5.6, 2.6
MARGIN, BAR, TICKS = 1.0, 0.9, 0.35
"""Inches: what labels, a bar and ticks take."""

ROW_NAME_AT, SMALL_ROW_NAME_AT = -54, -34
"""Points left of the first column."""


def published_picture(picture: Picture) -> Figure:
    """`picture` as a figure of the standard width: its panels in the layout of the source, one legend for all."""
    notes = wrap(picture.note, LINE_LENGTH)
    figure = new_figure(
        _height(picture, len(notes)), title=f"{published_number(picture.name)}: {picture.title}", notes=notes
    )
    panels = picture.panels
    widths = [1.25 if isinstance(panel, Chart) and len(panels[0]) > 1 else 1.0 for panel in panels[0]]
    grid = figure.add_gridspec(len(panels), len(panels[0]), width_ratios=widths)
    maps: list[Axes] = []
    for row, line in enumerate(panels):
        for column, panel in enumerate(line):
            axes = figure.add_subplot(grid[row, column])
            if isinstance(panel, Chart):
                draw_chart(axes, panel)
            else:
                draw_map(figure, axes, panel, small=_is_small(picture))
                _label_axes(axes, picture, row, column)
                maps.append(axes)
            _name(axes, picture, row, column)
    if maps:
        _common(figure, picture, maps)
    handles = list(_handles(figure, picture))
    if handles:
        style = {"fontsize": SMALL_SIZE, "frameon": False, "labelcolor": INK}
        figure.legend(handles=handles, loc="outside lower left", ncols=_legend_columns(handles), **style)
    _settle(figure)
    return figure


def _settle(figure: Figure) -> None:
    """Lay out once, for PNG and SVG alike: each would otherwise do it again, which takes longer than drawing."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")


def published_number(name: str) -> str:
    """`figure_3_03` -> "Figure 3.3"."""
    kind, chapter, number = name.split("_")
    return f"{kind.capitalize()} {chapter}.{int(number)}"


def _is_small(picture: Picture) -> bool:
    return len(picture.panels[0]) > 3 or len(picture.panels) > 3


def _height(picture: Picture, notes: int) -> float:
    """From the panels' own proportions: maps keep the scale of an image, charts have a fixed height."""
    first = picture.panels[0]
    columns = sum(2 if isinstance(panel, Map) and panel.bar else 1 for panel in first) if len(first) < 3 else len(first)
    bars = BAR if picture.bar or len(first) > 2 else 0.0
    width = (WIDTH - MARGIN - bars) / columns
    body = 0.0
    for row in picture.panels:
        maps = [panel for panel in row if isinstance(panel, Map)]
        if maps:
            body += min(HIGHEST_MAP, width * max(_tallness(panel) for panel in maps)) + TICKS
        else:
            body += SQUARE if any(isinstance(panel, Chart) and panel.equal for panel in row) else CHART_HEIGHT
    return body + 1.2 + 0.165 * notes


def _tallness(shown: Map) -> float:
    return abs(float(shown.y[-1] - shown.y[0])) / abs(float(shown.x[-1] - shown.x[0]))


def _name(axes: Axes, picture: Picture, row: int, column: int) -> None:
    """Names of the columns above the first row, of the rows beside the first column."""
    if picture.columns and row == 0:
        size = SMALL_SIZE if len(picture.columns) > 3 else TEXT_SIZE
        axes.set_title(picture.columns[column], size=size, color=INK)
    if picture.rows and column == 0:
        left = SMALL_ROW_NAME_AT if _is_small(picture) else ROW_NAME_AT
        style = {"size": TEXT_SIZE, "color": INK, "weight": "bold", "rotation": 90, "ha": "right", "va": "center"}
        at = {"xy": (0, 0.5), "xycoords": "axes fraction", "xytext": (left, 0), "textcoords": "offset points"}
        axes.annotate(picture.rows[row], **at, **style)


def _common(figure: Figure, picture: Picture, maps: list[Axes]) -> None:
    if picture.bar:
        first = next(panel for line in picture.panels for panel in line if isinstance(panel, Map))
        every = [panel for line in picture.panels for panel in line if isinstance(panel, Map)]
        map_bar(figure, maps, first, picture.bar, above=any(panel.has_above for panel in every))


def _label_axes(axes: Axes, picture: Picture, row: int, column: int) -> None:
    """The labels of the maps, on the outer ones only."""
    if row == len(picture.panels) - 1:
        axes.set_xlabel(picture.axes[0], size=SMALL_SIZE - _is_small(picture), color=INK)
    if _is_alike(picture):
        axes.tick_params(labelbottom=row == len(picture.panels) - 1, labelleft=column == 0)
    if column == 0:
        axes.set_ylabel(picture.axes[1], size=SMALL_SIZE - _is_small(picture), color=INK)


def _is_alike(picture: Picture) -> bool:
    """Whether all maps of a full table show the same place."""
    maps = [panel for line in picture.panels for panel in line if isinstance(panel, Map)]
    ends = {(float(one.x[0]), float(one.x[-1]), float(one.y[0]), float(one.y[-1])) for one in maps}
    return bool(picture.rows) and len(ends) == 1 and not maps[0].bar


def _handles(figure: Figure, picture: Picture) -> Iterator[Artist]:
    """Every labelled line once, then what the colours of the regions mean."""
    seen: set[str] = set()
    for axes in figure.axes:
        for artist in (*axes.lines, *axes.patches):
            label = str(artist.get_label())
            if label and not label.startswith("_") and label not in seen:
                seen.add(label)
                yield artist
    for line in picture.panels:
        for panel in line:
            for level in panel.levels if isinstance(panel, Map) else ():
                if level.label not in seen:
                    seen.add(level.label)
                    yield _level_line(level.label, level.tone, level.style)
    maps = [panel for line in picture.panels for panel in line if isinstance(panel, Map)]
    yield from region_patches(maps)


def _level_line(label: str, tone: str, style: str) -> Line2D:
    return Line2D([], [], color=TONES[tone], linestyle=LINE_STYLES[style], label=label, linewidth=1.4)


def _legend_columns(handles: list[Artist]) -> int:
    longest = max(len(str(handle.get_label())) for handle in handles)
    return max(1, min(len(handles), 115 // (longest + 7)))
