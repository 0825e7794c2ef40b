"""Tables 4.1 and 4.2, figures 4.3, 4.4 and 4.6: the perpendicular plane."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from calibore.design import Prediction
from calibore.published._pictures import Chart, Claim, Curve, Level, Map, Picture, Region, Style, Tone, every, single
from calibore.published._plane_numbers import (
    at_pixel,
    occlusion_angle,
    plane,
    plane_at_radius,
    plane_field_of_view,
    plane_uncertainty,
    plane_uncertainty_at_centre,
)
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
LOOKS: tuple[tuple[float, Tone, Style], ...] = (
    (0.50, "purple", "dotted"),
    (0.75, "orange", "dash-dot"),
    (1.00, "green", "dashed"),
    (2.00, "red", "solid"),
    (5.00, "blue", "dashed"),
)
STEP = 8
R_LIMIT, U_LIMIT = 5.0, 0.05
PIXELS = ("p [px] from the centre", "q [px] from the centre")
U_LABEL = "U[R] [% of R0]"
AS_PUBLISHED_NOTE = "1 px, U[D] = 0.001, equidistant lens, 768 px over the field of view of R_max = 2, no tilt."


def _seen(baseline: float) -> tuple[Array, Array, Prediction]:
    p, q = np.arange(-508.0, 512, STEP), np.arange(-380.0, 384, STEP)
    return p, -q, at_pixel(baseline, *np.meshgrid(p, q))


def _map(x: Array, y: Array, found: Prediction, values: Array, **limits: float) -> Map:
    region = np.where(np.isfinite(found.radius), Region.MEASURED, Region.UNSEEN).astype(np.uint8)
    levels = (Level(found.radius, 1.0, "R = 1"), Level(found.radius, 2.0, "R = 2", "black", "dotted"))
    return Map(x, y, values, region, limits["low"], limits["high"], levels)


def table_4_1() -> Picture:
    panels, edges = [], []
    for D, *_ in LOOKS:
        x, y, found = _seen(D)
        shown = _map(x, y, found, found.radius, low=0.0, high=R_LIMIT)
        panels.append(replace(shown, title=f"D = {D:.2f}, FOV {plane_field_of_view(D):.0f} deg"))
        edges.append(float(at_pixel(D, 0.0, 384.0).radius))
    claims = (
        Claim(
            "Fields of view of 152, 139, 127, 90 and 44 deg.",
            [round(plane_field_of_view(D)) for D, *_ in LOOKS] == [152, 139, 127, 90, 44],
            ", ".join(f"{plane_field_of_view(D):.2f}" for D, *_ in LOOKS) + " deg.",
        ),
        Claim(
            "At least R = 2 is seen in every direction.",
            every([abs(edge - 2) < 1e-9 for edge in edges]),
            "R is 2 in the middle of the short image axis' edges and more elsewhere.",
        ),
    )
    note = "White: R above 5. Grey: rays 90 deg or more from the axis. The field of view is that of the short axis."
    return Picture("table_4_01", "Radius in the image", _rows(panels, 3), note, claims, bar="R [R0]", axes=PIXELS)


def _rows(panels: list[Map], columns: int) -> tuple[tuple[Map, ...], ...]:
    return tuple(tuple(panels[first : first + columns]) for first in range(0, len(panels), columns))


def table_4_2() -> Picture:
    panels, off = [], []
    for D, *_ in LOOKS:
        x, y, found = _seen(D)
        low = plane_uncertainty_at_centre(D)
        high = min(U_LIMIT, float(np.nanmax(at_pixel(D, 512.0, 384.0).u_radius))) if D > 2 else U_LIMIT
        shown = _map(x, y, found, found.u_radius, low=low, high=high)
        panels.append(replace(shown, title=f"D = {D:.2f}", bar="U[R] [R0]"))
        around = np.radians(np.arange(0, 360, 15))
        off.append(np.ptp(at_pixel(D, 300 * np.cos(around), 300 * np.sin(around)).u_radius))
    centre = [plane_uncertainty_at_centre(D) for D, *_ in LOOKS]
    at_wall = [plane_uncertainty(D) for D, *_ in LOOKS]
    claims = (
        Claim(
            "Uncertainty seems to decrease as the baseline grows.",
            every(np.diff(at_wall) < 0),
            "On R = 1: "
            + ", ".join(f"{100 * u:.3f}" for u in at_wall)
            + " %: up to D = 2, then hardly changing. In the middle of the image it grows: "
            + ", ".join(f"{u:.5f}" for u in centre)
            + " (the lower ends of the bars).",
        ),
        Claim(
            "The uncertainty is axisymmetric about the centre of the image.",
            every(np.array(off) < 1e-12),
            f"Within {max(off):.0e} on a circle of 300 px.",
        ),
    )
    note = AS_PUBLISHED_NOTE + " White: above the bar. Every map has its own scale, as in the source."
    return Picture("table_4_02", "Uncertainty of the radius in the image", _rows(panels, 2), note, claims, axes=PIXELS)


def figure_4_3() -> Picture:
    radius = np.linspace(0.02, 2.0, 100)
    found = {D: plane_at_radius(D, radius).u_radius for D, *_ in LOOKS}
    curves = tuple(Curve(radius, 100 * found[D], f"D = {D:g}", tone, style) for D, tone, style in LOOKS)
    spread = [found[D][-1] / found[D][0] for D, *_ in LOOKS]
    baselines = np.linspace(0.3, 6, 571)
    best = baselines[np.argmin([plane_uncertainty(D) for D in baselines[::10]]) * 10]
    claims = (
        Claim(
            "With growing baseline the uncertainty becomes nearer to constant.",
            every(np.diff(spread) < 0),
            "U at R = 2 over U in the centre: " + ", ".join(f"{s:.1f}" for s in spread) + ".",
        ),
        Claim(
            "Near R = 1 it decreases with the baseline.",
            None,
            f"It does up to D = {best:.1f} (this camera): there it is {100 * plane_uncertainty(float(best)):.3f} %; "
            f"at D = 5 it is {100 * plane_uncertainty(5.0):.3f} %.",
        ),
    )
    chart = Chart("measured radius R [R0]", U_LABEL, curves, x_limits=(0, 2), y_limits=(0, 3.5))
    return single("figure_4_03", "Uncertainty against measurement", chart, note=AS_PUBLISHED_NOTE, claims=claims)


def figure_4_4() -> Picture:
    tilt = np.linspace(0.0, 3.0, 61)
    found = {D: np.array([_u_with_tilt(D, t) for t in tilt]) for D, *_ in LOOKS}
    curves = tuple(Curve(tilt, 100 * found[D], f"D = {D:g}", tone, style) for D, tone, style in LOOKS)
    added = [u[-1] / u[0] for u in found.values()]
    half = 100 * (np.interp(0.5, tilt, found[0.5]) ** 2 - found[0.5][0] ** 2) ** 0.5
    claims = (
        Claim(
            "Tilt matters much with short baselines and much less with long ones.",
            every(np.diff(added) < 0),
            f"3 deg multiply U by {', '.join(f'{a:.1f}' for a in added)} for D = 0.5 to 5. Half a degree adds "
            f"{half:.1f} % of R0 at D = 0.5, twice the rest of the budget ({100 * found[0.5][0]:.2f} %).",
        ),
    )
    chart = Chart("U[tilt of the laser plane] [deg]", U_LABEL, curves, x_limits=(0, 3), y_limits=(0, 6))
    note = (
        AS_PUBLISHED_NOTE
        + " R = 1, in the direction of the tilt. By the tilt vector: with (4-21) and a direction beta "
        "the tilt has no direction at zero."
    )
    return single("figure_4_04", "Uncertainty against misalignment", chart, note=note, claims=claims)


def _u_with_tilt(baseline: float, degrees: float) -> float:
    rig = plane(baseline)
    assert rig.covariance is not None
    tilt = Covariance.independent({"laser.tilt_x": float(np.radians(degrees))})
    return float(plane_at_radius(baseline, 1.0, rig=rig.knowing(rig.covariance.joined(tilt))).u_radius)


def figure_4_6() -> Picture:
    baselines = np.linspace(0.25, 5.0, 96)
    u = np.array([plane_uncertainty(D) for D in baselines])
    angle = np.array([occlusion_angle(D) for D in baselines])
    at, there = 100 * plane_uncertainty(2.0), occlusion_angle(2.0)
    claims = (
        Claim(
            "At D = 2 slightly more than 0.5 %, with an occlusion angle of over 25 deg.",
            bool(0.5 < at < 0.55 and there > 25),
            f"{at:.4f} % and {there:.2f} deg.",
        ),
    )
    chart = Chart(
        "baseline parameter D",
        U_LABEL,
        (
            Curve(baselines, 100 * u, "U[R] at R = 1 (left)", "red"),
            Curve(baselines, angle, "occlusion angle (right)", "blue", "dotted", right=True),
        ),
        x_limits=(0, 5),
        y_limits=(0, 1.5),
        right_label="occlusion angle [deg]",
        right_limits=(0, 90),
    )
    return single("figure_4_06", "Design chart for the baseline", chart, note=AS_PUBLISHED_NOTE, claims=claims)
