"""Marks that a known rig would make on known surfaces, with noise that neighbours share: calibrations by chance."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._references import AHEAD, FlatTarget, RingGauge
from calibore.rigs import Rig

Array = NDArray[np.float64]


def correlated(rng: np.random.Generator, n: int, *, neighbour: float) -> Array:
    """Normal noise (n,) of standard deviation 1 whose neighbours have the correlation `neighbour`."""
    white = rng.standard_normal(n)
    noise = np.empty(n)
    noise[0] = white[0]
    for i in range(1, n):
        noise[i] = neighbour * noise[i - 1] + np.sqrt(1 - neighbour**2) * white[i]
    return noise


def flat_looks(
    rig: Rig,
    ranges: Sequence[float],
    rng: np.random.Generator,
    *,
    u_range: float = 0.0,
    stated: bool = False,
    slope: float = 0.0,
    noise: float = 0.3,
    neighbour: float = 0.6,
    rows: int = 48,
    u_tilt: float = 0.01,
    wrong: dict[int, float] | None = None,
) -> list[Look]:
    """Looks of a side-facing head at a flat that stands `u_range` [m] by chance beside each of the `ranges`, and is off
    by what `wrong` says at some.
    """
    looks = []
    for number, place in enumerate(ranges):
        true = place + u_range * rng.standard_normal() + (wrong or {}).get(number, 0.0)
        z = np.linspace(-1.5, 1.5, 6000) * place
        sheet = rig.lasers[0].surface
        y = true + slope * z
        points = np.stack([sheet.offset + sheet.skew * y + sheet.lean * z, y, z], axis=1)
        u, v = rig.project(points)
        v_rows = np.linspace(20, rig.camera.height - 21, rows)
        order = np.argsort(v)
        marks = np.interp(v_rows, v[order], u[order]) + noise * correlated(rng, rows, neighbour=neighbour)
        reference = FlatTarget(
            float(place), u=u_range if stated else None, u_tilt=(0.0, u_tilt) if u_tilt else (0.0, 0.0)
        )
        across = np.tile([1.0, 0.0], (rows, 1))
        sigma = np.full(rows, noise)
        looks.append(Look(marks, v_rows, across, sigma, reference, f"{1e3 * place:.1f} mm", setting="target"))
    return looks


def gauge_look(
    rig: Rig,
    diameter: float,
    rng: np.random.Generator,
    *,
    name: str,
    centre: tuple[float, float] = (0.0, 0.0),
    slope: tuple[float, float] = (0.0, 0.0),
    u: float = 1e-6,
    u_tilt: float = 0.01,
    noise: float = 0.1,
    neighbour: float = 0.6,
    marks: int = 240,
    laser: int = 0,
    setting: str | None = None,
    stop: str | None = None,
    off: float = 0.0,
    at: float | None = None,
) -> Look:
    """The line in a gauge of `diameter` [m], truly larger by 2 `off`, whose axis passes through `centre` at the height
    of the light; by where generators of the gauge meet the light.
    """
    surface = rig.lasers[laser].surface
    axis = np.array([*slope, 1.0]) / np.sqrt(1 + slope[0] ** 2 + slope[1] ** 2)
    first = np.cross([0.0, 1.0, 0.0], axis)
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    turn = np.arange(marks) * (2 * np.pi / marks)
    round_ = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
    height = at if at is not None else _height(rig, diameter / 2, laser)
    feet = np.array([*centre, height]) - 20 * diameter * axis + (diameter / 2 + off) * round_
    meetings = surface.meet(feet, np.broadcast_to(axis, feet.shape))
    distance = np.where(meetings.admissible, meetings.distance, np.nan)
    ahead = np.nanmin(distance, axis=0)
    points = feet + ahead[:, None] * axis
    u_px, v_px = rig.project(points)
    return _noisy(
        rig,
        u_px,
        v_px,
        RingGauge(diameter, at=height, u=u, u_tilt=u_tilt),
        rng,
        name,
        noise,
        neighbour,
        laser,
        setting,
        stop,
    )


def flat_ahead_look(
    rig: Rig,
    stand_off: float,
    rng: np.random.Generator,
    *,
    name: str,
    slope: tuple[float, float] = (0.0, 0.0),
    u: float = 1e-5,
    u_tilt: float = 0.01,
    noise: float = 0.1,
    neighbour: float = 0.6,
    marks: int = 240,
    off: float = 0.0,
) -> Look:
    """The line of a cone on a flat at `stand_off` + `off` [m], by halving along rays from the cone's axis."""
    cone = rig.lasers[0].surface
    turn = np.arange(marks) * (2 * np.pi / marks)
    ways = np.stack([np.cos(turn), np.sin(turn), slope[0] * np.cos(turn) + slope[1] * np.sin(turn)], axis=1)
    true = stand_off + off
    along = (true - cone.apex[2] + slope @ cone.apex[:2]) / (cone.axis[2] - np.array(slope) @ cone.axis[:2])
    middle = cone.apex + along * cone.axis
    low, high = np.zeros(marks), np.full(marks, 10 * stand_off)
    inside = np.sign(cone.value(middle[None] + 1e-9))
    for _ in range(80):
        half = (low + high) / 2
        same = np.sign(cone.value(middle + half[:, None] * ways)) == inside
        low, high = np.where(same, half, low), np.where(same, high, half)
    u_px, v_px = rig.project(middle + low[:, None] * ways)
    return _noisy(
        rig, u_px, v_px, FlatTarget(stand_off, AHEAD, u, (u_tilt, u_tilt)), rng, name, noise, neighbour, 0, None, None
    )


def _height(rig: Rig, radius: float, laser: int) -> float:
    surface = rig.lasers[laser].surface
    turn = np.arange(36) * (2 * np.pi / 36)
    feet = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.full(36, -20 * radius)], axis=1)
    meetings = surface.meet(feet, np.broadcast_to([0.0, 0.0, 1.0], feet.shape))
    distance = np.where(meetings.admissible, meetings.distance, np.nan)
    return float(np.mean(feet[:, 2] + np.nanmin(distance, axis=0)))


def _noisy(rig, u, v, reference, rng, name, noise, neighbour, laser, setting, stop) -> Look:
    middle = np.array([np.nanmean(u), np.nanmean(v)])
    direction = np.stack([u, v], axis=1) - middle
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    shift = noise * correlated(rng, u.size, neighbour=neighbour)
    seen = (u > 2) & (u < rig.camera.width - 3) & (v > 2) & (v < rig.camera.height - 3)
    place = np.stack([u, v], axis=1) + shift[:, None] * direction
    sigma = np.full(u.size, noise)
    return Look(place[seen, 0], place[seen, 1], direction[seen], sigma[seen], reference, name, laser, setting, stop)
