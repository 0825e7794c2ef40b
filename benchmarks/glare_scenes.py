"""Random pictures of the line with light that is not the line, and their truth: for `line_choice`.

The same seed gives every kind the same pipe, rig and pose, so that kinds can be compared.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.rigs import Rig
from calibore.simulation import (
    Finish,
    Ghost,
    Lamp,
    LineLight,
    Overlay,
    Patch,
    Sensor,
    Smudge,
    Specks,
    TrueRing,
    Water,
    Window,
    lit_line,
    photograph_all,
    random_pose,
    random_rig,
    random_wall,
    seen_through,
    true_ring,
)


@dataclass(frozen=True)
class Effects:
    """What a kind of scene adds; `spots`: specks of laser light brighter than the line; `grey`: no colours."""

    finish: Finish | None = None
    water: Water | None = None
    window: Window = field(default_factory=Window)
    lamps: tuple[Lamp, ...] = ()
    overlays: tuple[Overlay, ...] = ()
    shadows: tuple[tuple[float, float], ...] = ()
    spots: int = 0
    grey: bool = False


@dataclass(frozen=True)
class Scene:
    """One picture, the rig that took it (as its file says), what it shows, and the pipe's nominal radius [m]."""

    image: np.ndarray
    rig: Rig
    truth: TrueRing
    nominal_radius: float


Draw = Callable[[np.random.Generator, float], Effects]


def _water(lowest: float, highest: float, **more: Any) -> Draw:
    def draw(rng: np.random.Generator, radius: float) -> Effects:
        level = 2 * radius * rng.uniform(lowest, highest)
        return Effects(water=Water(level, rng.uniform(0.0005, 0.01), seed=int(rng.integers(2**31)), **more))

    return draw


def _ghost(rng: np.random.Generator, most: float) -> Ghost:
    scale = float(rng.choice([rng.uniform(0.75, 0.97), rng.uniform(1.03, 1.2)]))
    return Ghost(rng.uniform(0.05, most), scale, (rng.uniform(-12, 12), rng.uniform(-12, 12)))


def _smudge(rng: np.random.Generator) -> Smudge:
    return Smudge(rng.uniform(100, 300), rng.uniform(100, 300), rng.uniform(20, 60))


def _dirt(rng: np.random.Generator, radius: float) -> Effects:
    patches = tuple(
        Patch(rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5) * radius, rng.uniform(0.1, 0.4) * radius, 0.03)
        for _ in range(4)
    )
    specks = Specks(0.2 * radius, 0.05 * radius, seed=int(rng.integers(2**31)))
    texture = {"contrast": 0.3, "grain": 0.1 * radius, "seed": int(rng.integers(2**31))}
    return Effects(Finish(0.7, specular=0.3, stains=(*patches, specks), **texture))


def _lamp(rng: np.random.Generator, radius: float) -> Lamp:
    ahead, clock, width = rng.uniform(2.0, 5.0) * radius, rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 2.0)
    return Lamp(ahead, clock, width, rng.uniform(0.02, 0.2) * radius, rng.uniform(0.3, 2.0))


def _everything(rng: np.random.Generator, radius: float) -> Effects:
    wet = Water(2 * radius * rng.uniform(0.03, 0.12), 0.01, 3.0, int(rng.integers(2**31)))
    window = Window((_smudge(rng),), (_ghost(rng, 0.3),), 0.04)
    return replace(_dirt(rng, radius), water=wet, window=window, lamps=(_lamp(rng, radius),), spots=20)


