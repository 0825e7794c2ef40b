"""Random studies of every configuration: for tests that must hold for all of them."""

import numpy as np

from calibore.design import HONEST, KINDS, Study
from calibore.errors import InputError

RANGES = {
    "perpendicular-plane": ((0.5, 5.0), None),
    "single-cone": ((0.2, 0.8), (0.5, 4.0)),
    "dual-cone": ((0.2, 0.8), (0.5, 4.0)),
    "side-facing": ((0.15, 0.8), None),
    "coaxial-cone": ((0.5, 3.0), (0.5, 3.0)),
    "asymmetric-cone": ((0.2, 0.8), (0.7, 3.0)),
    "reversed-cone": ((2.5, 6.0), (0.3, 1.0)),
    "rotating-spot": ((0.15, 0.8), None),
    "spot-array": ((0.5, 5.0), None),
}
LENSES = ("perspective", "stereographic", "equidistant", "equisolid-angle")
CONFIGURATIONS = tuple(KINDS)


def random_study(rng, configuration, *, inputs=HONEST, nominal_radius=None):
    """A study whose numbers make a rig, with a random lens and pipe."""
    baselines, projections = RANGES[configuration]
    while True:
        study = Study(
            configuration,
            float(rng.uniform(0.05, 1.0)) if nominal_radius is None else nominal_radius,
            baseline=float(rng.uniform(*baselines)),
            projection=None if projections is None else float(rng.uniform(*projections)),
            second_clock=float(rng.uniform(1.2, 5.0)),
            beams=4,
            lens=str(rng.choice(LENSES)),
            inputs=inputs,
        )
        try:
            study.rig()
        except InputError:
            continue
        return study


def random_clocks(rng, n):
    return rng.uniform(0, 2 * np.pi, n)
