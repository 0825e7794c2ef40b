"""What OpenCV is asked for: rough places of a board's marks. Imported when a board is looked for, not before."""

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.targets._boards import Board

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

ENOUGH = 1.2e6  # pixels in which a board is looked for; its marks are then measured in the full picture
LEAST_SIDE = 3  # corners along a side of a part of a board


def opencv() -> ModuleType:
    try:
        import cv2
    except ImportError as error:
        raise InputError(
            'Boards are found by OpenCV, which is not installed; pip install "calibore[targets]".'
        ) from error
    return cv2


def rough_marks(image: Grey, board: Board) -> Array | None:
    """Places (n, 2) [px] of `board.places`, NaN where a mark was not seen; None: no board."""
    if board.kind == "charuco":
        return _charuco(image, board)
    reduction = min(1.0, np.sqrt(ENOUGH / image.size))
    for scale in dict.fromkeys((reduction, min(1.0, 2 * reduction))):
        found = (_dots if board.has_dots else _chessboard)(_resized(image, scale), board)
        if found is not None:
            return (found + 0.5) / scale - 0.5
    return None


def _resized(image: Grey, scale: float) -> Grey:
    if scale == 1:
        return image
    cv2 = opencv()
    return cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def _chessboard(image: Grey, board: Board) -> Array | None:
    cv2 = opencv()
    for flags in (cv2.CALIB_CB_ACCURACY, cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE):
        found, corners = cv2.findChessboardCornersSB(image, board.corners, flags=flags)
        if found:
            return np.asarray(corners, dtype=float).reshape(-1, 2)
    return None


def chessboard_part(image: Grey) -> Array | None:
    """Corners (rows, columns, 2) [px] of whatever part of a chessboard is seen; None where there is none."""
    cv2 = opencv()
    scale = min(1.0, np.sqrt(ENOUGH / image.size))
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners, meta = cv2.findChessboardCornersSBWithMeta(_resized(image, scale), (LEAST_SIDE, LEAST_SIDE), flags)
    if not found:
        return None
    return (np.asarray(corners, dtype=float).reshape(*np.shape(meta)[:2], 2) + 0.5) / scale - 0.5


def _dots(image: Grey, board: Board) -> Array | None:
    cv2 = opencv()
    flags = cv2.CALIB_CB_ASYMMETRIC_GRID if board.kind.startswith("asym") else cv2.CALIB_CB_SYMMETRIC_GRID
    detector = _blob_detector(image.size / 30)
    for more in (0, cv2.CALIB_CB_CLUSTERING):
        found, centres = cv2.findCirclesGrid(image, board.corners, flags=flags | more, blobDetector=detector)
        if found:
            return np.asarray(centres, dtype=float).reshape(-1, 2)
    return None


def _blob_detector(largest: float) -> Any:
    cv2 = opencv()
    parameters = cv2.SimpleBlobDetector_Params()
    parameters.minArea, parameters.maxArea = 12.0, largest
    parameters.minDistBetweenBlobs = 4.0
    parameters.minThreshold, parameters.maxThreshold, parameters.thresholdStep = 30.0, 200.0, 12.0
    parameters.filterByInertia = parameters.filterByConvexity = False
    return cv2.SimpleBlobDetector_create(parameters)


def opencv_board(board: Board) -> Any:
    """OpenCV's own ChArUco board."""
    aruco = opencv().aruco
    names = {name.removeprefix("DICT_").lower(): name for name in dir(aruco) if name.startswith("DICT_")}
    if board.dictionary.lower() not in names:
        raise InputError(f'Marker dictionary "{board.dictionary}" is not known; allowed: {", ".join(sorted(names))}.')
    dictionary = aruco.getPredefinedDictionary(getattr(aruco, names[board.dictionary.lower()]))
    columns, rows = board.corners[0] + 1, board.corners[1] + 1
    markers = columns * rows // 2
    if markers > len(dictionary.bytesList):
        raise InputError(
            f'A board of {columns} x {rows} squares has {markers} markers, dictionary "{board.dictionary}" only '
            f"{len(dictionary.bytesList)}; correct squares or dictionary."
        )
    return aruco.CharucoBoard((columns, rows), 1.0, board.marker, dictionary)


def charuco_drawing(board: Board, *, pixels: int) -> Grey:
    """The board to print, `pixels` along each square."""
    return opencv_board(board).generateImage(((board.corners[0] + 1) * pixels, (board.corners[1] + 1) * pixels))


def _charuco(image: Grey, board: Board) -> Array | None:
    detector = opencv().aruco.CharucoDetector(opencv_board(board))
    corners, ids, _, _ = detector.detectBoard(image)
    if ids is None or len(ids) == 0:
        return None
    marks = np.full((len(board.places), 2), np.nan)
    marks[np.asarray(ids).ravel()] = np.asarray(corners, dtype=float).reshape(-1, 2)
    return marks