TEXT = "MH 12 - MH 13  0.00 m"
KINDS: dict[str, Draw] = {
    "clean": lambda rng, radius: Effects(),
    "dirt": _dirt,
    "strut shadows": lambda rng, radius: Effects(
        shadows=tuple((clock, rng.uniform(0.1, 0.4)) for clock in rng.uniform(0, 6.28, 3))
    ),
    "one ghost": lambda rng, radius: Effects(window=Window(ghosts=(_ghost(rng, 0.5),))),
    "two ghosts": lambda rng, radius: Effects(window=Window(ghosts=(_ghost(rng, 0.5), _ghost(rng, 0.3)))),
    "ghost and shadows": lambda rng, radius: Effects(
        window=Window(ghosts=(_ghost(rng, 0.5),)),
        shadows=tuple((clock, rng.uniform(0.1, 0.5)) for clock in rng.uniform(0, 6.28, 3)),
    ),
    "halo and smudge": lambda rng, radius: Effects(window=Window((_smudge(rng),), halo=0.1)),
    "lamp, colour": lambda rng, radius: Effects(lamps=(_lamp(rng, radius),)),
    "lamp, grey": lambda rng, radius: Effects(lamps=(_lamp(rng, radius),), grey=True),
    "lamp and shadows, grey": lambda rng, radius: Effects(
        lamps=(_lamp(rng, radius),),
        grey=True,
        shadows=tuple((clock, rng.uniform(0.1, 0.5)) for clock in rng.uniform(0, 6.28, 3)),
    ),
    "text, grey": lambda rng, radius: Effects(
        overlays=tuple(Overlay(TEXT, rng.uniform(0, 250), v, 20.0) for v in rng.uniform(0, 360, 3)), grey=True
    ),
    "spatter": lambda rng, radius: Effects(spots=40),
    "water 3-15 %": _water(0.03, 0.15),
    "water 15-25 %": _water(0.15, 0.25),
    "water 25-35 %": _water(0.25, 0.35),
    "water 35-45 %": _water(0.35, 0.45),
    "glints": _water(0.03, 0.15, glints=4.0),
    "everything": _everything,
}


def scene(kind: str, seed: int, *, rig_kind: str = "perpendicular-plane") -> Scene:
    """A random picture of this kind; raises InputError where the rig would stand under the water."""
    rng = np.random.default_rng([17, seed])
    wall = random_wall(rng)
    rig = random_rig(rng, wall.nominal_radius, kind=rig_kind)
    pose = random_pose(rng, rig, wall.nominal_radius)
    line_sigma, contrast, blur = rng.uniform(0.002, 0.006), rng.uniform(0, 0.5), rng.uniform(0.8, 1.5)
    effects = KINDS[kind](np.random.default_rng([18, seed, list(KINDS).index(kind)]), wall.nominal_radius)
    wall = replace(wall, finish=effects.finish, water=effects.water)
    line = LineLight(sigma=wall.nominal_radius * line_sigma, shadows=effects.shadows)
    sensor = Sensor(speckle_contrast=contrast, psf_sigma=blur)
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=blur)
    lit = seen_through(lit, rig, wall, pipe_from_rig=pose, window=effects.window)
    lamps = [lamp.shine(rig, wall.nominal_radius, psf_sigma=blur) for lamp in effects.lamps]
    image = photograph_all(
        {0: lit}, rig, line=line, sensor=sensor, rng=rng, speckle_rng=rng, window=effects.window, lamps=lamps
    )
    for overlay in effects.overlays:
        overlay.write_on(image, station=0, axial=0.0)
    image = _spattered(image, effects.spots, rng)
    truth = true_ring(lit, rig, wall, pipe_from_rig=pose, line=line)
    return Scene(image[..., 0].copy() if effects.grey else image, rig, truth, wall.nominal_radius)


def _spattered(image: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """`image` (h, w, 3) with so many spots of red light, 2 to 10 px wide and white in their middle."""
    row, column = np.indices(image.shape[:2])
    light = np.zeros(image.shape[:2])
    for _ in range(count):
        place = rng.uniform(0, 1, 2) * image.shape[:2]
        light += 255 * np.exp(-((row - place[0]) ** 2 + (column - place[1]) ** 2) / (2 * rng.uniform(1, 3) ** 2))
    added = image + light[..., None] * np.array([1.0, 0.06, 0.035])
    return np.clip(np.rint(added), 0, 255).astype(image.dtype)


def scenes(kind: str, count: int, *, first: int = 0, **options: str) -> list[Scene]:
    """`count` scenes of a kind whose rig stands above the water, the seeds from `first` on."""
    found: list[Scene] = []
    for seed in range(first, first + 4 * count):
        try:
            found.append(scene(kind, seed, **options))
        except InputError:
            continue
        if len(found) == count:
            break
    return found
