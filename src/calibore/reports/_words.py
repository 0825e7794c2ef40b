"""Fixed words of the report: definitions of what is printed, meanings of flags, how uncertainty is stated."""

from calibore.plotting import GOVERNING_OVALITY

DEFINITIONS = (
    ("D", "Diameter in one direction, D(phi) = r(phi) + r(phi + 180 deg), about the fitted centre of the ring."),
    (
        "Mean, largest, smallest diameter",
        "Mean of D over the whole turn, gaps bridged by a smooth wall at a price in uncertainty; maximum and minimum "
        "of D over the directions measured at both ends, corrected for the noise of the points.",
    ),
    ("Ovality", f"In per cent, {GOVERNING_OVALITY}. This is the ovality meant on this page unless another is named."),
    (
        "Second harmonic",
        "2 |c2| / c0 in per cent: the ovality of the best ellipse-like wave; it does not see local dents.",
    ),
    (
        "Deflection",
        "100 (D0 - D) / D0 in per cent in the worst direction, D0 the nominal diameter; positive where the "
        "pipe has become smaller.",
    ),
    ("Clock position", "Looking along travel, clockwise from the crown: 12 h crown, 3 h right, 6 h invert, 9 h left."),
    ("Measured", "Share of the clock positions that carry a radius."),
)

UNCERTAINTY_STATEMENTS = (
    "Every number after ± is an expanded uncertainty U95 = k u with k = 2 (about 95 % for a normal distribution), "
    "following the Guide to the Expression of Uncertainty in Measurement (JCGM 100).",
    "Independent uncertainty differs from point to point (noise of the line in the image) and averages down over many "
    "points. Common uncertainty comes from the calibration and is shared by the whole scan: it moves all radii "
    "together and no averaging makes it smaller. Every U95 here contains both.",
    "Differences between stations of this scan are known better than the U95 of each of them, because the common part "
    "is the same in both.",
)

FLAG_MEANINGS = {
    "few-points": "too few points for reliable numbers",
    "gap": "part of the ring was not measured and is bridged by a smooth wall, at a price in uncertainty",
    "off-centre": "the rig was more than a tenth of the radius off the pipe's centre",
    "extremes-not-measurable": "too few directions measured on both sides: no smallest, largest diameter or ovality",
    "horizontal-not-measured": "no point at one end of the horizontal diameter",
    "vertical-not-measured": "no point at one end of the vertical diameter",
    "features": "dents, rails, edges or openings that leave the smooth wall",
    "lone-points": "single points that contradict both neighbours were left out",
    "noise-above-stated": "neighbouring points differ by more than their uncertainty, which was enlarged",
    "ovality-not-significant": "the ovality is smaller than its own uncertainty",
    "no-ring": "no usable ring was found",
}
