"""The lit line: which wall points the laser reaches and the camera sees, where they are imaged, and how bright."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import Pose, clock_of
from calibore.rigs import Rig
from calibore.simulation._fan import Fan
from calibore.simulation._parts import turned
from calibore.simulation._sight import sees, wall_normal
from calibore.simulation._wall import PipeWall

Array = NDArray[np.float64]

COARSE = 1024  # rays of the fan from which the line's length in the image is found
SPACING = 0.5  # px between neighbouring points of the line: well below the width of any image point
MARGIN = 40.0  # px round the image beyond which nobody sees how dense the line's points are
STEEPEST = 1e-3  # sine of the angle between light and wall below which a line grows no wider
FEWEST_LEAVES, MOST_LEAVES = 7, 33  # fewer would lie further apart than they are thick
LEAVES_REACH = 2.5  # standard deviations of the light from its middle to the outermost leaf
PIXEL_VARIANCE = 1 / 12  # px^2, of one pixel's area in any direction


@dataclass(frozen=True)
class LineLight:
    """A fan of laser light. `sigma` [m]: standard deviation of its thickness. `brightness`: peak of the line's image on
    the nominal wall as a fraction of full scale. `colour`: response of red, green and blue, for a laser of the red
    channel. `shadows`: (clock, width) [rad] in the rig frame, where struts of the carriage cut the fan. `leaves`: thin
    sheets of which the fan is made; with one, the wall is taken to be the same over the thickness of the light, with
    nine, edges and dirt narrower than the line change its profile.
    """

    sigma: float = 0.000635  # 1/e^2 half width 0.05 in, as the dissertation's lasers
    brightness: float = 0.6
    colour: tuple[float, float, float] = (1.0, 0.06, 0.035)
    shadows: tuple[tuple[float, float], ...] = ()
    leaves: int = 1

    def __post_init__(self) -> None:
        if self.leaves != 1 and not FEWEST_LEAVES <= self.leaves <= MOST_LEAVES:
            raise InputError(
                f"The light of a laser has 1 leaf, or {FEWEST_LEAVES} to {MOST_LEAVES} of them, got {self.leaves}."
            )
        for name in ("sigma", "brightness"):
            if not 0 <= getattr(self, name) < np.inf:
                raise InputError(f"{name} of a laser line must not be negative, got {getattr(self, name)}.")

    def lights(self, clock: Array) -> NDArray[np.bool_]:
        """Whether no strut stands at rig `clock` (n,) [rad]."""
        lit = np.ones(clock.shape, dtype=bool)
        for centre, width in self.shadows:
            lit &= np.abs(turned(clock, centre)) > width / 2
        return lit

    def leaf_by_leaf(self) -> "tuple[tuple[float, LineLight], ...]":
        """Distance [m] of every leaf from the middle of the fan, and its light; together they are Gaussian again."""
        spacing = LEAVES_REACH * 2 * self.sigma / (self.leaves - 1)
        offset = (np.arange(self.leaves) - (self.leaves - 1) / 2) * spacing
        share = np.exp(-(offset**2) / (2 * (self.sigma**2 - spacing**2)))
        share /= share.sum()
        single = replace(self, leaves=1, sigma=spacing)
        return tuple(
            (float(d), replace(single, brightness=self.brightness * float(s)))
            for d, s in zip(offset, share, strict=True)
        )


@dataclass(frozen=True, eq=False)
class LitLine:
    """Points of the wall, in order of the `angle` (n,) [rad] of the fan that lights them; `closed`: the last is next to
    the first. `points` (n, 3) [m] of the rig frame; `u`, `v` (n,) [px]; `spread` (n, 2) [px]: image of one standard
    deviation of the laser's thickness; `visible`: lit, seen and inside the image; `energy` (n,): light of each point as
    full scales x px^2; `signal` (n,): expected peak of the line as a fraction of full scale, 0 where not visible;
    `stray`: the laser's light that reaches the picture elsewhere; `leaves`: the light of each leaf, where the fan has
    several; they are imaged in place of the whole.
    """

    angle: Array
    points: Array
    u: Array
    v: Array
    spread: Array
    visible: NDArray[np.bool_]
    energy: Array
    signal: Array
    closed: bool = True
    stray: "tuple[Stray, ...]" = ()
    leaves: "tuple[Stray, ...]" = ()

    @property
    def imaged(self) -> "tuple[LitLine | Stray, ...]":
        """What is drawn in the picture for it."""
        return self.leaves or (self,)

    @property
    def clock(self) -> Array:
        """Rig clock (n,) [rad]."""
        return clock_of(self.points[:, 0], self.points[:, 1])

    @property
    def radius(self) -> Array:
        """Distance from the rig axis (n,) [m]."""
        return np.hypot(self.points[:, 0], self.points[:, 1])


@dataclass(frozen=True, eq=False)
class Stray:
    """Light in the picture where no lit wall is: points at `u`, `v` (n,) [px] with `spread` and `energy` as above."""

    u: Array
    v: Array
    spread: Array
    energy: Array


def lit_line(
    rig: Rig, wall: PipeWall, *, pipe_from_rig: Pose, line: LineLight, psf_sigma: float, laser: int = 0
) -> LitLine:
    """The line that `laser` draws on `wall`, as the rig's camera sees it through optics of `psf_sigma` [px]: the first
    wall that each ray of its light meets. For a side-facing head `pipe_from_rig` is the pose of the head.
    """
    unit = _traced(rig, PipeWall(wall.nominal_radius), Pose.identity(), LineLight(line.sigma, 1.0), psf_sigma, laser)
    if not unit.visible.any():
        raise InputError("The camera sees nothing of a nominal wall lit by this laser; correct lens, baseline or k.")
    unit_gain = 1 / float(np.median(unit.signal[unit.visible]))
    gain = line.brightness * unit_gain
    lit = _traced(rig, wall, pipe_from_rig, line, psf_sigma, laser, gain=gain)
    if line.leaves == 1:
        return lit
    leaves = (
        _traced(rig, wall, pipe_from_rig, leaf, psf_sigma, laser, gain=unit_gain * leaf.brightness, offset=offset)
        for offset, leaf in line.leaf_by_leaf()
    )
    return replace(lit, leaves=tuple(Stray(leaf.u, leaf.v, leaf.spread, leaf.energy) for leaf in leaves))


def _traced(
    rig: Rig,
    wall: PipeWall,
    pose: Pose,
    line: LineLight,
    psf_sigma: float,
    laser: int,
    *,
    gain: float = 1.0,
    offset: float = 0.0,
) -> LitLine:
    fan = Fan.of(rig, pose, laser=laser, offset=offset)
    angle = _evenly_imaged(rig, wall, fan)
    turn = _steps(angle, 2 * np.pi).mean(axis=0) if fan.closed else np.gradient(angle)
    pipe_points = fan.first_wall(wall, angle)
    met = np.isfinite(pipe_points[:, 0])
    angle, turn, pipe_points = angle[met], turn[met], pipe_points[met]
    normal = wall_normal(wall, pipe_points, clock_of(pipe_points[:, 0], pipe_points[:, 1]))
    points = fan.rig_from_pipe.apply(pipe_points)
    u, v = rig.project(points)
    spread = _spread(rig, fan, pipe_points, _thickness(fan.normal(pipe_points), normal) * line.sigma)
    candidates = inside_image(u, v, rig) & line.lights(clock_of(points[:, 0], points[:, 1])) & wall.dry(pipe_points)
    pupil = pose.apply(rig.mount.translation)
    visible = candidates.copy()
    visible[candidates] = sees(wall, pipe_points[candidates], pupil, normal=normal[candidates])
    energy = np.where(visible, gain * turn * lambert(pipe_points, normal, pupil), 0.0)
    if wall.finish is not None:
        energy *= wall.finish.returned(pipe_points, normal, fan.source, pupil, nominal_radius=wall.nominal_radius)
    signal = energy / area_per_point(u, v, spread, psf_sigma)
    return LitLine(angle, points, u, v, spread, visible, energy, np.where(visible, signal, 0.0), fan.closed)


def _evenly_imaged(rig: Rig, wall: PipeWall, fan: Fan) -> Array:
    """Angles (n,) of the fan whose points are at most about `SPACING` apart in the image."""
    angle = np.linspace(*fan.limits, COARSE + 1)
    u, v = rig.project(fan.rig_from_pipe.apply(fan.first_wall(wall, angle)))
    near = inside_image(u, v, rig, margin=MARGIN)
    step = np.where(near[1:] & near[:-1], np.hypot(np.diff(u), np.diff(v)), 0.0)
    length = np.concatenate([[0.0], np.cumsum(step + 0.1 * step.mean() + 1e-3)])
    count = int(np.ceil(length[-1] / SPACING))
    return np.interp(np.arange(count) * (length[-1] / count), length, angle)


def _steps(values: Array, period: float) -> Array:
    """From each of `values` (n, ...) to the next, and to each from the one before: (2, n, ...), round the whole."""
    after = np.roll(values, -1, axis=0) - values
    after[-1] += period
    return np.stack([after, np.roll(after, 1, axis=0)])


def _thickness(light: Array, wall: Array) -> Array:
    """How far (n, 3) the line's edge lies on the wall per metre of the light's thickness, from the unit normals (n, 3)
    of laser surface and wall: across the line, and far where the light grazes the wall.
    """
    across = light - np.einsum("ij,ij->i", light, wall)[:, None] * wall
    square = np.einsum("ij,ij->i", across, across)
    return across / np.maximum(square, STEEPEST**2)[:, None]


def _spread(rig: Rig, fan: Fan, points: Array, shift: Array) -> Array:
    """Image (n, 2) [px] of the displacement `shift` (n, 3) [m] of wall points, pipe frame."""
    ahead = rig.project(fan.rig_from_pipe.apply(points + shift))
    behind = rig.project(fan.rig_from_pipe.apply(points - shift))
    return 0.5 * np.stack([ahead[0] - behind[0], ahead[1] - behind[1]], axis=1)


def inside_image(u: Array, v: Array, rig: Rig, *, margin: float = 0.0) -> NDArray[np.bool_]:
    """Which pixels (n,) lie on the sensor, or within `margin` [px] of it; NaN does not."""
    edge = 0.5 + margin
    return (u > -edge) & (u < rig.camera.width - 1 + edge) & (v > -edge) & (v < rig.camera.height - 1 + edge)


def lambert(points: Array, normal: Array, pupil: Array) -> Array:
    """Light (n,) that a matt wall (Lambert) returns to the pupil, of light that falls on it, up to a constant."""
    way = pupil - points
    square = np.einsum("ij,ij->i", way, way)
    return np.maximum(np.einsum("ij,ij->i", way, normal), 0.0) / square**1.5


def area_per_point(u: Array, v: Array, spread: Array, psf_sigma: float) -> Array:
    """Light of a point over the peak of its line (n,) [px^2]: spacing x sqrt(2 pi) x line width. Where the line breaks
    off, the nearer neighbour tells the spacing.
    """
    steps = _steps(np.stack([u, v], axis=1), 0.0)
    after, before = np.nan_to_num(np.linalg.norm(steps, axis=2), nan=np.inf)[:, :, None]
    run = np.where(after > 2 * before, steps[1], np.where(before > 2 * after, steps[0], steps.mean(axis=0)))
    spacing = np.maximum(np.linalg.norm(run, axis=1), 1e-9)
    across = (spread[:, 0] * run[:, 1] - spread[:, 1] * run[:, 0]) / spacing
    return spacing * np.sqrt(2 * np.pi * (across**2 + psf_sigma**2 + PIXEL_VARIANCE))
