"""Tables 5.1 and 5.2, figures 5.3 to 5.6: the side-facing head."""

import numpy as np
from numpy.typing import NDArray

from calibore.design import AS_PUBLISHED, Prediction
from calibore.published._pictures import Chart, Claim, Curve, Map, Picture, Region, Style, Tone, every, single
from calibore.published._side_numbers import (
    at_pixel,
    at_radius,
    head,
    side_aim,
    side_field_of_view,
    side_smallest_radius,
    side_u_axial,
    side_u_radius,
    side_uncertainty,
)

Array = NDArray[np.float64]
LOOKS: tuple[tuple[float, Tone, Style], ...] = (
    (0.25, "blue", "solid"),
    (0.50, "red", "dashed"),
    (0.75, "green", "dash-dot"),
)
BASELINES = np.linspace(0.1, 0.9, 81)
STEP = 8
PIXELS = ("q [px] along the pipe", "p [px] along the range")
D_LABEL, U_LABEL = "baseline parameter D", "U[R] [% of R0]"
AS_PUBLISHED_NOTE = (
    "1 px along u and along v, U[D] = U[R_max] = 0.001, aim taken as independent, 1024 px along the range."
)
SHORT, LONG, EDGE = -512.0, 512.0, 384.0


def _seen(baseline: float) -> tuple[Array, Array, Prediction]:
    p, q = np.arange(-508.0, 512, STEP), np.arange(-380.0, 384, STEP)
    q_grid, p_grid = np.meshgrid(q, p)
    return q, p, at_pixel(baseline, p_grid, q_grid)


def _map(q: Array, p: Array, values: Array, low: float, high: float, bar: str) -> Map:
    return Map(q, p, values, np.full(values.shape, Region.MEASURED, dtype=np.uint8), low, high, bar=bar)


def table_5_1() -> Picture:
    rows, extent = [], []
    for D, *_ in LOOKS:
        q, p, found = _seen(D)
        ends = [at_pixel(D, end, EDGE) for end in (SHORT, LONG)]
        half = float(ends[1].axial)
        radius = _map(q, p, found.radius, float(ends[0].radius), float(ends[1].radius), "R [R0]")
        rows.append((radius, _map(q, p, found.axial, -half, half, "H [R0]")))
        extent.append(half)
    along = [float(np.max(np.ptp(_seen(D)[2].radius, axis=1) / _seen(D)[2].radius.min(axis=1))) for D, *_ in LOOKS]
    claims = (
        Claim(
            "The maps are not strong functions of the baseline.",
            None,
            f"R starts at {', '.join(f'{side_smallest_radius(D):.3f}' for D, *_ in LOOKS)} and ends at 2; H reaches "
            f"{', '.join(f'{h:.3f}' for h in extent)}: alike in form, not in numbers.",
        ),
        Claim(
            "R changes very little along the pipe (5.3.5).",
            max(along) < 0.01,
            f"By {100 * min(along):.2f} to {100 * max(along):.2f} % from the centre column to the edge.",
        ),
    )
    note = (
        "Range upwards (1024 px), pipe across (768 px). The bars end where those of the source do: at the edge column."
    )
    title = "Radius and axial place in the image"
    return Picture(
        "table_5_01", title, tuple(rows), note, claims, _row_names(), ("radius R", "axial place H"), axes=PIXELS
    )


def _row_names() -> tuple[str, ...]:
    return tuple(f"D = {D:.2f}" for D, *_ in LOOKS)


def table_5_2() -> Picture:
    rows, least = [], []
    for D, *_ in LOOKS:
        q, p, found = _seen(D)
        first, last = (side_u_radius(D, p=end, q=EDGE) for end in (SHORT, LONG))
        corner, top = (side_u_axial(D, p=end, q=EDGE) for end in (SHORT, LONG))
        low = side_u_axial(D, p=SHORT, q=0.0)
        rows.append(
            (
                _map(q, p, found.u_radius, first, last, "U[R] [R0]"),
                _map(q, p, found.u_axial, low, top, "U[H] [R0]"),
            )
        )
        least.append((low, corner))
    middle = [side_u_axial(D, p=0.0, q=0.0) for D, *_ in LOOKS]
    lowest, corners, central = (", ".join(f"{u:.3e}" for u in us) for us in (*zip(*least, strict=True), middle))
    claims = (
        Claim(
            "Less uncertainty for inward than for outward deflection, and with larger baselines.",
            every([np.diff(at_radius(D, np.linspace(0.9, 2, 30)).u_radius) > 0 for D, *_ in LOOKS])
            and every(np.diff([side_uncertainty(D) for D, *_ in LOOKS]) < 0),
            "At R = 1: " + ", ".join(f"{100 * side_uncertainty(D):.3f} %" for D, *_ in LOOKS) + ".",
        ),
        Claim(
            "U[H] is best near the centre of the image.",
            every([m <= low for m, (low, _) in zip(middle, least, strict=True)]),
            "On every row it is least on the centre column, but the least of all lies in the middle of the edge of "
            f"short range: {lowest} against {central} in the centre. The bars of the source begin at the corners "
            f"({corners}).",
        ),
    )
    note = AS_PUBLISHED_NOTE + " The bars of U[H] begin at the true minimum, lower than those of the source."
    title = "Uncertainty in the image"
    return Picture("table_5_02", title, tuple(rows), note, claims, _row_names(), ("U[R]", "U[H]"), axes=PIXELS)


