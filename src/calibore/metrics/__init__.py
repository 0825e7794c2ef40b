"""Quantities of one ring of radii: diameters, area, perimeter, ovality, deflection, each with its uncertainty.

`ring_quantities` is the whole of it; the functions below it are the definitions on plain diameters, each named with the
standard that defines it.
"""

from calibore.metrics._definitions import (
    area,
    deflection,
    diameter_equivalent_area,
    diameter_mean,
    ovality_f1216_max,
    ovality_f1216_min,
    ovality_harmonic,
    ovality_range,
    perimeter,
)
from calibore.metrics._quantities import RingQuantities, ring_quantities
from calibore.metrics._shape import RingShape

__all__ = [
    "RingQuantities",
    "RingShape",
    "area",
    "deflection",
    "diameter_equivalent_area",
    "diameter_mean",
    "ovality_f1216_max",
    "ovality_f1216_min",
    "ovality_harmonic",
    "ovality_range",
    "perimeter",
    "ring_quantities",
]
