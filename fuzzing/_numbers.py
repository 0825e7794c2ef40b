"""Entries without files: arguments of the library's functions that nobody would give on purpose."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

Random = np.random.Generator
HOSTILE = (
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-320,
    1e-9,
    1e9,
    1e308,
    -1e308,
    np.inf,
    -np.inf,
    np.nan,
    2.0**20,
    2.0**31,
    -(2.0**63),
)
SHARE = 0.15
"""Of the numbers that are hostile."""


def number(rng: Random, low: float, high: float) -> float:
    """From a range, or a hostile one."""
    return float(HOSTILE[rng.integers(len(HOSTILE))] if rng.random() < SHARE else rng.uniform(low, high))


def numbers(rng: Random, count: int, low: float, high: float) -> np.ndarray:
    """(count,), a few of them hostile."""
    values = rng.uniform(low, high, count)
    bad = rng.random(count) < SHARE / 3
    values[bad] = rng.choice(HOSTILE, int(bad.sum()))
    return values


class Stripes:
    """`detect_ring` and `detect_line`, pictures and arguments of any kind."""

    def prepare(self, scratch: Path) -> None:
        """No files."""

    def attempt(self, rng: Random, scratch: Path) -> list[Callable[[], object]]:
        """One call of each."""
        from calibore.stripe import detect_line, detect_ring

        image = _picture(rng)
        how: dict[str, Any] = {
            "channel": str(rng.choice(["luma", "red", "green", "blue", "purple"])),
            "estimator": str(rng.choice(["zero-crossing", "parabola", "maximum", "centroid", "steger", "guess"])),
            "kernel": str(rng.choice(["native", "native", "scalar", "numpy"])),
        }
        centre = (number(rng, 0, 90), number(rng, 0, 90))
        rays = int(rng.choice([0, -1, 1, 15, 16, 17, 100, 360, 1500, 10**6]))
        sectors = [(number(rng, -9, 9), number(rng, -9, 9)) for _ in range(rng.integers(4))]
        where: dict[str, Any] = {"inner": number(rng, 0, 20), "outer": number(rng, 10, 80), "rays": rays}
        return [
            lambda: detect_ring(image, centre, sectors=sectors or None, **where, **how),
            lambda: detect_line(image, down=bool(rng.integers(2)), **how),
        ]


def _picture(rng: Random) -> np.ndarray:
    height, width = (int(rng.choice([0, 1, 2, 7, 8, 9, 33, 64, 90])) for _ in range(2))
    shape = (height, width, *([], [3], [1], [4])[rng.choice(4, p=(0.5, 0.4, 0.05, 0.05))])
    image = rng.integers(0, 40, shape)
    v, u = np.mgrid[:height, :width]
    place = np.hypot(u - width / 2, v - height / 2) - height / 3
    line = 180 * np.exp(-((place / rng.uniform(0.5, 5)) ** 2) / 2)
    image = image + (line if len(shape) == 2 else line[..., None])
    dtype = (np.uint8, np.uint16, np.float64, np.int16, np.bool_)[rng.choice(5, p=(0.5, 0.3, 0.1, 0.05, 0.05))]
    image = (image * (257 if dtype is np.uint16 else 1)).astype(dtype)
    return image if rng.random() < 0.7 else image[::-1] if rng.random() < 0.5 else np.asfortranarray(image)


class Meetings:
    """`measure`, `triangulate` and `monte_carlo` of random rigs at any pixels."""

    def prepare(self, scratch: Path) -> None:
        """No files."""

    def attempt(self, rng: Random, scratch: Path) -> list[Callable[[], object]]:
        """One call of each."""
        from calibore.rigs import measure, monte_carlo, triangulate
        from calibore.simulation import RIG_KINDS, random_rig

        rig = random_rig(rng, 0.15, kind=str(rng.choice(RIG_KINDS))).with_default_uncertainty(0.15)
        count = int(rng.choice([0, 1, 2, 9, 40]))
        u, v = numbers(rng, count, -100, 700), numbers(rng, count + (rng.random() < 0.02), -100, 700)
        noise, laser = number(rng, 0, 2), int(rng.choice([0, 0, 0, 1, -1, 7]))
        which = (
            {"prior_radius": number(rng, 0.1, 0.2)} if rng.random() < 0.7 else {"branch": rng.integers(-3, 4, count)}
        )
        kernel = str(rng.choice(["native", "numpy"]))
        draws, probability = int(rng.choice([-1, 0, 1, 2, 50])), number(rng, 0.5, 1)
        direction = numbers(rng, 2 * count, -1, 1).reshape(count, 2) if rng.random() < 0.3 else None
        how = {"u_pixel": noise, "direction": direction, "laser": laser, "kernel": kernel, **which}
        return [
            lambda: triangulate(rig, u, v, laser=laser, **which),
            lambda: measure(rig, u, v, **how),
            lambda: monte_carlo(rig, u, v, draws=draws, probability=probability, rng=rng, **how),
        ]
