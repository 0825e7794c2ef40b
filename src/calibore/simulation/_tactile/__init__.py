"""Scans by touch: a pin with a ball at its end, turned and pushed out until it touches the wall.

`simulate_tactile`   a `TactileSurvey` written as a scan folder with truth.npz; its `Sticking` and `Shank`, the
                     `Diameters` that calibrate its probe
"""

from calibore.simulation._tactile._contact import Shank, Touch, touched
from calibore.simulation._tactile._folder import simulate_tactile
from calibore.simulation._tactile._survey import Diameters, Sticking, TactileSurvey

__all__ = ["Diameters", "Shank", "Sticking", "TactileSurvey", "Touch", "simulate_tactile", "touched"]
