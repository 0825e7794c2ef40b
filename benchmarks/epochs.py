"""Two epochs of one pipe, as a rig that is a little wrong measures them; without pictures, for studies over many.

What pictures would do is put in where they do it: the true rig, a draw from what its file states, images the wall; line
positions get noise of the size and correlation that profiled pictures have; the stated rig triangulates.
"""

import sys
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from calibore.geometry import clock_of, xy_of
from calibore.registration import Motion
from calibore.rigs import Rig, project_ring, triangulate
from calibore.scans import Profile
from calibore.simulation import demo_rig, draw_rig
from calibore.uncertainty import propagate

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from registration_walls import Wall, random_motion, random_wall

RADIUS = 0.15
POSITIONS = 400
STATIONS = np.arange(16) * 0.006
"""m"""
U_LINE = 0.155
"""px; of line positions in simulated pictures of this rig: 0.11 mm to 0.13 mm in radius."""
NEIGHBOURS = np.array([1.0, 0.35, 0.13])
"""Weights of what neighbouring rasters share: correlations of 0.35 and 0.11, as profiles of such pictures state."""
MISSING = 0.02
BUMPS = 4


class Patch(NamedTuple):
    """Where the wall wears by a Gaussian bell: `axial` [m], `clock` [rad], its standard width [m] both ways."""

    axial: float
    clock: float
    width: float

    def worn(self, wall: Wall, depth: float) -> Wall:
        """`wall` that is `depth` [m] deeper there."""
        bump = [self.axial, self.clock, -depth, self.width, self.width / wall.radius]
        return replace(wall, bumps=np.concatenate([wall.bumps, [bump]]))

    def holds(self, axial: np.ndarray, clock: np.ndarray) -> np.ndarray:
        """Which places lie within a width of its middle."""
        aside = np.mod(clock - self.clock + np.pi, 2 * np.pi) - np.pi
        return np.hypot(axial - self.axial, RADIUS * aside) <= self.width


class Epochs:
    """A random pipe with two surveys of it, number `seed`: recalibrated, placed anew, measured in new light."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        rng = np.random.default_rng([31, seed])
        self.wall = random_wall(rng, radius=RADIUS, length=float(STATIONS[-1]), bumps=BUMPS)
        self.stated = demo_rig()
        self.rigs = [draw_rig(self.stated, rng) for _ in range(2)]
        self.motion = random_motion(rng, station=0.006, stations=0.5, roll=0.03, shift=0.01)

    @cached_property
    def before(self) -> Profile:
        return self._measured(self.wall, 0, Motion())

    @cached_property
    def unchanged(self) -> Profile:
        return self._measured(self.wall, 1, self.motion)

    def after(self, patch: Patch, depth: float) -> Profile:
        """The second survey had the wall worn: light, rig and place are those of `unchanged`."""
        return self._measured(patch.worn(self.wall, depth), 1, self.motion)

    def patch(self, width: float) -> Patch:
        """Somewhere in the middle half of the survey."""
        rng = np.random.default_rng([32, self.seed])
        return Patch(STATIONS[-1] * rng.uniform(0.25, 0.75), rng.uniform(0, 2 * np.pi), width)

    def _measured(self, wall: Wall, epoch: int, motion: Motion) -> Profile:
        rng = np.random.default_rng([33, self.seed, epoch])
        return measured(wall, self.stated, self.rigs[epoch], motion, rng)


def measured(wall: Wall, stated: Rig, true: Rig, motion: Motion, rng: np.random.Generator) -> Profile:
    """The profile that `stated` makes of what `true` images; `motion` leads from the survey's frame into the pipe's."""
    u, v = _imaged(wall, true, motion)
    outwards = np.stack([u - u.mean(), v - v.mean()], axis=-1)
    outwards /= np.linalg.norm(outwards, axis=-1, keepdims=True)
    white = rng.standard_normal(u.shape)
    shared = sum(share * np.roll(white, lag, axis=1) for lag, share in enumerate(NEIGHBOURS.tolist()))
    noise = U_LINE * shared / np.linalg.norm(NEIGHBOURS)
    at = (np.stack([u, v], axis=-1) + noise[..., None] * outwards).reshape(-1, 2)
    found = triangulate(stated, *at.T)
    by = found.radius_sensitivities
    modes = propagate(by.parameters, stated.covariance, names=found.parameter_names).modes.reshape(-1, *u.shape)
    u_radius = U_LINE * np.abs(np.sum(by.pixel * outwards.reshape(-1, 2), axis=1)).reshape(u.shape)
    clock = np.arange(POSITIONS) * 2 * np.pi / POSITIONS
    columns = (found.radius, found.axial)
    radius, ahead = (_on_grid(clock, found.clock.reshape(u.shape), one.reshape(u.shape)) for one in columns)
    missing = rng.random(u.shape) < MISSING
    return Profile(
        STATIONS,
        clock,
        np.where(missing, np.nan, radius),
        np.where(missing, np.nan, ahead - stated.lasers[0].surface.baseline + STATIONS[:, None]),
        u_radius,
        modes,
        np.tile(_correlation(), (STATIONS.size, 1)),
        np.where(missing, 3, 0).astype(np.uint8),
        "simulated",
        RADIUS,
    )


def _imaged(wall: Wall, true: Rig, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Pixels u, v (n, m) of the true line at every station."""
    clock = np.arange(POSITIONS) * 2 * np.pi / POSITIONS
    z, c = np.meshgrid(STATIONS, clock, indexing="ij")
    radius = np.full(z.shape, RADIUS)
    for _ in range(25):
        x, y = xy_of(c, radius)
        place = motion.apply(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1))
        off = wall(place[:, 2], clock_of(place[:, 0], place[:, 1])) - np.hypot(place[:, 0], place[:, 1])
        radius = radius + off.reshape(z.shape)
    rings = [project_ring(true, ring, POSITIONS)[1:] for ring in radius]
    u, v = np.array(rings).transpose(1, 0, 2)
    return u, v


def _on_grid(clock: np.ndarray, found: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(n, m) `values` at `clock` (m,), along the wall's slope from where they were `found`, less than a step away."""
    aside = np.mod(clock - found + np.pi, 2 * np.pi) - np.pi
    slope = (np.roll(values, -5, 1) - np.roll(values, 5, 1)) / (10 * (clock[1] - clock[0]))
    return values + slope * aside


def _correlation() -> np.ndarray:
    total = np.correlate(NEIGHBOURS, NEIGHBOURS, "full")[NEIGHBOURS.size - 1 :]
    return total[1:] / total[0]
