"""A photograph of a flat board: chessboard, ChArUco or dots, through any lens."""

from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.simulation._sensor import Sensor
from calibore.targets import Board, charuco_drawing

Array = NDArray[np.float64]

FINENESS = 3  # samples along each side of a pixel; edges are smoothed over one of them
QUIET = 1.0  # squares of white paper round the squares or dots
BLACK, WHITE, SURROUNDINGS = 0.05, 0.75, 0.3  # light of full scale
PRINTED = 96  # pixels along a square of the ChArUco board


def photograph_board(
    camera: Camera,
    camera_from_board: Pose,
    *,
    kind: str,
    corners: tuple[int, int],
    square: float,
    sensor: Sensor,
    rng: np.random.Generator,
    marker: float = 0.75,
    dictionary: str = "4x4_50",
    dot: float = 0.5,
    shading: float = 0.2,
) -> NDArray[np.uint8 | np.uint16]:
    """The picture (h, w) of a board, `square` [m] one square or pitch. Board frame: origin at the first mark, x along a
    row, y down the rows, z into the board. `shading` (0..1): by how much the light falls off towards one side.
    """
    board = Board(kind, corners, marker, dictionary, dot)
    x, y = _board_places(camera, camera_from_board, square)
    low, high = board.places.min(axis=0) - 1 - QUIET, board.places.max(axis=0) + 1 + QUIET
    with np.errstate(invalid="ignore"):
        on_board = (x > low[0]) & (x < high[0]) & (y > low[1]) & (y < high[1])
    light = np.full(x.shape, SURROUNDINGS)
    if on_board.any():
        light[on_board] = BLACK + (WHITE - BLACK) * _whiteness(board, x, y, on_board)
    light *= _illumination(x.shape, shading, rng)
    return sensor.read_out(_blurred(light, sensor.psf_sigma).astype(np.float32), rng)


def unknown_fisheye(width: int, height: int, *, rng: np.random.Generator, widest: float = 1.6) -> Camera:
    """A camera whose lens no law fits: r = k (zenith + p3 zenith^3 + ... + p11 zenith^11), its largest image radius
    within the picture seen at `widest` [rad] of zenith. Off-centre, pixels not quite square.
    """
    reach = 0.5 * np.hypot(width, height)
    at_widest = np.array([-0.14, 0.05, -0.04, 0.01, -0.02]) * rng.uniform(0.6, 1.2, 5)  # parts of r / k at the edge
    coefficients = at_widest / widest ** np.arange(2, 12, 2)
    scale = reach / (widest * (1 + at_widest.sum()))
    lens = Lens("polynomial", scale, height / 2, polynomial=tuple(coefficients.tolist()))
    centre = np.array([width - 1, height - 1]) / 2 + rng.uniform(-0.02, 0.02, 2) * height
    return Camera(width, height, lens, (float(centre[0]), float(centre[1])), float(rng.uniform(0.998, 1.002)))


@lru_cache(maxsize=2)
def _pixel_rays(camera: Camera) -> Array:
    v, u = np.mgrid[: camera.height, : camera.width].astype(float)
    rays = camera.unproject(u.ravel(), v.ravel())
    if np.abs(rays.origin).max(initial=0.0) > 0:
        raise InputError("A board is photographed with one entrance pupil; leave pupil walk and port away.")
    return rays.direction.reshape(camera.height, camera.width, 3)


def _board_places(camera: Camera, camera_from_board: Pose, square: float) -> tuple[Array, Array]:
    """Where (h, w) on the board each pixel looks, in squares; NaN where it looks elsewhere."""
    direction = _pixel_rays(camera) @ camera_from_board.rotation
    origin = camera_from_board.inverse().translation
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = -origin[2] / direction[..., 2]
        distance = np.where(distance > 0, distance, np.nan)
        return (origin[0] + distance * direction[..., 0]) / square, (origin[1] + distance * direction[..., 1]) / square


def _whiteness(board: Board, x: Array, y: Array, seen: NDArray[np.bool_]) -> Array:
    """Share of white (n,) of the pixels `seen`, from a second-order expansion of the place round each pixel."""
    expansions = [_expansion(part, seen) for part in (x, y)]
    pattern = charuco_drawing(board, pixels=PRINTED) if board.kind == "charuco" else None
    offsets = (np.arange(FINENESS) - (FINENESS - 1) / 2) / FINENESS
    total = np.zeros(int(seen.sum()))
    for du, dv in product(offsets, offsets):
        place, slope = zip(*(_expanded(terms, du, dv) for terms in expansions), strict=True)
        if board.has_dots:
            total += _dots(board, place, slope)
        elif pattern is not None:
            total += _drawn(board, pattern, place)
        else:
            total += _chessboard(board, place, slope)
    return total / FINENESS**2


