"""Figure 4.5: what a feature on the wall hides from cameras at different baselines."""

import numpy as np

from calibore.published._pictures import Chart, Claim, Curve, Picture, Tone, single
from calibore.published._plane_numbers import occlusion_angle

LARGE, SMALL = (0.30, 0.45), (0.10, 0.35)
"""Height of a feature and distance of its top from the laser plane, in nominal radii, chosen for the text's case."""

WIDTH = 0.25


def hidden_beyond(height: float, distance: float) -> float:
    """The baseline from which a feature hides the foot of the wall in the laser plane: 1 / tan of its own angle."""
    return distance / height


def figure_4_5() -> Picture:
    crown, invert = hidden_beyond(*LARGE), hidden_beyond(*SMALL)
    claims = (
        Claim(
            "The large feature at the crown is no problem at D = 1 but is at D = 2.",
            1 < crown < 2,
            f"It hides the line from D = {crown:.2f} on.",
        ),
        Claim(
            "The small one at the invert is none at D = 1 and 2, but is at D = 5.",
            2 < invert < 5,
            f"It hides the line from D = {invert:.2f} on.",
        ),
        Claim(
            "The angle between wall and camera ray decides (4-25).",
            all(abs(np.tan(np.radians(occlusion_angle(D))) * D - 1) < 1e-12 for D in (1.0, 2.0, 5.0)),
            ", ".join(f"{occlusion_angle(D):.1f} deg at D = {D:g}" for D in (1.0, 2.0, 5.0)) + ".",
        ),
    )
    curves = (
        Curve(np.array([-2.2, 0.5]), np.array([1.0, 1.0]), "pipe wall", "black"),
        Curve(np.array([-2.2, 0.5]), np.array([-1.0, -1.0]), "", "black"),
        Curve(np.array([0.0, 0.0]), np.array([-1.0, 1.0]), "laser plane", "purple", "dash-dot"),
        _feature(LARGE, 1.0, "features on the wall"),
        _feature(SMALL, -1.0),
        *_rays(1.0, "blue"),
        *_rays(2.0, "red"),
    )
    chart = Chart(
        "along the pipe [R0], laser plane at 0",
        "across [R0]",
        curves,
        x_limits=(-2.2, 0.5),
        y_limits=(-1.35, 1.35),
        equal=True,
    )
    note = "A sketch: the sizes of the features are ours, chosen so that the cases of the text occur."
    return single("figure_4_05", "Occlusion", chart, note=note, claims=claims)


def _feature(size: tuple[float, float], wall: float, label: str = "") -> Curve:
    height, distance = size
    x = -distance - np.array([0.0, 0.0, WIDTH, WIDTH])
    return Curve(x, wall * (1 - height * np.array([0.0, 1.0, 1.0, 0.0])), label, "grey")


def _rays(baseline: float, tone: Tone) -> tuple[Curve, ...]:
    return tuple(
        Curve(
            np.array([-baseline, 0.0]),
            np.array([0.0, wall]),
            f"rays of a camera at D = {baseline:g}" if wall > 0 else "",
            tone,
            "dashed",
        )
        for wall in (1.0, -1.0)
    )
