"""Random rays and surfaces, and slopes by complex step, for the laws in this folder."""

from dataclasses import fields

import numpy as np

from calibore.lasers import Beam, Cone, Plane, Sheet

STEP = 1e-30


def rays(rng, n=4000):
    directions = rng.normal(size=(n, 3))
    return rng.normal(size=(n, 3)) * 0.3, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def cone(rng):
    """Forward or reversed, single or coaxial, at any clock, with its light all round the pipe."""
    slant = rng.uniform(np.radians(3), np.radians(87))
    aim = rng.uniform(-1, 1) * (np.pi / 2 - slant) * 0.99
    half_angle = slant if rng.random() < 0.6 else np.pi - slant
    baseline = rng.uniform(0.02, 1) if rng.random() < 0.8 else 0.0
    offset = rng.uniform(-0.5, 0.5) if baseline == 0 or rng.random() < 0.5 else 0.0
    return Cone(baseline, aim, half_angle, rng.uniform(0, 2 * np.pi), offset)


def plane(rng):
    return Plane(rng.uniform(0.1, 2), *rng.uniform(-0.5, 0.5, 2))


def sheet(rng):
    return Sheet(*rng.uniform(-0.5, 0.5, 3))


def beam(rng):
    return Beam(*rng.uniform(-1, 1, 3), rng.uniform(0.01, 3.1), rng.uniform(0, 2 * np.pi))


KINDS = {"plane": plane, "cone": cone, "sheet": sheet, "beam": beam}


def surfaces(kind, n=20, seed=1):
    rng = np.random.default_rng(seed)
    return [KINDS[kind](rng) for _ in range(n)]


def stepped(surface, name):
    """`surface` with the parameter `name` moved by an imaginary step, past the validation of real numbers."""
    other = object.__new__(type(surface))
    for field in fields(surface):
        object.__setattr__(other, field.name, getattr(surface, field.name) + 1j * STEP * (field.name == name))
    return other


def slopes(function):
    """(..., 3): of a function of a (3,) imaginary shift."""
    return np.stack([function(1j * STEP * axis).imag / STEP for axis in np.eye(3)], axis=-1)


def parameter_slopes(surface, function):
    """(..., q): of a function of the surface."""
    return np.stack([function(stepped(surface, name)).imag / STEP for name in surface.parameter_names], axis=-1)


def relative(found, expected):
    """The largest difference of rows, in lengths of the expected row."""
    size = np.linalg.norm(expected, axis=-1, keepdims=True)
    return (np.abs(found - expected) / np.where(size > 0, size, 1)).max()
