"""Tables 3.1 to 3.3: what two parameters of a cone rig do to its image."""

import numpy as np
from numpy.typing import NDArray

from calibore.design import AS_PUBLISHED, predict
from calibore.published._cone_numbers import square_rig, touching_azimuth, u_on_wall
from calibore.published._cone_views import (
    BASELINES,
    PROJECTIONS,
    View,
    existing_radii,
    limited_view,
    our_radii,
    printed_radii,
    regions,
    ring_of,
    whole_view,
)
from calibore.published._pictures import Claim, Map, Picture, every
from calibore.rigs import lit_points, triangulate

Array = NDArray[np.float64]
LIMIT, U_LIMIT = 2.0, 0.020
IMAGE_AXES = ("across [deg]", "upwards [deg]")
ROWS = tuple(f"L = {L:.2f}" for L in PROJECTIONS)
COLUMNS = tuple(f"D = {D:.2f}" for D in BASELINES)
RADIUS_BAR = "R [R0]"


def radius_map(view: View, values: Array, *, title: str = "") -> Map:
    """R from 0 to 2 with the ring on a healthy wall."""
    lines = (ring_of(view),)
    return Map(view.x, view.y, values, regions(view, values), 0.0, LIMIT, lines=lines, title=title)


def table_3_1() -> Picture:
    views = [[whole_view(D, L) for D in BASELINES] for L in PROJECTIONS]
    printed = [[printed_radii(view) for view in row] for row in views]
    ours = [[our_radii(view) for view in row] for row in views]
    panels = tuple(
        tuple(radius_map(view, values) for view, *pair in zip(*rows, strict=True) for values in pair)
        for rows in zip(views, printed, ours, strict=True)
    )
    shares = [_share_different(p, o) for ps, os in zip(printed, ours, strict=True) for p, o in zip(ps, os, strict=True)]
    lost = [_ring_lost(D, L) for D in BASELINES for L in PROJECTIONS]
    claims = (
        Claim(
            "Of two meetings the closer one must be discarded (3.2.6).",
            every(np.array(lost) == 0),
            f"Both are lit where a wall stands there. The rules differ in {100 * min(shares):.0f} to "
            f"{100 * max(shares):.0f} % of the rays that meet the light; on a healthy wall (R = 1) the printed rule "
            f"misses {100 * min(lost):.0f} to {100 * max(lost):.0f} % of the ring.",
        ),
    )
    columns = tuple(f"{name}, {rule}" for name in COLUMNS for rule in ("(3-37)", "ours"))
    note = (
        "Left of each pair: the unified solution (3-37) as printed, corrected discriminant. Right: ours, the meeting "
        "nearer to R = 1. All rays up to 90 deg from the camera axis; the laser is above."
    )
    return Picture("table_3_01", "Radius in the image", panels, note, claims, ROWS, columns, RADIUS_BAR, IMAGE_AXES)


def _share_different(printed: Array, ours: Array) -> float:
    met = np.isfinite(printed) & np.isfinite(ours)
    return float((np.abs(printed - ours)[met] > 1e-9).mean())


def _ring_lost(baseline: float, projection: float) -> float:
    """Share of the ring on a wall of R = 1 that (3-37) does not give back."""
    rig = whole_view(baseline, projection).rig
    u, v = rig.project(lit_points(rig, np.linspace(0, 2 * np.pi, 1440, endpoint=False), 1.0))
    near, far = existing_radii(rig, u, v)
    return float((np.abs(np.where(np.isfinite(far), far, near) - 1) > 1e-6).mean())


def table_3_2() -> Picture:
    views = [[limited_view(D, L) for D in BASELINES] for L in PROJECTIONS]
    panels = tuple(tuple(radius_map(view, our_radii(view)) for view in row) for row in views)
    seen = [_crown_and_invert(view) for row in views for view in row]
    least = [(1 + D) / 2 for _ in PROJECTIONS for D in BASELINES]
    claims = (
        Claim(
            "The lower ray of the field of view is parallel to the lower ray of the light (figure 3.14).",
            every([abs(lean) < 1e-12 for _, lean in seen]),
            f"Within {max(abs(lean) for _, lean in seen):.0e} in all 15.",
        ),
        Claim(
            "The least radius at the crown is (1 + D) / 2.",
            bool(np.allclose([radius for radius, _ in seen], least, rtol=1e-9)),
            "The uppermost pixel gives " + ", ".join(f"{radius:.3f}" for radius, _ in seen[:3]) + " in every row.",
        ),
        Claim(
            "The field of view is counted along the long image axis (3-58).",
            None,
            "Then that axis must stand upright, or crown and invert are cut off at 0.75 theta_max; with it across, "
            "figure 3.14 does not hold.",
        ),
    )
    note = "4:3, upright, 2 theta_max along the long axis; ours, the meeting nearer to R = 1. White: R above 2."
    title = "Radius in the limited field of view"
    return Picture("table_3_02", title, panels, note, claims, ROWS, COLUMNS, RADIUS_BAR, IMAGE_AXES)


def _crown_and_invert(view: View) -> tuple[float, float]:
    """Far radius of the uppermost pixel, and how far the lowest ray is from parallel to the light."""
    camera = view.rig.camera
    centre = camera.principal_point[0]
    ray = camera.unproject([centre], [float(camera.height)]).direction[0]
    lean = float(ray @ view.cone.axis - np.cos(view.cone.half_angle))
    return float(triangulate(view.rig, centre, 0.0, branch=1).radius[0]), lean


def table_3_3() -> Picture:
    found = [[_uncertainty(limited_view(D, L)) for D in BASELINES] for L in PROJECTIONS]
    panels = tuple(tuple(found_map for found_map, _ in row) for row in found)
    high = [share for row in found for _, share in row]
    doubled = np.array([_growth(D, L) for D in BASELINES for L in PROJECTIONS])
    claims = (
        Claim(
            "The grey line of R = 1 shows the uncertainty to be expected; it becomes infinite near the sides (3.3.4).",
            every(doubled > 1.7),
            "It ends where the line R = 1 touches the complex region: half way to that azimuth, from 32 to 16 deg, U "
            f"grows {np.min(doubled):.2f} to {np.max(doubled):.2f} times, in every map. {100 * min(high):.0f} "
            f"to {100 * max(high):.0f} % of the pixels that measure are above 0.020.",
        ),
    )
    note = (
        "1 px along u and along v, U[D] = U[L] = 0.001, (3-40) as if uncorrelated; of two meetings the one nearer to "
        "R = 1. White: U above 0.020."
    )
    title = "Uncertainty of the radius in the image"
    return Picture("table_3_03", title, panels, note, claims, ROWS, COLUMNS, "U[R] [R0]", IMAGE_AXES)


def _growth(baseline: float, projection: float) -> float:
    """How U on R = 1 grows from 32 to 16 deg beside the azimuth where the ray touches the cone."""
    beside = touching_azimuth(baseline, projection) + np.array([16.0, 32.0])
    near, far = u_on_wall(square_rig(baseline, projection), beside)
    return float(near / far)


def _uncertainty(view: View) -> tuple[Map, float]:
    noise = {"u_pixel": AS_PUBLISHED.u_pixel, "direction": AS_PUBLISHED.direction}
    found = predict(view.rig, view.u, view.v, prior_radius=1.0, **noise)
    region = regions(view, found.u_radius)
    shown = Map(view.x, view.y, found.u_radius, region, 0.0, U_LIMIT, lines=(ring_of(view, "grey"),))
    measured = np.isfinite(found.u_radius)
    return shown, float((found.u_radius[measured] > U_LIMIT).mean())
