"""Which kernel runs: the compiled one, or its NumPy twin where it was not built or is asked for."""

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from calibore.stripe._chain import link_numpy
from calibore.stripe._estimators import Peaks, ScanSettings
from calibore.stripe._rays import Rays
from calibore.stripe._scatter import Ratios, scatter_ratios
from calibore.stripe._twin import scan_numpy

try:
    from calibore import _native
except ImportError:  # a source tree that was never built: slower, same numbers
    _native = None

Array = NDArray[np.float64]
KERNELS = ("native", "numpy")
DEFAULT_KERNEL = "native" if _native is not None and hasattr(_native, "scan_rays") else "numpy"


def scan(image: NDArray[np.generic], rays: Rays, settings: ScanSettings, *, band: int, kernel: str) -> Peaks:
    """Candidates on every ray of colour `band` of `image` (h, w) or (h, w, 3), uint8 or uint16."""
    if kernel == "numpy" or _native is None:
        return scan_numpy(image if image.ndim == 2 else image[:, :, band], rays, settings)
    noise = settings.noise
    table = _native.scan_rays(
        np.ascontiguousarray(image),
        band,
        rays.start,
        rays.direction,
        rays.samples,
        int(settings.estimator),
        (settings.gate, settings.prominence, settings.threshold, settings.saturation),
        (settings.window, settings.reach, settings.half_fit),
        astuple(noise),
    )
    return Peaks(table[0], table[1], table[2], table[3], table[4], table[5] > 0)


def link(position: Array, *, spacing: float, closed: bool, kernel: str) -> NDArray[np.int64]:
    """Chain lengths of candidates; see `calibore.stripe._chain`."""
    if kernel == "numpy" or _native is None:
        return link_numpy(position, spacing=spacing, closed=closed)
    return _native.link_chains(position, spacing, closed)


def ratios_of(kernel: str) -> Ratios:
    """The scatter statistics by `kernel`; see `calibore.stripe._scatter`."""
    return scatter_ratios if kernel == "numpy" or _native is None else _native.scatter_ratios
