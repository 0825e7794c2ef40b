"""What the pictures of calibrations have in common: the image as axes, the valid region in it, and on walls."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from calibore.calibration import Calibration
from calibore.optics import Camera
from calibore.plotting._figures import INK, style_axes
from calibore.plotting._lengths import LengthUnit
from calibore.rigs import Rig, ValidRegion

Floats = NDArray[Any]
OUTSIDE = "outside the valid region: extrapolated"
SHADE = "#ececec"
REACH = (0.5, 1.6)
"""Nominal radii shown, where the calibration does not say from where to where it holds."""
COARSE, FINE, NARROW, WIDE = (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0), 12.0, 500.0
"""Numbers on a logarithmic axis, and the ratios of its ends below which more, above which fewer of them are needed."""
LEAST = 0.05
"""Nominal radii; on the axis a wall has no radius."""
MARGIN = 0.25
"""Of the valid radii's span, shown beyond them."""


def camera_of(calibration: Calibration) -> Camera | None:
    return calibration.rig.camera if calibration.rig is not None else calibration.camera


def known_rig(calibration: Calibration) -> Rig | None:
    """The rig with its covariance; None where there is none, or nothing is known of it."""
    rig = calibration.rig
    if rig is None or rig.covariance is not None:
        return rig
    mine = set(calibration.covariance.names) & set(rig.parameter_names)
    return rig.knowing(calibration.covariance.restricted(sorted(mine))) if mine else None


def image_axes(axes: Axes, camera: Camera) -> None:
    """The whole image, v downwards, one pixel as wide as high."""
    style_axes(axes, x_label="u [px]", y_label="v [px]", grid=False)
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_aspect("equal" if camera.height > 1 else "auto")
    for side in ("top", "right"):
        axes.spines[side].set_visible(True)


def side_bar() -> dict[str, Any]:
    """How a colour bar stands beside its image."""
    return {"fraction": 0.035, "pad": 0.02, "aspect": 28}


def image_lattice(camera: Camera, columns: int = 180) -> tuple[Floats, Floats]:
    """Pixels u (w,), v (h,) over the image, its edges among them."""
    rows = max(2, round(columns * camera.height / camera.width))
    return np.linspace(-0.5, camera.width - 0.5, columns), np.linspace(-0.5, camera.height - 0.5, rows)


def shade_outside(axes: Axes, camera: Camera, valid: ValidRegion | None) -> Patch | None:
    """Hatches what lies outside the valid zeniths; its legend entry, None where nothing does."""
    if valid is None or valid.zenith is None:
        return None
    u, v = image_lattice(camera)
    grid = np.meshgrid(u, v)
    direction = camera.unproject(grid[0].ravel(), grid[1].ravel()).direction
    zenith = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2]).reshape(grid[0].shape)
    outside = ~ValidRegion(zenith=valid.zenith).holds(zenith, zenith)
    if not outside.any():
        return None
    drawn = axes.contourf(u, v, outside.astype(float), levels=[0.5, 1.5], colors=["none"], hatches=["////"])
    drawn.set_edgecolor(INK)
    drawn.set_linewidth(0.0)
    drawn.set_hatch_linewidth(0.4)
    return Patch(facecolor="white", edgecolor=INK, hatch="////", linewidth=0.4, hatch_linewidth=0.45, label=OUTSIDE)


def shade_radii(axes: Axes, valid: ValidRegion | None, scale: LengthUnit) -> None:
    """Greys the radii outside the valid region, within the limits that the axis has."""
    if valid is None or valid.radius is None:
        return
    low, high = axes.get_xlim()
    first, last = (radius / scale.metres for radius in valid.radius)
    beyond = [(start, end) for start, end in ((low, first), (last, high)) if end > start]
    for number, (start, end) in enumerate(beyond):
        axes.axvspan(start, end, color=SHADE, linewidth=0, zorder=0, label=OUTSIDE if number == 0 else None)
    axes.set_xlim(low, high)


def shown_radii(valid: ValidRegion | None, nominal_radius: float, n: int = 97) -> Floats:
    """(n,) [m]: the valid radii and a quarter of their span beyond; else round the nominal one."""
    if valid is None or valid.radius is None:
        return np.linspace(*REACH, n) * nominal_radius
    low, high = valid.radius
    beyond = MARGIN * (high - low)
    return np.linspace(max(low - beyond, 0.25 * low, LEAST * nominal_radius), high + beyond, n)


def log_axis(axis: Axis, values: Floats) -> None:
    """A logarithmic axis with numbers as people write them: 1, 2, 5, or more of them where `values` span little."""
    there = values[np.isfinite(values) & (values > 0)]
    ratio = there.max() / there.min() if there.size else 1.0
    steps = FINE if ratio < NARROW else COARSE if ratio < WIDE else (1.0,)
    axis.axes.set(**{"xscale" if axis is axis.axes.xaxis else "yscale": "log"})
    axis.set_major_locator(LogLocator(subs=steps))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def nominal_radius_of(calibration: Calibration, nominal_radius: float | None = None) -> float | None:
    """As given, else the middle of the valid radii; None where neither is known."""
    if nominal_radius is not None:
        return nominal_radius
    valid = calibration.valid
    return None if valid is None or valid.radius is None else float(np.mean(valid.radius))
