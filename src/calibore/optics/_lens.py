"""A lens: a law with its scale k and the radial residual r <- r (1 + c1 q^2 + c2 q^4)."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.errors import InputError
from calibore.optics._laws import LENS_LAWS, LENS_NAMES, LensLaw, polynomial_law
from calibore.optics._odd_polynomial import OddPolynomial

LARGEST = 1e9
"""px, or a coefficient; beyond any lens, and products are still numbers."""


@dataclass(frozen=True)
class Lens:
    """`law` by name, `k` [px] (px per radian for equidistant), `half_height` [px] of the image, which scales q.

    Image radius: r = k f(zenith), then r (1 + c1 q^2 + c2 q^4) with q = r / half_height. `polynomial` = (p3, p5, ...)
    of the law "polynomial".
    """

    law: str
    k: float
    half_height: float
    c1: float = 0.0
    c2: float = 0.0
    polynomial: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.law not in LENS_NAMES:
            raise InputError(f'Lens law "{self.law}" is not known; allowed: {", ".join(LENS_NAMES)}.')
        if (self.law == "polynomial") != bool(self.polynomial):
            raise InputError(
                'Coefficients "polynomial" = [p3, p5, ...] belong to the lens law "polynomial", and to it only.'
            )
        for name in ("k", "half_height"):
            if not 1 / LARGEST <= getattr(self, name) <= LARGEST:
                raise InputError(f"Lens {name} must be positive, got {getattr(self, name)} px; give it in pixels.")
        if not (np.abs([self.c1, self.c2, *self.polynomial]) <= LARGEST).all():
            raise InputError(
                "Lens c1, c2 and polynomial coefficients must be finite; leave them out for an ideal lens."
            )

    @property
    def parameter_names(self) -> tuple[str, ...]:
        return ("k", "c1", "c2", *(f"polynomial_{power}" for power in self._law.powers))

    @cached_property
    def _law(self) -> LensLaw:
        return polynomial_law(self.polynomial) if self.law == "polynomial" else LENS_LAWS[self.law]

    @cached_property
    def _residual(self) -> OddPolynomial | None:
        return OddPolynomial((self.c1, self.c2)) if self.c1 != 0 or self.c2 != 0 else None

    @cached_property
    def max_zenith(self) -> float:
        """The zenith [rad] up to which this lens images: the law's end or the turning point of its residual."""
        ratio = self._residual.limit * self.half_height / np.real(self.k) if self._residual else np.inf
        return (
            self._law.max_zenith if ratio >= self._law.max_ratio else float(np.real(self._law.zenith(np.array(ratio))))
        )

    def image_radius(self, zenith: ArrayLike) -> NDArray[Any]:
        """Image radius [px] of rays at `zenith` [rad], any shape; NaN outside [0, max_zenith)."""
        zenith = np.asarray(zenith)
        seen = (np.real(zenith) >= 0) & (np.real(zenith) < self.max_zenith)
        radius = self.k * self._law.ratio(np.where(seen, zenith, np.nan))
        return radius if self._residual is None else self._residual.value(radius / self.half_height) * self.half_height

    def zenith(self, image_radius: ArrayLike) -> NDArray[Any]:
        """Zenith [rad] of the ray that falls at `image_radius` [px], any shape; NaN where the lens images nothing."""
        return self._law.zenith(self._ratio(np.asarray(image_radius)))

    def zenith_with_sensitivities(
        self, image_radius: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any], list[NDArray[Any]]]:
        """Zenith, its derivative by the image radius, and by each of `parameter_names` at a fixed image radius."""
        ratio = self._ratio(image_radius)
        zenith = self._law.zenith(ratio)
        by_law_radius = 1 / (self.k * self._law.slope(ratio))
        square = (ratio * (self.k / self.half_height)) ** 2
        by_radius = (
            by_law_radius
            if self._residual is None
            else by_law_radius / (1 + (3 * self.c1 + 5 * self.c2 * square) * square)
        )
        by_k = -ratio * by_law_radius
        by_c1 = -ratio * self.k * square * by_radius
        by_powers = [-self.k * zenith**power * by_law_radius for power in self._law.powers]
        return zenith, by_radius, [by_k, by_c1, by_c1 * square, *by_powers]

    def _ratio(self, image_radius: NDArray[Any]) -> NDArray[Any]:
        """Ratio r / k of the pure law, after taking the residual away; NaN beyond the law's end."""
        if self._residual is not None:
            image_radius = self._residual.inverse(image_radius / self.half_height) * self.half_height
        ratio = image_radius / self.k
        return np.where(np.real(ratio) < self._law.max_ratio, ratio, np.nan)
