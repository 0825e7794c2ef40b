"""Figures 3.17 and 3.19 to 3.23: how well one and two cones measure."""

import numpy as np
from numpy.typing import NDArray

from calibore.published._cone_angles import LOOKS
from calibore.published._cone_numbers import (
    EVERY,
    composite,
    crown_deflection,
    dual_cone_uncertainty,
    dual_worst_azimuth,
    dual_worst_uncertainty,
    parallel_azimuth,
    square_rig,
    touching_azimuth,
    u_on_wall,
)
from calibore.published._pictures import Chart, Claim, Curve, Picture, Style, Tone, every, single

Array = NDArray[np.float64]
AZIMUTH, U_LABEL = "azimuth [deg], 90 = crown", "U[R] [% of R0]"
BASELINES = np.geomspace(0.1, 0.9, 41)
PROJECTIONS = np.geomspace(0.5, 5.0, 41)
PROJECTION_LOOKS: tuple[tuple[float, Tone, Style], ...] = (
    (0.5, "purple", "dotted"),
    (0.75, "orange", "dash-dot"),
    (1.0, "green", "dashed"),
    (2.0, "red", "solid"),
    (5.0, "blue", "dashed"),
)
AS_PUBLISHED_NOTE = (
    "1 px, U[D] = U[L] = 0.001, equidistant lens, 1024 px over 2 theta_max, inputs taken as uncorrelated."
)


def figure_3_17() -> Picture:
    touching, parallel = touching_azimuth(0.5, 1.0), parallel_azimuth(0.5, 1.0)
    close = u_on_wall(square_rig(0.5, 1.0), touching + np.array([8.0, 16.0]))
    claim = Claim(
        '"The uncertainty becomes infinite near the sides of the expected measurement ring."',
        float(close[0]) > 1.7 * float(close[1]),
        f"At {touching:.2f} and {180 - touching:.2f} deg, where the ray touches the cone. In the shaded bands (from "
        f"{parallel:.2f} to {touching:.2f} deg, and mirrored) the wall is the near meeting; (3-37) takes the far one.",
    )
    u = 100 * u_on_wall(square_rig(0.5, 1.0), EVERY)
    chart = Chart(
        AZIMUTH,
        U_LABEL,
        (Curve(EVERY, u, "one cone, R = 1"),),
        x_limits=(-180, 180),
        y_limits=(0, 10),
        bands=((parallel, touching), (-180 - touching, -180 - parallel)),
        band_label="(3-37) takes the wrong meeting",
    )
    return single("figure_3_17", "Expected uncertainty, D = 0.5, L = 1", chart, note=AS_PUBLISHED_NOTE, claims=(claim,))


def figure_3_19() -> Picture:
    rig = square_rig(0.5, 1.0, lasers=2)
    singles = [100 * u_on_wall(rig, EVERY, laser=number) for number in (0, 1)]
    worst = dual_worst_azimuth(0.5, 1.0)
    claim = Claim(
        "The worst uncertainty of the composite profile is at -45 deg.",
        worst == -45.0,
        f"At {worst:g} deg: {100 * dual_worst_uncertainty(0.5, 1.0):.3f} %. This needs the second laser at azimuth 180 "
        "deg (9 h); at 0 deg the worst place would be -135 deg.",
    )
    curves = (
        Curve(EVERY, singles[0], "laser at the crown", "red", "dotted"),
        Curve(EVERY, singles[1], "laser at 9 h", "green", "dashed"),
        Curve(EVERY, 100 * composite(rig, EVERY), "the better of both", "blue"),
    )
    chart = Chart(AZIMUTH, U_LABEL, curves, x_limits=(-180, 180), y_limits=(0, 4))
    note = AS_PUBLISHED_NOTE + " Aspect ratio neglected, as in the text."
    return single("figure_3_19", "Composite uncertainty, D = 0.5, L = 1", chart, note=note, claims=(claim,))


def _over_baseline(projection: float) -> Array:
    return np.array([dual_cone_uncertainty(D, projection) for D in BASELINES])


def _over_projection(baseline: float) -> Array:
    return np.array([dual_cone_uncertainty(baseline, L) for L in PROJECTIONS])


def figure_3_20() -> Picture:
    found = {L: _over_baseline(L) for L, *_ in PROJECTION_LOOKS}
    curves = tuple(Curve(BASELINES, 100 * found[L], f"L = {L:g}", tone, style) for L, tone, style in PROJECTION_LOOKS)
    best = ", ".join(f"{BASELINES[np.argmin(found[L])]:.2f} at L = {L:g}" for L in (0.5, 0.75, 1.0))
    claims = (
        Claim(
            "With a projection of 2 or more, larger baselines are better.",
            every([np.diff(found[L]) < 0 for L in (2.0, 5.0)]),
            f"U falls up to D = {BASELINES[np.argmin(found[2.0])]:.2f} at L = 2 and to "
            f"{BASELINES[np.argmin(found[5.0])]:.2f} at L = 5 (drawn to 0.90).",
        ),
        Claim(
            "With shorter projections a larger baseline makes it worse beyond a point.",
            every([np.argmin(found[L]) < len(BASELINES) - 1 for L in (0.5, 0.75)]),
            f"The best baselines are {best} (drawn to 0.90).",
        ),
    )
    chart = Chart("baseline parameter D", U_LABEL, curves, x_limits=(0.1, 0.9), y_limits=(0, 8))
    note = AS_PUBLISHED_NOTE + " Azimuth -45 deg, R = 1. Which projections the figure shows is not stated."
    return single("figure_3_20", "Uncertainty against baseline, two cones", chart, note=note, claims=claims)


