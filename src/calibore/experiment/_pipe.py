"""The dissertation's 12 in test pipe (6.3), as far as the text tells its features; rail on the invert throughout."""

import numpy as np

from calibore.experiment._published import INCH, NOMINAL_RADIUS
from calibore.simulation import ConicalProtrusion, Crack, Dent, LateralOpening, Ovality, PipeWall, Rail, Roughness


def experimental_pipe() -> PipeWall:
    """A cone, a dent, an opening, a crack and a rail in a slightly oval pipe, from 0 to 10 in; sizes are ours."""
    return PipeWall(
        NOMINAL_RADIUS,
        (
            Ovality((0.2, 0.2), axis=np.radians(20.0)),
            ConicalProtrusion(1.2 * INCH, 1.7 * INCH, 0.05 * INCH, np.radians(32.0), 4 * INCH),
            Dent(0.35 * INCH, np.radians(272.0), 5 * INCH, clock_width=np.radians(8.0), length=1 * INCH),
            LateralOpening(1.2 * INCH, 0.7 * INCH, np.radians(143.0), 6.5 * INCH, edge=0.2 * INCH),
            Crack(0.06 * INCH, 0.1 * INCH, (1 * INCH, 7 * INCH), (np.radians(95.0), np.radians(110.0))),
            Roughness(0.0015 * INCH, 0.12 * INCH),
            Rail(0.8 * INCH, 1 * INCH),
        ),
    )
