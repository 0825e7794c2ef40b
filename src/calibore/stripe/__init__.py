"""Image in, line position with its uncertainty out. Knows no rig."""

from calibore.stripe._centre import area_centroid
from calibore.stripe._estimators import Estimator, estimator_named
from calibore.stripe._in_file import RingPlace, detect_line_in, detect_rings_in
from calibore.stripe._noise import NoiseModel
from calibore.stripe._ring import detect_line, detect_ring
from calibore.stripe._spacetime import Passage, brightness_at, passages, replaced
from calibore.stripe._stripe import Stripe

__all__ = [
    "Estimator",
    "NoiseModel",
    "Passage",
    "RingPlace",
    "Stripe",
    "area_centroid",
    "brightness_at",
    "detect_line",
    "detect_line_in",
    "detect_ring",
    "detect_rings_in",
    "estimator_named",
    "passages",
    "replaced",
]
