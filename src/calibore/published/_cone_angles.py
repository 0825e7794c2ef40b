"""Figures 3.3, 3.4, 3.15 and 3.16: the angles of a cone and how well they are known."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from calibore.design import AS_PUBLISHED
from calibore.lasers import ring_angles
from calibore.published._pictures import Chart, Claim, Curve, Picture, Style, Tone, every, single
from calibore.published._printed import principal_aim, principal_half_angle

Array = NDArray[np.float64]
PROJECTION = np.linspace(0.02, 5.0, 250)
LOOKS: tuple[tuple[float, Tone, Style], ...] = (
    (0.25, "blue", "solid"),
    (0.50, "red", "dashed"),
    (0.75, "green", "dash-dot"),
)
"""The baselines of Table 3.1: the text does not say which the figures show."""

L_LABEL = "projection parameter L"
AIM, HALF_ANGLE = 0, 1


def figure_3_3() -> Picture:
    claims = (
        Claim(
            "The larger the projection, the narrower the fan angle (3.4.1).",
            every([np.diff(_angle(D, HALF_ANGLE)) < 0 for D, *_ in LOOKS]),
            "It falls throughout, from 90 deg at L = 0.",
        ),
        _branch_claim("(3-11)", principal_half_angle, HALF_ANGLE),
    )
    return _angles("figure_3_03", "Fan angle against projection", "half angle psi [deg]", HALF_ANGLE, claims)


def figure_3_4() -> Picture:
    claims = (_branch_claim("(3-14)", principal_aim, AIM),)
    return _angles("figure_3_04", "Aim against projection", "aim alpha [deg]", AIM, claims)


def figure_3_15() -> Picture:
    return _known("figure_3_15", "Uncertainty of the aim", "U[alpha] [mrad]", AIM)


def figure_3_16() -> Picture:
    return _known("figure_3_16", "Uncertainty of the fan angle", "U[psi] [mrad]", HALF_ANGLE)


def _angle(baseline: float, which: int) -> Array:
    return np.degrees([ring_angles(baseline, L, 1.0)[which] for L in PROJECTION])


def _angles(name: str, title: str, label: str, which: int, claims: tuple[Claim, ...]) -> Picture:
    printed = (principal_aim, principal_half_angle)[which]
    curves = [Curve(PROJECTION, _angle(D, which), f"D = {D:.2f}", tone, style) for D, tone, style in LOOKS]
    literal = np.degrees(printed(0.5, PROJECTION))
    inside = PROJECTION**2 + 0.25 < 1
    curves.append(Curve(PROJECTION[inside], literal[inside], "D = 0.50, formula as printed", "grey", "dotted"))
    return single(
        name,
        title,
        Chart(L_LABEL, label, tuple(curves), x_limits=(0, 5)),
        note="Baselines and range are not stated in the text; those of Table 3.1 are drawn.",
        claims=claims,
    )


def _branch_claim(equation: str, printed: Callable[..., Array], which: int) -> Claim:
    off = _angle(0.5, which) - np.degrees(printed(0.5, PROJECTION))
    inside = PROJECTION**2 + 0.25 < 1
    return Claim(
        f"{equation} gives the angle for every projection.",
        every(np.abs(off) < 1e-6),
        f"With the principal arctangent it is {np.mean(off[inside]):.1f} deg too small where L² + D² < 1 and right "
        f"elsewhere (within {np.max(np.abs(off[~inside])):.0e} deg); atan2 needs no branch.",
    )


def _known(name: str, title: str, label: str, which: int) -> Picture:
    curves = []
    for D, tone, style in LOOKS:
        slopes = np.array([ring_angles(D, L, 1.0)[2][which] for L in PROJECTION])
        u = AS_PUBLISHED.length * np.hypot(slopes[:, 0], slopes[:, 1])
        curves.append(Curve(PROJECTION, 1e3 * u, f"D = {D:.2f}", tone, style))
    top = max(float(curve.y[0]) for curve in curves)
    claim = Claim(
        "Aim and fan angle inherit the uncertainty of the lengths (3-46, 3-47).",
        None,
        f"Up to {top:.2f} mrad ({np.degrees(top) * 1e-3:.2f} deg) at short projections. As functions of the same two "
        "lengths they are correlated, which (3-40) drops.",
    )
    chart = Chart(L_LABEL, label, tuple(curves), x_limits=(0, 5), y_limits=(0, 1.05 * top))
    note = "U[D] = U[L] = 0.001 as published. Baselines and range are not stated; those of Table 3.1 are drawn."
    return single(name, title, chart, note=note, claims=(claim,))
