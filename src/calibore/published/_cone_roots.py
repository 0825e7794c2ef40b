"""Figures 3.10 to 3.12: where the solutions of a cone change, both of them, and which one is the wall."""

import numpy as np
from numpy.typing import NDArray

from calibore.published._cone_maps import IMAGE_AXES, RADIUS_BAR, radius_map
from calibore.published._cone_numbers import clock_of_azimuth, parallel_azimuth, touching_azimuth
from calibore.published._cone_views import (
    View,
    both_radii,
    existing_radii,
    our_radii,
    printed_radii,
    regions,
    whole_view,
)
from calibore.published._pictures import Chart, Claim, Curve, Level, Map, Picture, Region, Tone, every, single
from calibore.published._printed import (
    Conjugates,
    conjugate_solutions,
    zenith_of_zero_denominator,
    zenith_of_zero_discriminant,
)
from calibore.rigs import lit_points

Array = NDArray[np.float64]
D, L = 0.5, 1.0
AROUND = np.linspace(-np.pi, np.pi, 721)


def figure_3_10() -> Picture:
    view = whole_view(D, L)
    angles = {"aim": view.cone.aim, "half_angle": view.cone.half_angle}
    touching, parallel = zenith_of_zero_discriminant(AROUND, **angles), zenith_of_zero_denominator(AROUND, **angles)
    curves = (
        _around(touching, "discriminant = 0: the ray touches the cone", "red"),
        _around(parallel, "denominator = 0: the ray is parallel to the light", "blue"),
    )
    off = float(np.abs(_touching(view, AROUND, touching)).max())
    lean = float(np.abs(_unit(AROUND, parallel) @ view.cone.axis - np.cos(view.cone.half_angle)).max())
    claims = (
        Claim(
            "(3-35) is where the denominator is zero, (3-36) where the discriminant is.",
            max(off, lean) > 1e-9,
            f"The other way round: on (3-35) the discriminant vanishes (within {off:.0e}), on (3-36) the denominator "
            f"(within {lean:.0e}). As printed, (3-35) also needs |cos(phi)|.",
        ),
    )
    chart = Chart(*IMAGE_AXES, curves, x_limits=(-90, 90), y_limits=(-90, 90), equal=True)
    note = "D = 0.5, L = 1. Zenith is the distance from the middle, as in an image; the laser is above."
    return single("figure_3_10", "Frontiers of change", chart, note=note, claims=claims)


def _around(zenith: Array, label: str, tone: Tone) -> Curve:
    shown = np.degrees(np.where(zenith < np.pi / 2, zenith, np.nan))
    return Curve(shown * np.cos(AROUND), shown * np.sin(AROUND), label, tone)


def _unit(azimuth: Array, zenith: Array) -> Array:
    """(n, 3) rays of the camera frame, whose y points down."""
    sine = np.sin(zenith)
    return np.stack([np.cos(azimuth) * sine, -np.sin(azimuth) * sine, np.cos(zenith)], axis=1)


def _touching(view: View, azimuth: Array, zenith: Array) -> Array:
    rays = _unit(azimuth, zenith)
    return view.cone.frontier(np.zeros(rays.shape), rays).value[0]


def figure_3_11() -> Picture:
    view = whole_view(D, L)
    both = _conjugates(view)
    solved = np.isfinite(both.first) & np.isfinite(both.second)
    behind = solved & (regions(view) == Region.NEGATIVE)
    beyond = solved & (both.denominator > 0)
    panels = tuple(
        _solution(view, values, both, title)
        for values, title in ((both.first, "first solution (+)"), (both.second, "second solution (-)"))
    )
    near, far = both_radii(view)
    two = np.isfinite(near) & np.isfinite(far)
    claims = (
        Claim(
            "Below the lower blue line both solutions are negative.",
            every((both.first[behind] < 0) & (both.second[behind] < 0)),
            f"In all {int(behind.sum())} pixels there; the light would be met behind the camera.",
        ),
        Claim(
            "The first solution gives reasonable values above the upper blue line only.",
            every(both.first[solved & ~beyond] < 0) and every(both.first[two] > 0),
            "It is negative inside the blue line and positive above it.",
        ),
        Claim(
            "The second is valid inside the blue line and above its upper part.",
            every(both.second[solved & ~beyond] > 0) and every(both.second[two] > 0),
            f"Above the blue line it is our near meeting, the first one our far meeting (within "
            f"{np.max(np.abs(both.second - near)[two] / near[two]):.0e}).",
        ),
        Claim(
            "Complex solutions exist outside the envelope of the red line.",
            every(np.isnan(both.first) == (both.discriminant < 0)),
            "Two straight upright lines in the image of a perspective lens.",
        ),
    )
    note = (
        "D = 0.5, L = 1. Instead of green to red, colours that the colour-blind can tell apart; complex and negative "
        "as in the text; white above R = 2."
    )
    title = "Conjugate solutions of the radius"
    return Picture("figure_3_11", title, (panels,), note, claims, bar=RADIUS_BAR, axes=IMAGE_AXES)


