"""The lit line: which wall points the laser reaches and the camera sees, where they are imaged, and how bright."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose, clock_of
from calibore.rigs import Rig
from calibore.simulation._parts import turned
from calibore.simulation._section import LaserPlane, sees, wall_frame
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

COARSE = 1024  # clock positions from which the line's length in the image is found
SPACING = 0.5  # px between neighbouring points of the line: well below the width of any image point
PIXEL_VARIANCE = 1 / 12  # px^2, of one pixel's area in any direction


@dataclass(frozen=True)
class LineLight:
    """A fan of laser light. `sigma` [m]: standard deviation of its thickness. `brightness`: peak of the line's image on
    the nominal wall as a fraction of full scale. `colour`: response of red, green and blue, for a laser of the red
    channel. `shadows`: (clock, width) [rad] in the rig frame, where struts of the carriage cut the fan.
    """

    sigma: float = 0.000635  # 1/e^2 half width 0.05 in, as the dissertation's lasers
    brightness: float = 0.6
    colour: tuple[float, float, float] = (1.0, 0.06, 0.035)
    shadows: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        for name in ("sigma", "brightness"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} of a laser line must not be negative, got {getattr(self, name)}.")

    def lights(self, clock: Array) -> NDArray[np.bool_]:
        """Whether no strut stands at rig `clock` (n,) [rad]."""
        lit = np.ones(clock.shape, dtype=bool)
        for centre, width in self.shadows:
            lit &= np.abs(turned(clock, centre)) > width / 2
        return lit


@dataclass(frozen=True, eq=False)
class LitLine:
    """n points round the pipe, closed. `pipe_clock` (n,) increasing [rad]; `points` (n, 3) [m] of the rig frame;
    `u`, `v` (n,) [px]; `spread` (n, 2) [px]: image of one standard deviation of the laser's thickness; `visible`: lit,
    seen and inside the image; `energy` (n,): light of each point as full scales x px^2; `signal` (n,): expected peak of
    the line as a fraction of full scale, 0 where not visible.
    """

    pipe_clock: Array
    points: Array
    u: Array
    v: Array
    spread: Array
    visible: NDArray[np.bool_]
    energy: Array
    signal: Array

    @property
    def clock(self) -> Array:
        """Rig clock (n,) [rad]."""
        return clock_of(self.points[:, 0], self.points[:, 1])

    @property
    def radius(self) -> Array:
        """Distance from the rig axis (n,) [m]."""
        return np.hypot(self.points[:, 0], self.points[:, 1])


def lit_line(
    rig: Rig, wall: PipeWall, *, pipe_from_rig: Pose, line: LineLight, psf_sigma: float, laser: int = 0
) -> LitLine:
    """The line that `laser` draws on `wall`, as the rig's camera sees it through optics of `psf_sigma` [px]."""
    unit = _traced(rig, PipeWall(wall.nominal_radius), Pose.identity(), LineLight(line.sigma, 1.0), psf_sigma, laser)
    exposure = np.median(unit.signal)
    if not exposure > 0:
        raise InputError("The camera sees nothing of a nominal wall lit by this laser; correct lens, baseline or k.")
    return _traced(rig, wall, pipe_from_rig, line, psf_sigma, laser, gain=line.brightness / exposure)


def _traced(
    rig: Rig, wall: PipeWall, pose: Pose, line: LineLight, psf_sigma: float, laser: int, *, gain: float = 1.0
) -> LitLine:
    plane = LaserPlane.of(rig, pose, laser=laser)
    clock = _evenly_imaged(rig, wall, pose, plane)
    pipe_points = plane.section(wall, clock)
    points = pose.inverse().apply(pipe_points)
    normal, along = wall_frame(wall, pipe_points, clock)
    u, v = rig.camera.project(points)
    spread = _spread(rig, pose, pipe_points, along / (along @ plane.normal)[:, None] * line.sigma)
    rig_clock = clock_of(points[:, 0], points[:, 1])
    turn = 0.5 * turned(np.roll(rig_clock, -1), np.roll(rig_clock, 1))
    candidates = inside_image(u, v, rig) & (turn > 0) & line.lights(rig_clock)
    visible = in_view(wall, plane, pose, pipe_points, normal, candidates)
    energy = np.where(visible, gain * turn * _returned(pipe_points, normal, pose.translation), 0.0)
    signal = energy / _area_per_point(u, v, spread, psf_sigma)
    return LitLine(clock, points, u, v, spread, visible, energy, np.where(visible, signal, 0.0))


def in_view(
    wall: PipeWall, plane: LaserPlane, pose: Pose, points: Array, normal: Array, candidates: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which `candidates` (n,) among the wall points (n, 3) both the laser's source and the camera's pupil see."""
    visible = candidates.copy()
    for eye in (plane.source, pose.translation):
        visible[visible] = sees(wall, points[visible], eye, normal=normal[visible])
    return visible


def _evenly_imaged(rig: Rig, wall: PipeWall, pose: Pose, plane: LaserPlane) -> Array:
    """Pipe clocks (n,) in [0, 2 pi) whose points are at most about `SPACING` apart in the image."""
    clock = np.linspace(0.0, 2 * np.pi, COARSE + 1)
    u, v = rig.camera.project(pose.inverse().apply(plane.section(wall, clock)))
    step = np.nan_to_num(np.hypot(np.diff(u), np.diff(v)))
    length = np.concatenate([[0.0], np.cumsum(step + 0.1 * step.mean() + 1e-3)])
    count = int(np.ceil(length[-1] / SPACING))
    return np.interp(np.arange(count) * (length[-1] / count), length, clock)


def _spread(rig: Rig, pose: Pose, points: Array, shift: Array) -> Array:
    """Image (n, 2) [px] of the displacement `shift` (n, 3) [m] of wall points, pipe frame."""
    rig_from_pipe = pose.inverse()
    ahead = rig.camera.project(rig_from_pipe.apply(points + shift))
    behind = rig.camera.project(rig_from_pipe.apply(points - shift))
    return 0.5 * np.stack([ahead[0] - behind[0], ahead[1] - behind[1]], axis=1)


def inside_image(u: Array, v: Array, rig: Rig) -> NDArray[np.bool_]:
    """Which pixels (n,) lie on the sensor; NaN does not."""
    return (u > -0.5) & (u < rig.camera.width - 0.5) & (v > -0.5) & (v < rig.camera.height - 0.5)


def _returned(points: Array, normal: Array, pupil: Array) -> Array:
    """Light (n,) that a matt wall (Lambert) returns to the pupil, of light that falls on it, up to a constant."""
    way = pupil - points
    square = np.einsum("ij,ij->i", way, way)
    return np.maximum(np.einsum("ij,ij->i", way, normal), 0.0) / square**1.5


def _area_per_point(u: Array, v: Array, spread: Array, psf_sigma: float) -> Array:
    """Light of a point over the peak of its line (n,) [px^2]: spacing x sqrt(2 pi) x line width."""
    run = 0.5 * np.stack([np.roll(u, -1) - np.roll(u, 1), np.roll(v, -1) - np.roll(v, 1)], axis=1)
    spacing = np.maximum(np.linalg.norm(run, axis=1), 1e-9)
    across = (spread[:, 0] * run[:, 1] - spread[:, 1] * run[:, 0]) / spacing
    return spacing * np.sqrt(2 * np.pi * (across**2 + psf_sigma**2 + PIXEL_VARIANCE))
