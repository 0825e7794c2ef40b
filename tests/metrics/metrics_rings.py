"""Rings with known truth, for the tests of ring_quantities and for the table in docs/explanation/ovality-bias.md."""

from dataclasses import dataclass

import numpy as np

from calibore.geometry import clock_of, xy_of
from calibore.metrics import RingShape

NOMINAL = 0.15  # m
DENT_DEPTH, DENT_HALF_WIDTH = 0.075, np.radians(9)  # of the radius; the dent is 18 deg wide
RAIL_HEIGHT = 0.13
OVALITIES = ("ovality_f1216_max", "ovality_f1216_min", "ovality_range", "ovality_harmonic")


@dataclass(frozen=True)
class Pipe:
    """r(phi) / NOMINAL = 1 + amplitude cos 2 (phi - axis), with a dent or a rail at clock `place`."""

    amplitude: float = 0.0
    axis: float = 0.0
    dent: bool = False
    rail: bool = False
    place: float = 0.0
    rail_half_width: float = 0.14  # rad

    def radius(self, angle):
        away = np.abs(np.mod(angle - self.place + np.pi, 2 * np.pi) - np.pi)
        radius = 1 + self.amplitude * np.cos(2 * (angle - self.axis))
        if self.dent:
            radius = radius - np.where(
                away < DENT_HALF_WIDTH, DENT_DEPTH / 2 * (1 + np.cos(np.pi * away / DENT_HALF_WIDTH)), 0
            )
        return radius - RAIL_HEIGHT * (away < self.rail_half_width) if self.rail else radius

    def truth(self):
        angle = np.arange(20000) * 2 * np.pi / 20000
        radius = self.radius(angle)
        diameter = radius[:10000] + radius[10000:]
        mean, least, most = diameter.mean(), diameter.min(), diameter.max()
        return {
            "diameter_mean": mean * NOMINAL,
            "diameter_min": least * NOMINAL,
            "diameter_max": most * NOMINAL,
            "area": np.pi * np.mean(radius**2) * NOMINAL**2,
            "ovality_f1216_max": 100 * (most / mean - 1),
            "ovality_f1216_min": 100 * (1 - least / mean),
            "ovality_range": 100 * (most - least) / mean,
            "ovality_harmonic": 200 * abs(np.mean(radius * np.exp(2j * angle))) / radius.mean(),
        }


def seen_from_rig(pipe, clock, *, centre=(0.0, 0.0)):
    """Radii (n,) [NOMINAL] about the rig axis at `clock` (n,) of a pipe whose centre is at `centre` [NOMINAL]."""
    near, far = np.zeros(clock.size), np.full(clock.size, 3.0)
    for _ in range(50):
        middle = (near + far) / 2
        x, y = xy_of(clock, middle)
        inside = np.hypot(x - centre[0], y - centre[1]) < pipe.radius(clock_of(x - centre[0], y - centre[1]))
        near, far = np.where(inside, middle, near), np.where(inside, far, middle)
    return (near + far) / 2


def short_range_noise(rng, count, kind):
    """Unit noise (count,) and its autocorrelation: "white", or "correlated" over about five points either side."""
    white = rng.standard_normal(count)
    if kind == "white":
        return white, np.empty(0)
    kernel = np.exp(-0.5 * (np.arange(-4, 5) / 2.0) ** 2)
    kernel /= np.sqrt(np.sum(kernel**2))
    ringed = np.convolve(np.concatenate([white[-4:], white, white[:4]]), kernel, mode="valid")
    return ringed, np.array([kernel[lag:] @ kernel[:-lag] for lag in range(1, 9)])


def random_ring(rng, *, noise, kind="white", count=400, spread=0.0, offset=0.0, gap=0.0, dent=False, rail=False):
    """A ring and its truth: noise [NOMINAL], `spread` true (Dmax - Dmin) / Dmean of the ellipse [%]."""
    axis, place, towards = rng.uniform(0, 2 * np.pi, 3)
    pipe = Pipe(spread / 200, axis, dent, rail, place, rng.uniform(0.1, 0.2))
    clock = np.arange(count) * 2 * np.pi / count
    centre = tuple(float(c) for c in xy_of(towards, offset))
    unit_noise, correlation = short_range_noise(rng, count, kind)
    radius = (seen_from_rig(pipe, clock, centre=centre) + noise * unit_noise) * NOMINAL
    radius[(rng.integers(count) + np.arange(int(gap * count))) % count] = np.nan
    ring = RingShape(clock, radius, np.full(count, noise * NOMINAL), correlation=correlation)
    return ring, pipe.truth() | {"centre_x": centre[0] * NOMINAL, "centre_y": centre[1] * NOMINAL}