def _conjugates(view: View) -> Conjugates:
    angles = {"aim": view.cone.aim, "half_angle": view.cone.half_angle}
    return conjugate_solutions(view.zenith, view.azimuth, baseline=D, **angles)


def _solution(view: View, values: Array, both: Conjugates, title: str) -> Map:
    region = np.where(np.isnan(values), Region.COMPLEX, np.where(values < 0, Region.NEGATIVE, Region.MEASURED))
    region = np.where(view.zenith > np.pi / 2, Region.UNSEEN, region).astype(np.uint8)
    return Map(view.x, view.y, values, region, 0.0, 2.0, _frontiers(both), title=title)


def _frontiers(both: Conjugates) -> tuple[Level, ...]:
    return (
        Level(both.discriminant, 0.0, "discriminant = 0", "red"),
        Level(both.denominator, 0.0, "denominator = 0", "blue"),
    )


def figure_3_12() -> Picture:
    view = whole_view(D, L)
    both = _conjugates(view)
    printed, ours = (
        _with_frontiers(radius_map(view, values, title=title), both)
        for values, title in ((printed_radii(view), "(3-37): far meeting"), (our_radii(view), "ours: nearer to R = 1"))
    )
    azimuth = np.linspace(-30, 90, 1201)
    u, v = view.rig.project(lit_points(view.rig, clock_of_azimuth(azimuth), 1.0))
    near, far = existing_radii(view.rig, u, v)
    read = np.where(np.isfinite(far), far, near)
    touching, parallel = touching_azimuth(D, L), parallel_azimuth(D, L)
    at = float(np.interp(-10.0, azimuth, read))
    chart = Chart(
        "azimuth [deg], 90 = crown",
        "radius read [R0]",
        (Curve(azimuth, read, "(3-37)", "red", "dashed"), Curve(azimuth, _nearest(near, far), "ours", "blue")),
        title="on a wall of R = 1",
        x_limits=(-30, 90),
        y_limits=(0, 5),
        bands=((parallel, touching),),
        band_label="(3-37) takes the wrong meeting",
    )
    claims = (
        Claim(
            "The inversion takes place where the denominator is zero, and the closer meeting is discarded.",
            every(np.abs(read - 1) < 1e-6),
            f"From {parallel:.2f} to {touching:.2f} deg (and mirrored) the healthy wall is the near meeting; (3-37) "
            f"reads {at:.3f} instead of 1 at -10 deg and runs to infinity. We keep both and let a prior radius, and "
            "continuity along the line, decide.",
        ),
    )
    note = "D = 0.5, L = 1. The map needs a prior; while measuring, the line is followed instead (rigs.follow_stripe)."
    return Picture(
        "figure_3_12",
        "Unified solution of the radius",
        ((printed, ours, chart),),
        note,
        claims,
        bar=RADIUS_BAR,
        axes=IMAGE_AXES,
    )


def _nearest(near: Array, far: Array) -> Array:
    away = np.abs(np.log(np.where(np.isfinite(far), far, np.inf)))
    return np.where(away < np.abs(np.log(near)), far, near)


def _with_frontiers(shown: Map, both: Conjugates) -> Map:
    from dataclasses import replace

    return replace(shown, levels=(*_frontiers(both), *shown.levels))
