"""The window and lens that the camera looks through: dirt on them, ghosts between them, the lens's halo."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.simulation._light import LitLine, Stray
from calibore.simulation._parts import require_positive, smooth_step

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Smudge:
    """Dirt on the window at (`u`, `v`) of the picture, `radius` [px], so near to the lens that it fades from its middle
    on: there it lets through `transmission` of the light.
    """

    u: float
    v: float
    radius: float
    transmission: float = 0.1

    def __post_init__(self) -> None:
        require_positive(radius_of_a_smudge=self.radius)
        if not 0 <= self.transmission <= 1:
            raise InputError(f"A smudge lets through 0 to 1 of the light, got a transmission of {self.transmission:g}.")

    def passes(self, u: Array, v: Array) -> Array:
        """Share (n,) of the light that passes on its way to the pixels `u`, `v` (n,)."""
        distance = np.hypot(np.nan_to_num(u) - self.u, np.nan_to_num(v) - self.v)
        return 1 - (1 - self.transmission) * smooth_step(1.5 * (1 - distance / self.radius))


@dataclass(frozen=True)
class Ghost:
    """The picture again, with `strength` of its light, as the window reflects it back into the lens: `scale` times as
    large about the principal point (negative: upside down), displaced by `shift` [px].
    """

    strength: float
    scale: float = 1.0
    shift: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not 0 <= self.strength <= 1 or not 0.01 <= abs(self.scale) < 100:
            raise InputError(
                f"A ghost has 0 to 1 of the light and a scale between 0.01 and 100, got {self.strength:g} and "
                f"{self.scale:g}."
            )

    def of(self, light: LitLine | Stray, centre: tuple[float, float]) -> Stray:
        """The ghost of `light` in a picture whose principal point is `centre`."""
        u, v = (
            middle + shift + self.scale * (place - middle)
            for place, middle, shift in zip((light.u, light.v), centre, self.shift, strict=True)
        )
        return Stray(u, v, self.scale * light.spread, self.strength * light.energy)


@dataclass(frozen=True)
class Window:
    """`smudges` on it, `ghosts` in it; the lens scatters a share `halo` of all light over `halo_sigma` [px]."""

    smudges: tuple[Smudge, ...] = ()
    ghosts: tuple[Ghost, ...] = ()
    halo: float = 0.0
    halo_sigma: float = 9.0

    def __post_init__(self) -> None:
        require_positive(halo_sigma=self.halo_sigma)
        if not 0 <= self.halo < 1:
            raise InputError(f"A lens scatters 0 to 1 of the light, got a halo of {self.halo:g}.")

    def passes(self, u: Array, v: Array) -> Array:
        """Share (n,) of the light that passes the smudges on its way to the pixels `u`, `v` (n,)."""
        share = np.ones(u.shape)
        for smudge in self.smudges:
            share *= smudge.passes(u, v)
        return share

    def scattered(self, light: NDArray[np.float32]) -> NDArray[Any]:
        """`light` (h, w) with its halo; none is lost but over the edges of the picture."""
        if not self.halo:
            return light
        from scipy.ndimage import gaussian_filter

        around: Any = gaussian_filter(
            light, self.halo_sigma, mode="constant", truncate=4.0
        )  # single precision, as light
        return (1 - self.halo) * light + self.halo * around


CLEAR = Window()
