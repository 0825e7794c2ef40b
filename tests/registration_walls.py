"""Pipes and what two instruments see of them: for the tests of registration and comparison."""

from dataclasses import dataclass

import numpy as np

from calibore.geometry import clock_of, xy_of
from calibore.registration import Motion
from calibore.scans import Profile


@dataclass(frozen=True)
class Wall:
    """R(axial, clock) [m] of a pipe of `radius` [m]: harmonics (k, 3) of order, amplitude [m], phase [rad]; bumps (b,
    5) of axial [m], clock [rad], height [m] inwards, widths [m] along and [rad] round; `cone`: slope along the pipe.
    """

    radius: float
    harmonics: np.ndarray
    bumps: np.ndarray
    cone: float = 0.0

    def __call__(self, axial, clock):
        wall = self.radius + self.cone * axial
        for order, amplitude, phase in self.harmonics:
            wall = wall + amplitude * np.cos(order * (clock - phase))
        for at, where, height, along, round_ in self.bumps:
            aside = np.mod(clock - where + np.pi, 2 * np.pi) - np.pi
            wall = wall - height * np.exp(-0.5 * ((axial - at) / along) ** 2 - 0.5 * (aside / round_) ** 2)
        return wall


def random_wall(rng, *, radius=0.15, length=0.25, bumps=6, ovality=2e-3):
    orders = np.array([2.0, 3.0, 5.0])
    harmonics = np.stack([orders, radius * ovality * rng.normal(0, [1, 0.4, 0.2]), rng.uniform(0, 6.28, 3)], axis=1)
    features = [
        rng.uniform(0, length, bumps),
        rng.uniform(0, 2 * np.pi, bumps),
        radius * rng.uniform(0.01, 0.06, bumps),
        radius * rng.uniform(0.06, 0.2, bumps),
        rng.uniform(0.06, 0.25, bumps),
    ]
    return Wall(radius, harmonics, np.stack(features, axis=1))


STILL = Motion()


def seen(wall, axial, rng, *, motion=STILL, positions=400, u=5e-5, modes=(), missing=0.02, truth=False):
    """The profile of `wall` at stations `axial` (n,) [m], by an instrument from whose frame `motion` leads into the
    pipe's; noise of `u` [m]; `modes`: relative radius error of each common cause, one standard deviation.
    """
    axial = np.asarray(axial, dtype=float)
    clock = np.arange(positions) * 2 * np.pi / positions
    z, c = np.meshgrid(axial, clock, indexing="ij")
    radius = np.full(z.shape, wall.radius)
    for _ in range(60):
        x, y = xy_of(c, radius)
        place = motion.apply(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1))
        off = wall(place[:, 2], clock_of(place[:, 0], place[:, 1])) - np.hypot(place[:, 0], place[:, 1])
        radius = radius + off.reshape(radius.shape) * 0.8
    common = np.array([np.full(radius.shape, wall.radius * size) for size in modes]).reshape(-1, *radius.shape)
    if not truth:
        radius = radius + rng.normal(0, u, radius.shape)
        radius = radius + np.tensordot(rng.normal(size=len(modes)), common, axes=1) if len(modes) else radius
        radius[rng.random(radius.shape) < missing] = np.nan
    return Profile(
        axial,
        clock,
        radius,
        np.where(np.isnan(radius), np.nan, z),
        np.full(radius.shape, u),
        common,
        np.zeros((axial.size, 3)),
        np.where(np.isnan(radius), 3, 0).astype(np.uint8),
        "simulated",
        wall.radius,
    )


def random_motion(rng, *, radius=0.15, station=0.005, roll=0.14, shift=0.04, stations=1.5, tilt=0.002):
    """Somewhere within what a registration must cope with."""
    return Motion(
        roll=rng.uniform(-roll, roll),
        shift_x=radius * rng.uniform(-shift, shift),
        shift_y=radius * rng.uniform(-shift, shift),
        axial=station * rng.uniform(-stations, stations),
        tilt_x=rng.normal(0, tilt),
        tilt_y=rng.normal(0, tilt),
    )
