"""A flat board in one picture: its marks to sub-pixel, or why there are none."""

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.targets._boards import DICTIONARY, Board
from calibore.targets._boards_corners import Corners, measured_corners
from calibore.targets._boards_dots import Dots, measured_dots
from calibore.targets._boards_lattice import lattice_of
from calibore.targets._boards_opencv import rough_marks
from calibore.targets._boards_why import MIRRORED, why_not_found
from calibore.targets._marks import BoardMarks

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8 | np.uint16]

FEWEST = 8  # marks of a board partly seen
ENOUGH = 0.6  # of the marks of a board that must be seen as a whole
WIDTHS = 2.0  # blurs from a marker's edge within which it still shows


def find_board(
    image: Pixels,
    *,
    kind: str,
    corners: tuple[int, int],
    marker: float = 0.75,
    dictionary: str = DICTIONARY,
    dot: float = 0.5,
) -> BoardMarks:
    """The marks of a board in `image` (h, w) or (h, w, 3); arguments as of `Board`. Of a ChArUco board, a part will do.

    Raises ImageError: one sentence on why no board was found and what to do, without naming the picture.
    """
    board = Board(kind, corners, marker, dictionary, dot)
    grey = _grey(image)
    eight_bits = _eight_bits(grey)
    rough = rough_marks(eight_bits, board)
    if rough is None:
        raise ImageError(why_not_found(eight_bits, board))
    rough = _seen_from_the_front(rough, board)
    found = _measured(grey, rough, board)
    good = np.isfinite(found.places[:, 0])
    fewest = FEWEST if kind == "charuco" else max(FEWEST, round(ENOUGH * len(rough)))
    if good.sum() < fewest or not _spread_out(board.places[good]):
        raise ImageError(
            f"only {good.sum()} of the board's {len(rough)} {board.mark} can be measured; photograph it nearer and "
            "sharp, wholly inside the picture, less oblique."
        )
    (u, v), (x, y) = found.places[good].T, board.places[good].T
    sigma = found.sigma[good]
    diameter = float(np.nanmedian(found.diameter[good])) if isinstance(found, Dots) else 0.0
    return BoardMarks(
        u, v, x, y, float(np.median(sigma)), float(np.median(found.blur[good])), sigmas=sigma, dot=diameter
    )


def _grey(image: Pixels) -> Array:
    grey = image.astype(float)
    return grey.mean(axis=2) if grey.ndim == 3 else grey


def _eight_bits(grey: Array) -> NDArray[np.uint8]:
    """Stretched so that the brightest thousandth is white: dark 16-bit pictures show their board too."""
    white = max(float(np.percentile(grey[::4, ::4], 99.9)), 1.0)
    return np.clip(grey * (255 / white), 0, 255).astype(np.uint8)


def _measured(grey: Array, rough: Array, board: Board) -> Corners | Dots:
    """Corners twice: how edges bend, and how far from markers to stay, is only known from a first measurement."""
    if board.has_dots:
        return measured_dots(grey, rough, board)
    clear = (1 - board.marker) / 2 if board.kind == "charuco" else np.inf
    first = measured_corners(grey, rough, lattice_of(rough, board), clear=clear, shun=WIDTHS)
    found = np.isfinite(first.places[:, 0])
    if not found.any():
        return first
    better = np.where(found[:, None], first.places, rough)
    shun = WIDTHS * float(np.median(first.blur[found]))
    return measured_corners(grey, better, lattice_of(better, board), clear=clear, shun=shun)


def _seen_from_the_front(rough: Array, board: Board) -> Array:
    """Marks numbered so that the board faces the camera. Rows of a chessboard may be read from either side: it looks
    the same in a mirror. Where it does not, the picture is mirrored.
    """
    if not _mirrored(rough, board):
        return rough
    grid = rough.reshape(board.corners[1], board.corners[0], 2)
    if board.kind in ("chessboard", "circle-grid"):
        return grid[:, ::-1].reshape(-1, 2)
    if board.kind.startswith("asym") and board.corners[1] % 2 == 1:
        return grid[::-1].reshape(-1, 2)
    raise ImageError(MIRRORED)


def _mirrored(rough: Array, board: Board) -> bool:
    seen = np.isfinite(rough[:, 0])
    if seen.sum() < FEWEST:
        return False
    places = board.places[seen]
    steps, *_ = np.linalg.lstsq(np.column_stack([places, np.ones(len(places))]), rough[seen], rcond=None)
    return bool(np.linalg.det(steps[:2]) < 0)


def _spread_out(places: Array) -> bool:
    """Marks on one line only say nothing of a plane."""
    return bool(np.linalg.matrix_rank(places - places.mean(axis=0), tol=1e-6) == 2)
