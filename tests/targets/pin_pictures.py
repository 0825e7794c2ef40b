"""Pictures of two pins with known axes, drawn with a blur and noise."""

import numpy as np
from scipy.special import ndtr

HEIGHT, WIDTH = 300, 400


def picture(
    rng, *, near=(200.0, 0.02), far=(150.0, -0.015), widths=(26.0, 16.0), levels=(0.3, 0.5), ends=(130, 165), noise=2.0
):
    """Near pin from row `ends[0]` down, in front of the far pin, which ends at row `ends[1]`; each at u = a + b v."""
    v, u = np.mgrid[:HEIGHT, :WIDTH].astype(float)
    background = 150 + 0.05 * u + 0.04 * v + 1e-4 * (u - 200) * (v - 100)
    shown = np.ones_like(u)
    for (place, slope), width, level, rows in (
        (far, widths[1], levels[1], v <= ends[1]),
        (near, widths[0], levels[0], v >= ends[0]),
    ):
        axis = place + slope * v
        inside = ndtr((u - axis + width / 2) / 0.9) - ndtr((u - axis - width / 2) / 0.9)
        shown = np.where(rows, shown * (1 - inside) + level * inside, shown)
    return np.clip(np.rint(background * shown + rng.normal(0, noise, u.shape)), 0, 255).astype(np.uint8)