def figure_3_21() -> Picture:
    found = {D: _over_projection(D) for D, *_ in LOOKS}
    curves = tuple(Curve(PROJECTIONS, 100 * found[D], f"D = {D:.2f}", tone, style) for D, tone, style in LOOKS)
    half, one, two, five = (float(np.interp(L, PROJECTIONS, found[0.5])) for L in (0.5, 1.0, 2.0, 5.0))
    claims = (
        Claim(
            "Accuracy improves with the projection, at a decreasing rate.",
            every([(np.diff(u) < 0) & np.append(np.diff(u, 2) > 0, True) for u in found.values()]),
            f"At D = 0.5: {100 * half:.2f}, {100 * one:.2f}, {100 * two:.2f}, {100 * five:.2f} % at L = 0.5, 1, 2, 5.",
        ),
        Claim(
            "A projection of at least 2 avoids high uncertainty.",
            None,
            f"From L = 1 to 2 U falls by {100 * (1 - two / one):.0f} %, from 2 to 5 by {100 * (1 - five / two):.0f} % "
            "(D = 0.5).",
        ),
    )
    chart = Chart("projection parameter L", U_LABEL, curves, x_limits=(0.5, 5), y_limits=(0, 6))
    note = AS_PUBLISHED_NOTE + " Azimuth -45 deg, R = 1. Which baselines the figure shows is not stated."
    return single("figure_3_21", "Uncertainty against projection, two cones", chart, note=note, claims=claims)


def figure_3_22() -> Picture:
    u = _over_baseline(2.0)
    correlated = np.array([dual_cone_uncertainty(D, 2.0, correlated=True) for D in BASELINES])
    at = {D: 100 * dual_cone_uncertainty(D, 2.0) for D in (0.2, 0.4, 0.5, 0.6)}
    claims = (
        Claim(
            "Below about D = 0.4 the accuracy degrades very quickly.",
            at[0.2] > 1.5 * at[0.4],
            f"From {at[0.4]:.2f} % at 0.4 to {at[0.2]:.2f} % at 0.2.",
        ),
        Claim(
            "D between 0.4 and 0.6 allows 20 to 25 % of deflection at 1.3 to 1.5 %.",
            all(1.25 <= at[D] < 1.55 and 0.195 <= crown_deflection(D) < 0.255 for D in (0.4, 0.5, 0.6)),
            f"U is {at[0.4]:.2f}, {at[0.5]:.2f}, {at[0.6]:.2f} % at D = 0.4, 0.5, 0.6, where 30, 25, 20 % can be seen: "
            "1.3 to 1.5 % and 20 to 25 % belong to different ranges of D.",
        ),
    )
    curves = (
        Curve(BASELINES, 100 * u, "U[R] (left)", "red"),
        Curve(BASELINES, 100 * correlated, "U[R], angles correlated with D and L (left)", "black", "dash-dot"),
        Curve(BASELINES, (1 + BASELINES) / 2, "smallest R at the crown (right)", "blue", "dotted", right=True),
    )
    chart = Chart(
        "baseline parameter D",
        U_LABEL,
        curves,
        x_limits=(0.1, 0.9),
        y_limits=(0, 4),
        right_label="R_min at the crown [R0]",
        right_limits=(0, 1.0),
    )
    note = AS_PUBLISHED_NOTE + " L = 2, azimuth -45 deg, R = 1. The correlated curve is ours."
    return single("figure_3_22", "Design tradeoff, two cones", chart, note=note, claims=claims)


def figure_3_23() -> Picture:
    radius = np.linspace(0.6, 2.0, 71)
    found = {D: u_on_wall(square_rig(D, 2.0), -45.0, radius) for D, *_ in LOOKS}
    curves = tuple(Curve(radius, 100 * found[D], f"D = {D:.2f}", tone, style) for D, tone, style in LOOKS)
    claims = (
        Claim(
            "The accuracy degrades quite rapidly as the measurement grows.",
            every([np.diff(u) > 0 for u in found.values()]),
            f"At D = 0.5 {100 * np.interp(1, radius, found[0.5]):.2f} % at R = 1, {100 * found[0.5][-1]:.2f} % at 2.",
        ),
        Claim(
            "At D = 0.5 it is nearly 5 % where R = 2.",
            bool(0.045 < found[0.5][-1] < 0.05),
            f"{100 * found[0.5][-1]:.2f} %.",
        ),
    )
    chart = Chart("measured radius R [R0]", U_LABEL, curves, x_limits=(0.6, 2), y_limits=(0, 10))
    note = AS_PUBLISHED_NOTE + " L = 2, azimuth -45 deg. Which baselines the figure shows is not stated."
    return single("figure_3_23", "Uncertainty against measurement, two cones", chart, note=note, claims=claims)