def figure_5_3() -> Picture:
    aim, view = (np.array([f(D) for D in BASELINES]) for f in (side_aim, side_field_of_view))
    centred = np.degrees(np.arctan2(BASELINES, 1.0))
    claims = (
        Claim(
            "Aim 20.5 deg and 0.018 deg per pixel for D = 0.4 (7.4.4).",
            bool(abs(side_aim(0.4) - 20.5) < 0.05),
            f"{side_aim(0.4):.3f} deg; field of view {side_field_of_view(0.4):.3f} deg.",
        ),
        Claim(
            "Also shown: the aim that places R = 1 in the centre.",
            None,
            "arctan(D) by (5-17); at D = 0.4 "
            f"{np.degrees(np.arctan(0.4)):.2f} deg, {np.degrees(np.arctan(0.4)) - side_aim(0.4):+.2f} deg from (5-23).",
        ),
    )
    curves = (
        Curve(BASELINES, aim, "aim (5-23)", "red"),
        Curve(BASELINES, view, "field of view (5-22)", "blue", "dashed"),
        Curve(BASELINES, centred, "aim that centres R = 1", "black", "dotted"),
    )
    chart = Chart(D_LABEL, "angle [deg]", curves, x_limits=(0.1, 0.9), y_limits=(0, 45))
    return single("figure_5_03", "Aim and field of view", chart, note="R_max = 2, R_min = (1 + D) / 2.", claims=claims)


def figure_5_4() -> Picture:
    u = np.array([_u_aim(D) for D in BASELINES])
    claim = Claim(
        "The aim inherits the uncertainty of D and R_max (5-36).",
        None,
        f"{1e3 * u[0]:.2f} mrad at D = 0.1 to {1e3 * u[-1]:.2f} at 0.9; hardly any of it from R_max. It is the same "
        "uncertainty as that of D, and (5-24) takes the two as independent.",
    )
    chart = Chart(D_LABEL, "U[alpha] [mrad]", (Curve(BASELINES, 1e3 * u),), x_limits=(0.1, 0.9), y_limits=(0, 1.2))
    note = f"U[D] = U[R_max] = {AS_PUBLISHED.length:g}, R_max = 2."
    return single("figure_5_04", "Uncertainty of the aim", chart, note=note, claims=(claim,))


def _u_aim(baseline: float) -> float:
    known = head(float(baseline)).covariance
    assert known is not None
    return float(known.u[known.names.index("laser.aim")])


def figure_5_5() -> Picture:
    p, curves, ends = np.linspace(SHORT, LONG, 129), [], []
    for D, tone, style in LOOKS:
        found = at_pixel(D, p, np.full(p.shape, EDGE))
        curves.append(Curve(found.radius, 100 * found.u_radius, f"D = {D:.2f}", tone, style))
        ends.append(float(found.radius[0]))
    claims = (
        Claim(
            "Larger baselines reduce the uncertainty; the curves end at the least radius.",
            every(np.diff([float(np.interp(1.0, curve.x, curve.y)) for curve in curves]) < 0),
            f"They begin at R = {', '.join(f'{end:.3f}' for end in ends)} on the edge column, where the centre column "
            "has (1 + D) / 2.",
        ),
    )
    chart = Chart("measured radius R [R0]", U_LABEL, tuple(curves), x_limits=(0.5, 2), y_limits=(0, 1.8))
    note = AS_PUBLISHED_NOTE + " A slice along one edge, as in the source."
    return single("figure_5_05", "Uncertainty against measurement", chart, note=note, claims=claims)


def figure_5_6() -> Picture:
    baselines = BASELINES[10:]
    u = np.array([side_uncertainty(D) for D in baselines])
    correlated = np.array([float(at_radius(D, 1.0, correlated=True).u_radius) for D in baselines])
    least = np.array([side_smallest_radius(D) for D in baselines])
    at = {D: 100 * side_uncertainty(D) for D in (0.3, 0.5)}
    claims = (
        Claim(
            "D from 0.3 to 0.5 gives 0.50 to 0.25 % and measures down to 65 to 75 %.",
            None,
            f"{at[0.3]:.3f} to {at[0.5]:.3f} % and {side_smallest_radius(0.3):.2f} to {side_smallest_radius(0.5):.2f}: "
            "the 0.50 is rounded up.",
        ),
        Claim(
            "Baseline and aim are independent inputs.",
            bool(np.allclose(u, correlated, rtol=0.05)),
            "The aim follows from the baseline. With their correlation U falls to "
            + ", ".join(f"{100 * np.interp(D, baselines, correlated):.3f} % at D = {D:g}" for D in (0.25, 0.4, 0.5))
            + ".",
        ),
    )
    chart = Chart(
        D_LABEL,
        U_LABEL,
        (
            Curve(baselines, 100 * u, "U[R] at R = 1 (left)", "red"),
            Curve(baselines, 100 * correlated, "U[R], aim correlated with D (left)", "black", "dash-dot"),
            Curve(baselines, least, "smallest R (right)", "blue", "dotted", right=True),
        ),
        x_limits=(0.2, 0.9),
        y_limits=(0, 0.8),
        right_label="R_min [R0]",
        right_limits=(0, 1.0),
    )
    note = AS_PUBLISHED_NOTE + " The correlated curve is ours."
    return single("figure_5_06", "Design chart for the baseline", chart, note=note, claims=claims)
