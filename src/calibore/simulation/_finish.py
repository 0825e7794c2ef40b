"""The finish of a wall: how much of the light it returns, where, and towards whom."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.geometry import clock_of
from calibore.simulation._parts import Roughness
from calibore.simulation._soiling import BRIGHTEST, Stain, require_reflectance

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Finish:
    """`reflectance` of the wall in units of the nominal wall's, with a random texture of relative standard deviation
    `contrast` and `grain` [m]; `stains` lie on it, one after the other. `specular`: share of the light that is
    returned about the mirror direction, the narrower the higher its `gloss` (exponent); wet plastic: 0.3 and 50.
    """

    reflectance: float = 1.0
    contrast: float = 0.0
    grain: float = 0.02
    seed: int = 0
    specular: float = 0.0
    gloss: float = 50.0
    stains: tuple[Stain, ...] = ()

    def __post_init__(self) -> None:
        require_reflectance(self.reflectance, of="a wall")
        if not (0 <= self.contrast <= 1 and self.grain > 0):
            raise InputError(
                f"The texture of a wall needs a contrast between 0 and 1 and a grain above 0, got {self.contrast:g} "
                f"and {self.grain:g} m."
            )
        if not (0 <= self.specular <= 1 and 1 <= self.gloss <= 1e5):
            raise InputError(
                f"A sheen needs a specular share between 0 and 1 and a gloss from 1 to 1e5, got {self.specular:g} and "
                f"{self.gloss:g}."
            )

    def matt(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        """Reflectance (n,) of diffuse light at `axial` [m] and `clock` [rad] (n,) of the pipe."""
        share = np.full(axial.shape, self.reflectance)
        if self.contrast:
            share = self._texture.reshaped(np.ones(axial.shape), axial, clock, nominal_radius) * share
        for stain in self.stains:
            cover = stain.cover(axial, clock, nominal_radius)
            share = share + (stain.reflectance - share) * cover
        return np.clip(share, 0.0, BRIGHTEST)

    def returned(self, points: Array, normal: Array, source: Array, eye: Array, *, nominal_radius: float) -> Array:
        """What the wall returns to `eye` of the light from `source`, (3,) [m] each, as a multiple (n,) of what the
        nominal matt wall would: `points`, unit `normal` (n, 3), all in the pipe frame. The sheen is that of Blinn
        and Phong; of light that falls on the wall upright it returns its share in all, at any gloss.
        """
        clock = clock_of(points[:, 0], points[:, 1])
        share = self.matt(points[:, 2], clock, nominal_radius)
        if self.specular:
            halfway = _unit(_unit(source - points) + _unit(eye - points))
            upright = np.maximum(np.einsum("ij,ij->i", halfway, normal), 0.0)
            whole = 8 * (self.gloss + 2 ** (-self.gloss / 2)) / ((self.gloss + 2) * (self.gloss + 4))
            lobe = upright**self.gloss / whole
            share = share + self.specular * self._clean(points[:, 2], clock, nominal_radius) * lobe
        return share

    def _clean(self, axial: Array, clock: Array, nominal_radius: float) -> Array:
        """How much (n,) of the wall no stain covers."""
        clean = np.ones(axial.shape)
        for stain in self.stains:
            clean *= 1 - stain.cover(axial, clock, nominal_radius)
        return clean

    @cached_property
    def _texture(self) -> Roughness:
        return Roughness(self.contrast, self.grain, self.seed)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
