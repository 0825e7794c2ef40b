"""Image in, line position with its uncertainty out. Knows no rig."""

from calibore.stripe._centre import area_centroid
from calibore.stripe._estimators import Estimator, estimator_named
from calibore.stripe._noise import NoiseModel
from calibore.stripe._ring import detect_line, detect_ring
from calibore.stripe._stripe import Stripe

__all__ = ["Estimator", "NoiseModel", "Stripe", "area_centroid", "detect_line", "detect_ring", "estimator_named"]
