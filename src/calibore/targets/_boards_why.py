"""Why no board was found in a picture, as far as the picture tells."""

import numpy as np
from numpy.typing import NDArray

from calibore.targets._boards import Board
from calibore.targets._boards_opencv import chessboard_part, rough_marks

Array = NDArray[np.float64]

MIRRORED = "the photograph is mirrored (left and right are swapped); give it as the camera took it."
NEAR_BORDER = 2.0  # squares
ENOUGH = 4  # corners of a ChArUco board that are no accident


def why_not_found(image: NDArray[np.uint8], board: Board) -> str:
    """One sentence, and what to do."""
    columns, rows = board.corners
    if board.kind == "charuco":
        return _why_no_charuco(image, board)
    part = chessboard_part(image) if board.kind == "chessboard" else None
    if part is None:
        return (
            f"no {board.kind} of {columns} x {rows} {board.mark} was found; it must lie wholly inside the picture, "
            "with its white border, sharp and not too oblique (or correct the counts)."
        )
    seen = f"a chessboard of {columns} x {rows} corners is seen in part only"
    if side := _border_near(part, image.shape):
        return (
            f"{seen}: it runs out of the picture at the {side}; show all of it and its white border (or correct the "
            f"counts: {part.shape[1]} x {part.shape[0]} are seen)."
        )
    return (
        f"{seen} ({part.shape[1]} x {part.shape[0]}); nothing may cover it, and it must be sharp, evenly lit and less "
        "oblique (or correct the counts)."
    )


def _why_no_charuco(image: NDArray[np.uint8], board: Board) -> str:
    other = rough_marks(np.ascontiguousarray(image[:, ::-1]), board)
    if other is not None and np.isfinite(other[:, 0]).sum() >= ENOUGH:
        return MIRRORED
    return (
        f"no marker of a ChArUco board of {board.corners[0] + 1} x {board.corners[1] + 1} squares (dictionary "
        f"{board.dictionary}) was found; photograph it sharp and evenly lit, or correct squares and dictionary."
    )


def _border_near(part: Array, shape: tuple[int, ...]) -> str:
    """The border of the picture less than a few squares from a part (r, c, 2) of a board, "" where none is."""
    square = float(np.median(np.linalg.norm(np.diff(part, axis=1), axis=2)))
    (left, top), (right, bottom) = part.min(axis=(0, 1)), part.max(axis=(0, 1))
    gaps = {"left": left, "top": top, "right": shape[1] - 1 - right, "bottom": shape[0] - 1 - bottom}
    nearest = min(gaps, key=lambda side: gaps[side])
    return nearest if gaps[nearest] < NEAR_BORDER * square else ""
