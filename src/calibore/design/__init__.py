"""Design: how well a rig will measure, before it is built.

`Assumptions`     how well lengths and line positions are known: `AS_PUBLISHED`, `HONEST`, or any other
`plane_rig`, `cone_rig`, `side_rig`, `coaxial_rig`, `asymmetric_rig`, `reversed_rig`, `spot_rig`,
`spot_array_rig`   reference rigs
`predict`         R, H and their uncertainties at pixels -> `Prediction`; `predict_on_wall` at places of a round wall
`combine_lasers`  several lasers on the same wall: the better one, or minimum variance
"""

from calibore.design._assumptions import AS_PUBLISHED, HONEST, Assumptions
from calibore.design._fusion import Combined, combine_lasers
from calibore.design._prediction import STRIPE, Part, Prediction, in_image, predict, predict_on_wall, scan_direction
from calibore.design._spots import spot_array_rig
from calibore.design._studies import (
    asymmetric_rig,
    coaxial_rig,
    cone_rig,
    plane_rig,
    reversed_rig,
    side_rig,
    side_view,
    spot_rig,
)
from calibore.design._wall import lit_points

__all__ = [
    "AS_PUBLISHED",
    "HONEST",
    "STRIPE",
    "Assumptions",
    "Combined",
    "Part",
    "Prediction",
    "asymmetric_rig",
    "coaxial_rig",
    "combine_lasers",
    "cone_rig",
    "in_image",
    "lit_points",
    "plane_rig",
    "predict",
    "predict_on_wall",
    "reversed_rig",
    "scan_direction",
    "side_rig",
    "side_view",
    "spot_array_rig",
    "spot_rig",
]
