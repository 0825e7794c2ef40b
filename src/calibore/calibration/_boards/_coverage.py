"""Which part of the picture the marks cover, and what of the lens is only extrapolated."""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._boards._data import BoardData
from calibore.optics import Camera
from calibore.rigs import ValidRegion

Array = NDArray[np.float64]

MIDDLE = 0.25  # of the largest zenith: from there inwards every lens is smooth enough to be continued
BEYOND = 1.15  # times the largest zenith of a mark: what the picture sees without marks is told from here on
SIDES = ("right", "lower", "left", "upper")
LEAST_SHARE = 0.08  # of the marks on each side of the picture
SAMPLES = 60


def zenith_of_marks(data: BoardData, camera: Camera) -> Array:
    """Zeniths (n,) [rad]."""
    direction = camera.unproject(*data.pixel.T).direction
    return np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])


def valid_region(data: BoardData, camera: Camera) -> ValidRegion:
    """Zeniths between the marks; from the axis on where they come near it."""
    zenith = zenith_of_marks(data, camera)
    low, high = float(np.nanmin(zenith)), float(np.nanmax(zenith))
    return ValidRegion(zenith=(0.0 if low < MIDDLE * high else low, high))


def coverage_warnings(data: BoardData, camera: Camera, valid: ValidRegion) -> list[str]:
    """What the pictures leave open."""
    assert valid.zenith is not None
    low, high = np.degrees(valid.zenith)
    warnings = []
    widest = np.degrees(_widest(camera))
    if widest > BEYOND * high:
        warnings.append(
            f"boards cover zenith {low:.0f}-{high:.0f} deg, the picture sees to {widest:.0f} deg: beyond {high:.0f} "
            "deg the lens is only extrapolated; photograph the board in the corners of the picture."
        )
    if low > 0:
        warnings.append(
            f"no mark lies within {low:.0f} deg of the axis; photograph the board in the middle of the picture too."
        )
    turn = np.arctan2(data.pixel[:, 1] - camera.principal_point[1], data.pixel[:, 0] - camera.principal_point[0])
    side = np.rint(turn / (np.pi / 2)).astype(int) % 4
    empty = [name for number, name in enumerate(SIDES) if np.mean(side == number) < LEAST_SHARE]
    if empty:
        warnings.append(
            f"hardly any marks in the {' and '.join(empty)} part of the picture; photograph the board there."
        )
    return warnings


def _widest(camera: Camera) -> float:
    """Largest zenith [rad] that the picture's border sees, as far as the lens is known."""
    along, down = np.linspace(0, camera.width - 1, SAMPLES), np.linspace(0, camera.height - 1, SAMPLES)
    u = np.concatenate([along, along, np.zeros(SAMPLES), np.full(SAMPLES, camera.width - 1)])
    v = np.concatenate([np.zeros(SAMPLES), np.full(SAMPLES, camera.height - 1), down, down])
    direction = camera.unproject(u, v).direction
    zenith = np.arctan2(np.hypot(direction[:, 0], direction[:, 1]), direction[:, 2])
    return float(np.nanmax(zenith)) if np.isfinite(zenith).any() else float(camera.lens.max_zenith)
