"""The sensor: optics' blur, speckle, shot and read noise, quantisation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

GREY_SCALE = 255  # of `background`, whatever the number of bits


@dataclass(frozen=True)
class Sensor:
    """`psf_sigma` [px]: blur of optics; `speckle_contrast` (0..1) and `speckle_grain` [px]; `take_decorrelation` (0..1)
    of the speckle between takes; `full_well` [electrons] at full scale; `read_noise` [electrons]; `background`: even
    grey of 255, in all colours; `bits` 8 or 16. The defaults are those of an ordinary industrial camera.
    """

    psf_sigma: float = 0.9
    speckle_contrast: float = 0.45
    speckle_grain: float = 1.8
    take_decorrelation: float = 0.3
    full_well: float = 12000.0
    read_noise: float = 18.0
    background: float = 4.0
    bits: int = 8

    def __post_init__(self) -> None:
        if not 0.4 <= self.psf_sigma < np.inf:
            raise InputError(
                f"psf_sigma must be at least 0.4 px, got {self.psf_sigma} px; below that pixels undersample the line."
            )
        if not (0 <= self.speckle_contrast <= 1 and 0 <= self.take_decorrelation <= 1):
            raise InputError("Speckle contrast and take decorrelation must be between 0 and 1.")
        if not (self.full_well > 0 and min(self.read_noise, self.background, self.speckle_grain) >= 0):
            raise InputError("full_well must be positive; read noise, background and grain must not be negative.")
        if self.bits not in (8, 16):
            raise InputError(f"A sensor gives 8 or 16 bits, got {self.bits}.")

    @classmethod
    def perfect(cls, *, bits: int = 16) -> "Sensor":
        """Without speckle and noise, on black; quantisation remains."""
        return cls(speckle_contrast=0.0, full_well=np.inf, read_noise=0.0, background=0.0, bits=bits)

    def read_out(self, light: NDArray[np.floating], rng: np.random.Generator) -> NDArray[np.uint8 | np.uint16]:
        """`light` (h, w, 3) as fractions of full scale -> pixels. Shot noise is normal: a well of a hundred electrons
        and more, which any background gives, cannot tell it from Poisson's.
        """
        light = light + np.float32(self.background / GREY_SCALE)
        if np.isfinite(self.full_well):
            variance = light / np.float32(self.full_well) + np.float32((self.read_noise / self.full_well) ** 2)
            light += np.sqrt(variance) * rng.standard_normal(light.shape, dtype=np.float32)
        white = 2**self.bits - 1
        return np.rint(np.clip(light, 0.0, 1.0) * white).astype(np.uint8 if self.bits == 8 else np.uint16)
