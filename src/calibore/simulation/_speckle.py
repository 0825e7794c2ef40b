"""Speckle: a random field of unit mean that multiplies the light."""

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

FARTHEST = 6.0  # standard deviations covered by the table of quantiles
TABLE = 4096


def speckle_field(
    shape: tuple[int, int],
    *,
    contrast: float,
    grain: float,
    rng: np.random.Generator,
    shared: np.random.Generator | None = None,
    decorrelation: float = 1.0,
) -> NDArray[np.float32]:
    """Speckle (h, w): unit mean, standard deviation `contrast` (1: fully developed, exponential; less: gamma
    distributed, as the sum of 1 / contrast^2 independent patterns).

    `grain` [px]: distance at which the field's correlation has fallen to 1/e. `shared` draws what this picture has in
    common with others of the same wall; `decorrelation` is one minus their correlation.
    """
    if not 0 <= contrast <= 1:
        raise InputError(f"Speckle contrast must be between 0 and 1, got {contrast}; 1 is fully developed speckle.")
    if contrast == 0:
        return np.ones(shape, dtype=np.float32)
    noise = _correlated(shape, grain, rng)
    if shared is not None:
        common = _correlated(shape, grain, shared)
        noise = np.sqrt(decorrelation) * noise + np.sqrt(1 - decorrelation) * common
    place = (noise + FARTHEST) * (TABLE / (2 * FARTHEST))
    return np.interp(place, np.arange(TABLE + 1), _quantiles(contrast)).astype(np.float32)


def _correlated(shape: tuple[int, int], grain: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Standard normal noise (h, w) with the correlation exp(-(distance / grain)^2)."""
    import scipy.fft

    fft: Any = scipy.fft  # single precision, unlike numpy.fft; its functions are typed as dispatchers
    padded: tuple[int, int] = fft.next_fast_len(shape[0], real=True), fft.next_fast_len(shape[1], real=True)
    white = fft.rfft2(rng.standard_normal(padded, dtype=np.float32))
    return fft.irfft2(white * _amplitude(padded, grain), s=padded)[: shape[0], : shape[1]]


@lru_cache(maxsize=8)
def _amplitude(shape: tuple[int, int], grain: float) -> NDArray[np.float32]:
    """Spectral amplitude of that correlation on a torus, exact at pixel distances; it is a product of rows, columns."""
    factors = []
    for n in shape:
        distance = np.minimum(np.arange(n), n - np.arange(n))
        power = np.fft.fft(np.exp(-((distance / max(grain, 1e-6)) ** 2))).real
        factors.append(np.sqrt(np.maximum(power, 0.0)))
    rows, columns = factors
    return np.outer(rows, columns[: shape[1] // 2 + 1]).astype(np.float32)


@lru_cache(maxsize=16)
def _quantiles(contrast: float) -> NDArray[np.float64]:
    """The gamma variable of unit mean that corresponds to each standard normal value of the table."""
    from scipy.special import gammaincinv, ndtr

    patterns = 1 / contrast**2
    return gammaincinv(patterns, ndtr(np.linspace(-FARTHEST, FARTHEST, TABLE + 1))) / patterns
