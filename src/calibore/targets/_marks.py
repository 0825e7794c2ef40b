"""What is found of a target in one picture."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Whole = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class RingMarks:
    """Points `u`, `v` (n,) [px] on dark lines, each measured along the unit vector `direction` (n, 2) with standard
    uncertainty `sigma` (n,) [px]. `ring` (n,) counts from 1 at the innermost, 0 on a spoke; `spoke` (n,) counts from
    0 in image azimuth from +u towards +v, -1 on a ring. `centre` (u, v) [px]: where the spokes meet. `width` (n,) [px]
    of the ink across the line at each mark, None where it is not measured. `left_out`: which rings were not measured
    and why, a sentence or nothing.
    """

    u: Array
    v: Array
    direction: Array
    sigma: Array
    ring: Whole
    spoke: Whole
    centre: tuple[float, float]
    width: Array | None = None
    left_out: str = ""


@dataclass(frozen=True, eq=False)
class BoardMarks:
    """Marks at `u`, `v` (n,) [px] of the board's places `x`, `y` (n,) in squares (or dot pitches) from its first mark;
    `sigma` [px] of each coordinate as far as one picture tells, `sigmas` (n,) those of each mark; `blur` [px]: standard
    deviation of the edges' blur; `dot`: diameter of dots in pitches, 0 for corners.
    """

    u: Array
    v: Array
    x: Array
    y: Array
    sigma: float
    blur: float
    sigmas: Array | None = None
    dot: float = 0.0


@dataclass(frozen=True, eq=False)
class PinMarks:
    """The axes of a near and a far pin: `u` (n,) [px] in the rows `v` (n,), standard uncertainty `sigma` (n,) [px];
    `near` (n,) which pin; `half_width` (n,) [px] of the pin there.
    """

    u: Array
    v: Array
    sigma: Array
    near: NDArray[np.bool_]
    half_width: Array | None = None