def _expansion(place: Array, seen: NDArray[np.bool_]) -> list[Array]:
    """Place (n,), its first (u, v) and second (uu, uv, vv) derivatives by the pixel."""
    by_u, by_v = _derivative(place, 1), _derivative(place, 0)
    second = [_derivative(by_u, 1), _derivative(by_u, 0), _derivative(by_v, 0)]
    return [place[seen], *(np.nan_to_num(part[seen]) for part in (by_u, by_v, *second))]


def _derivative(values: Array, axis: int) -> Array:
    return np.asarray(np.gradient(values, axis=axis))


def _expanded(terms: list[Array], du: float, dv: float) -> tuple[Array, Array]:
    """Place (n,) at an offset from the pixel's centre, and its gradient (2, n) by the pixel."""
    place, by_u, by_v, uu, uv, vv = terms
    slope = np.stack([by_u + uu * du + uv * dv, by_v + uv * du + vv * dv])
    return place + by_u * du + by_v * dv + 0.5 * (uu * du**2 + vv * dv**2) + uv * du * dv, slope


def _step(distance: Array, slope: Array) -> Array:
    """0 ... 1 across an edge `distance` [squares] away, smoothed over one sample of the pixel."""
    width = np.abs(slope).sum(axis=0) / FINENESS
    return np.clip(distance / np.maximum(width, 1e-12) + 0.5, 0.0, 1.0)


def _chessboard(board: Board, place: tuple[Array, ...], slope: tuple[Array, ...]) -> Array:
    """The square with its corner at the first mark, to the right and below, is white."""
    waves = []
    for value, gradient, count in zip(place, slope, board.corners, strict=True):
        line = np.clip(np.rint(value), 0, count - 1)
        waves.append((2 * _step(value - line, gradient) - 1) * np.where(line % 2 == 0, 1, -1))
    inside = np.ones(place[0].shape)
    for value, gradient, count in zip(place, slope, board.corners, strict=True):
        inside *= _step(value + 1, gradient) * _step(count - value, gradient)
    return 1 - inside * (1 - waves[0] * waves[1]) / 2


def _dots(board: Board, place: tuple[Array, ...], slope: tuple[Array, ...]) -> Array:
    x, y = place
    row = np.clip(np.rint(y), 0, board.corners[1] - 1)
    if board.kind.startswith("asym"):
        row = _asymmetric_row(x, y, board.corners[1])
        column = np.clip(2 * np.rint((x - row % 2) / 2) + row % 2, row % 2, 2 * (board.corners[0] - 1) + row % 2)
    else:
        column = np.clip(np.rint(x), 0, board.corners[0] - 1)
    across, down = x - column, y - row
    distance = np.hypot(across, down)
    outward = (across * slope[0] + down * slope[1]) / np.maximum(distance, 1e-9)
    return _step(distance - board.dot / 2, outward)


def _asymmetric_row(x: Array, y: Array, rows: int) -> Array:
    """The row (n,) of the nearest dot: of the two rows above and below."""
    candidates = np.clip(np.stack([np.floor(y), np.floor(y) + 1]), 0, rows - 1)
    across = x - (2 * np.rint((x - candidates % 2) / 2) + candidates % 2)
    nearest = np.argmin(across**2 + (y - candidates) ** 2, axis=0)
    return np.take_along_axis(candidates, nearest[None], axis=0)[0]


def _drawn(board: Board, drawing: NDArray[np.uint8], place: tuple[Array, ...]) -> Array:
    """Whiteness between the pixels of a drawing of the whole board."""
    height, width = drawing.shape
    column, row = (
        (value + 1) * size / (count + 1) - 0.5
        for value, size, count in zip(place, (width, height), board.corners, strict=True)
    )
    from scipy.ndimage import map_coordinates

    return map_coordinates(drawing / 255.0, [row, column], order=1, mode="constant", cval=1.0)


def _illumination(shape: tuple[int, ...], shading: float, rng: np.random.Generator) -> Array:
    """Light (h, w) falling off evenly towards a random side, 1 at the brightest."""
    height, width = shape
    v, u = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    turn = rng.uniform(0, 2 * np.pi)
    return 1 - shading * (1 + (np.cos(turn) * u + np.sin(turn) * v) / np.sqrt(2)) / 2


def _blurred(light: Array, sigma: float) -> Array:
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(light, sigma, mode="nearest", truncate=4.0)
