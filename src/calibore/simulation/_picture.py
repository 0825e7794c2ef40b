"""From the lit line to the picture: every point becomes a blurred image point, all of them add up."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.geometry import Pose
from calibore.rigs import Rig
from calibore.simulation._light import PIXEL_VARIANCE, LineLight, LitLine, Stray, lit_line
from calibore.simulation._sensor import Sensor
from calibore.simulation._speckle import speckle_field
from calibore.simulation._stray import seen_through
from calibore.simulation._wall import PipeWall
from calibore.simulation._window import CLEAR, Window

Array = NDArray[np.float64]

CUT = 4.5  # standard deviations at which an image point ends: 4e-5 of its peak
WIDEST = 32  # px, half size of the largest image point
SIZES = 4  # px, image points are drawn in groups of such half sizes
LINE, SENSOR = LineLight(), Sensor()
CHANNEL_INDEX = {"red": 0, "green": 1, "blue": 2}


def render_ring(
    rig: Rig,
    wall: PipeWall,
    *,
    pipe_from_rig: Pose,
    rng: np.random.Generator,
    line: LineLight = LINE,
    sensor: Sensor = SENSOR,
    speckle_rng: np.random.Generator | None = None,
    laser: int = 0,
    window: Window = CLEAR,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w, 3) of the line that `laser` draws on `wall`, rig at `pipe_from_rig`, through its `window`.

    `rng` draws noise and the speckle of this take alone; `speckle_rng`, seeded alike for every take at one station,
    the speckle they share. Light reaches the camera once reflected by the wall, and perhaps by water or window.
    """
    lit = lit_line(rig, wall, pipe_from_rig=pipe_from_rig, line=line, psf_sigma=sensor.psf_sigma, laser=laser)
    lit = seen_through(lit, rig, wall, pipe_from_rig=pipe_from_rig, window=window, laser=laser)
    return photograph(lit, rig, line=line, sensor=sensor, rng=rng, speckle_rng=speckle_rng, laser=laser, window=window)


def photograph(
    lit: LitLine,
    rig: Rig,
    *,
    line: LineLight,
    sensor: Sensor,
    rng: np.random.Generator,
    speckle_rng: np.random.Generator | None = None,
    laser: int = 0,
    window: Window = CLEAR,
) -> NDArray[np.uint8 | np.uint16]:
    """One take (h, w, 3) of a lit line, see `render_ring`."""
    return photograph_all({laser: lit}, rig, line=line, sensor=sensor, rng=rng, speckle_rng=speckle_rng, window=window)


def photograph_all(
    lines: Mapping[int, LitLine],
    rig: Rig,
    *,
    line: LineLight,
    sensor: Sensor,
    rng: np.random.Generator,
    speckle_rng: np.random.Generator | None = None,
    window: Window = CLEAR,
    lamps: Sequence[Stray] = (),
) -> NDArray[np.uint8 | np.uint16]:
    """One take (h, w, 3) with several lasers lit at once: their `lines` by number of the laser, none in the dark, and
    the white light of `lamps`; `window` adds its halo.
    """
    shape = rig.camera.height, rig.camera.width
    picture = np.zeros((*shape, 3), dtype=np.float32)
    for laser, lit in lines.items():
        light = np.zeros(shape, dtype=np.float32)
        for part in (*lit.imaged, *lit.stray):
            light += line_image(part, shape, psf_sigma=sensor.psf_sigma)
        box = _lit_box(light)
        light[box] *= speckle_field(
            light[box].shape,
            contrast=sensor.speckle_contrast,
            grain=sensor.speckle_grain,
            rng=rng,
            shared=speckle_rng,
            decorrelation=sensor.take_decorrelation,
        )
        colour = np.roll(line.colour, CHANNEL_INDEX.get(rig.lasers[laser].channel or "red", 0)).astype(np.float32)
        picture += window.scattered(light)[..., None] * colour
    for lamp in lamps:
        picture += window.scattered(line_image(lamp, shape, psf_sigma=sensor.psf_sigma))[..., None]
    return sensor.read_out(picture, rng)


def line_image(lit: LitLine | Stray, shape: tuple[int, int], *, psf_sigma: float) -> NDArray[np.float32]:
    """The line's light (h, w) as fractions of full scale: thickness, blur and pixel area, without any noise.

    Each point is a Gaussian whose covariance adds the blur, the laser's thickness along its image direction, and the
    pixel's area (its variance of 1/12 px^2: symmetric, so that it moves no line). Points add up: line ends, shadows
    and folds need no rule of their own.
    """
    lit_points = np.flatnonzero(lit.energy > 0)
    blur = psf_sigma**2 + PIXEL_VARIANCE
    width = np.sqrt(blur + np.sum(lit.spread[lit_points] ** 2, axis=1))
    half = np.minimum(SIZES * np.ceil(CUT * width / SIZES), WIDEST).astype(int)
    padded = np.zeros((shape[0] + 2 * WIDEST + 2, shape[1] + 2 * WIDEST + 2))
    for size in np.unique(half):
        _add_points(padded, lit, lit_points[half == size], blur, int(size))
    inner = slice(WIDEST + 1, WIDEST + 1 + shape[0]), slice(WIDEST + 1, WIDEST + 1 + shape[1])
    return padded[inner].astype(np.float32)


def _add_points(image: Array, lit: LitLine | Stray, index: NDArray[np.intp], blur: float, half: int) -> None:
    """Add the points `index` of the line to the padded image, each on (2 half + 1)^2 pixels."""
    u, v, (a, b) = lit.u[index], lit.v[index], lit.spread[index].T
    column, row = np.rint(u).astype(np.intp), np.rint(v).astype(np.intp)
    reach = np.arange(-half, half + 1)
    x, y = (reach + (column - u)[:, None]).astype(np.float32), (reach + (row - v)[:, None]).astype(np.float32)
    determinant = blur * (blur + a * a + b * b)
    xx, xy, yy = (-0.5 * (blur + b * b) / determinant, a * b / determinant, -0.5 * (blur + a * a) / determinant)
    single = [factor.astype(np.float32) for factor in (xx, xy, yy)]
    exponent = (single[2][:, None] * y * y)[:, :, None] + (single[0][:, None] * x * x)[:, None, :]
    exponent += (single[1][:, None] * y)[:, :, None] * x[:, None, :]
    value = np.exp(exponent, out=exponent)
    value *= (lit.energy[index] / (2 * np.pi * np.sqrt(determinant))).astype(np.float32)[:, None, None]
    corner = (row + WIDEST + 1) * image.shape[1] + column + WIDEST + 1
    pixel = corner[:, None, None] + (reach[:, None] * image.shape[1] + reach)
    image += np.bincount(pixel.ravel(), value.ravel(), minlength=image.size).reshape(image.shape)


def _lit_box(light: NDArray[np.floating]) -> tuple[slice, slice]:
    """Rows and columns that hold all of the light."""
    rows, columns = np.flatnonzero(light.any(axis=1)), np.flatnonzero(light.any(axis=0))
    if rows.size == 0:
        return slice(0, 1), slice(0, 1)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)
