"""Boards held before simulated cameras: poses, marks with noise, and what target.toml says of them."""

from pathlib import Path

import numpy as np

from calibore.calibration._boards._bundle import Estimate
from calibore.calibration._boards._data import BoardData
from calibore.calibration._boards._pictures import BoardPictures, BoardTargetFile
from calibore.calibration._boards._start import poses_from_rays
from calibore.calibration._input_files import InputFile
from calibore.calibration._lens_models import LensModel
from calibore.optics import LENS_LAWS, Camera, Lens
from calibore.simulation import held_boards as held
from calibore.targets import Board, BoardMarks

SQUARE = 0.024
CORNERS = (7, 5)
SIZE = (640, 480)
WIDEST = {"perspective": 55.0, "sine-law": 75.0}


def places(corners=CORNERS, square=SQUARE, kind="chessboard", bends=(0.0, 0.0, 0.0)):
    """Places (n, 3) [m] of all marks from the first one, risen by `bends` [m] as of `BoardData`."""
    flat = Board(kind, corners).places * square
    x, y = ((flat - (flat.max(axis=0) + flat.min(axis=0)) / 2) / (np.ptp(flat, axis=0) / 2)).T
    return np.column_stack([flat, np.stack([x * x, y * y, x * y], axis=1) @ np.array(bends)])


def law_camera(rng, law, *, size=SIZE, widest=None):
    """A camera of `law`, the corner of its picture at a random zenith [deg], a little off-centre."""
    widest = widest or rng.uniform(35, WIDEST.get(law, 100.0))
    reach = np.hypot(*size) / 2
    k = reach / float(LENS_LAWS[law].ratio(np.array(np.radians(widest))))
    if law in ("sine-law", "equisolid-angle"):
        k = max(k, 1.03 * reach)
    centre = tuple(float(side / 2 + rng.uniform(-0.02, 0.02) * side) for side in size)
    return Camera(*size, Lens(law, k, size[1] / 2), centre, float(rng.uniform(0.998, 1.002)))


def held_boards(camera, rng, count, *, corners=CORNERS, square=SQUARE, kind="chessboard", tilt=40.0, margin=12.0):
    """Poses `camera_from_board` of boards wholly in the picture, facing the camera but for `tilt` [deg]."""
    tilt = np.radians(tilt)
    return held(camera, Board(kind, corners), square=square, count=count, rng=rng, tilt=tilt, margin=margin)


def marks_of(camera, poses, rng, *, noise=0.05, corners=CORNERS, square=SQUARE, bends=(0.0, 0.0, 0.0)):
    """What would be found of the boards, each coordinate off by `noise` [px]."""
    points, (x, y) = places(corners, square, bends=bends), Board("chessboard", corners).places.T
    marks = []
    for pose in poses:
        u, v = (part + noise * rng.standard_normal(part.size) for part in camera.project(pose.apply(points)))
        marks.append(BoardMarks(u, v, x, y, noise, 0.9))
    return marks


def data_of(marks, **said):
    return BoardData.of(marks, square=SQUARE, size=SIZE, **said)


def truth_of(camera, data):
    """The true camera as an estimate; poses from the rays, which are exact without noise."""
    values = np.array([camera.lens.k, camera.aspect, *camera.principal_point])
    return Estimate(LensModel(camera.lens.law), values, poses_from_rays(data, camera), 0 * data.pixel, SIZE)


def pictures_of(marks, *, corners=CORNERS, square=SQUARE, size=SIZE, **said):
    """As if `marks` had been found in pictures beside a target.toml that also says `said`."""
    said = {"flatness": "0 mm"} | said
    table = {
        "format": "calibore-target/1",
        "kind": "chessboard",
        "images": "*.png",
        "square": f"{square} m",
        "corners": corners,
    }
    target = BoardTargetFile.model_validate(table | said)
    files = tuple(InputFile(f"board {number}.png", "") for number in range(len(marks)))
    return BoardPictures(Path("target.toml"), target, tuple(marks), tuple(range(len(marks))), files, size)
