"""The registration, looked at: single rings of both profiles, before and after."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from calibore.comparison import Compared
from calibore.plotting._figures import (
    FAINT_INK,
    LOWER_COLOUR,
    MEAN_COLOUR,
    SMALL_SIZE,
    UPPER_COLOUR,
    new_figure,
    style_axes,
)
from calibore.plotting._lengths import axial_unit, length_unit, plain_text
from calibore.plotting._stations import Floats
from calibore.plotting._walls import CLOCK_TICKS, centred_clock
from calibore.registration import Motion, Surface, gaps

SHOWN = 3
"""Rings: the worst, a typical one, the best."""


def registration_chart(found: Compared, *, unit: str = "mm") -> Figure:
    """Rings developed: left both walls, right what is left between them; before and after the registration."""
    scale, rings = length_unit(unit), found.rings
    rows = sorted(rings, key=lambda row: -rings[row].rms)
    rows = [rows[i] for i in sorted({0, len(rows) // 2, len(rows) - 1})][:SHOWN]
    notes = [
        f"{found.names[0]} moved onto {found.names[1]}, with standard uncertainties:",
        _moved_note(found, unit),
        "Left: wall minus the median radius of the reference. Right: difference to the reference",
    ]
    figure = new_figure(1.45 + 2.05 * len(rows), title="Registration: rings before and after", notes=notes)
    table = figure.subplots(len(rows), 2, sharex=True, squeeze=False)
    before = _before(found)
    along = axial_unit(unit, float(np.ptp([one.place for one in rings.values()])) if len(rings) > 1 else 0.0)
    for number, row in enumerate(rows):
        left, right = table[number]
        one, clock = found.difference, found.clock
        reference = one.radius[row] - one.value[row]
        nominal = found.reference.typical_radius
        shown = (
            (found.moving.clock, found.moving.radius[row], UPPER_COLOUR, "before"),
            (clock, one.radius[row], LOWER_COLOUR, "after"),
            (clock, reference, MEAN_COLOUR, "reference"),
        )
        for at, radius, colour, label in shown:
            _line(left, at, (radius - nominal) / scale.metres, colour, label)
        _line(right, found.moving.clock, before[row] / scale.metres, UPPER_COLOUR, "before")
        _line(right, clock, one.value[row] / scale.metres, LOWER_COLOUR, "after")
        place = f"axial {rings[row].place / along.metres:.4g} {along.symbol}"
        style_axes(left, x_label="", y_label=f"{place}\nwall [{unit}]")
        style_axes(right, x_label="", y_label=f"difference [{unit}]")
        _limits(right, np.concatenate([before[row], one.value[row]]) / scale.metres)
    for axes in table[-1]:
        axes.set_xlabel("clock position, looking along travel", size=SMALL_SIZE + 1)
        axes.set_xlim(-np.pi, np.pi)
        axes.set_xticks([at for at, _ in CLOCK_TICKS], [name for _, name in CLOCK_TICKS])
    figure.legend(
        *table[0][0].get_legend_handles_labels(), loc="outside lower left", ncols=4, fontsize=SMALL_SIZE,
        frameon=False, labelcolor=FAINT_INK,
    )  # fmt: skip
    return figure


def _before(found: Compared) -> Floats:
    """(n, m) [m] moving minus reference where nothing is moved."""
    cloud = found.registration.cloud
    left = gaps(cloud, Surface(found.reference), Motion())
    whole = np.full(found.moving.radius.shape, np.nan)
    whole[cloud.ring, cloud.position] = -left.residual
    return whole


def _moved_note(found: Compared, unit: str) -> str:
    registration, scale = found.registration, length_unit(unit)
    said = []
    for name in registration.names:
        value, u = getattr(registration.motion, name), registration.u(name)
        if name in ("shift_x", "shift_y", "axial"):
            said.append(f"{name.replace('_', ' ')} {_with_u(value / scale.metres, u / scale.metres)} {unit}")
        elif name == "roll":
            said.append(f"roll {_with_u(float(np.degrees(value)), float(np.degrees(u)))} deg")
    return ", ".join(said) or "as given, nothing was free"


def _with_u(value: float, u: float) -> str:
    return f"{value:+.{max(0, 1 - int(np.floor(np.log10(u)))) if u > 0 else 3}f} ± {plain_text(u, 2)}"


def _line(axes: Axes, clock: Floats, values: Floats, colour: str, label: str) -> None:
    at = centred_clock(clock)
    order = np.argsort(at)
    axes.plot(at[order], values[order], color=colour, linewidth=1.0, label=label)


def _limits(axes: Axes, values: Floats) -> None:
    """Edges must not flatten everything else."""
    size = np.abs(values[np.isfinite(values)])
    end = 1.25 * float(np.quantile(size, 0.98)) if size.size else 1.0
    axes.set_ylim(-end or -1.0, end or 1.0)
    axes.axhline(0, color=FAINT_INK, linewidth=0.6)
