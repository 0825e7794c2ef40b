"""Pixels to wall points with uncertainty: the engine against closed forms in NumPy, `uncertainties` and Monte Carlo."""

from functools import partial

import numpy as np

from benchmarks.peers import closed_forms, monte_carlo
from benchmarks.timing import compare
from calibore import rigs
from calibore.lasers import Cone, Plane
from calibore.optics import Camera, Lens
from calibore.uncertainty import Covariance

RADIUS, POINTS, FEW = 0.15, 1_000_000, 2000
DRAWN, DRAWS = 400, 10_000
U_PIXEL, K, CENTRE = 0.3, 320.0, (511.5, 383.5)
CORRELATION, RELATIVE_U = 0.3, 5e-4
PLANE, CONE = Plane(0.15, 0.01, -0.02), Cone.for_ring(0.075, 0.15, RADIUS)
THREADS = {"one thread": 1, "two threads": 2}
COLUMNS = ("radius", "axial", "clock", *(f"u_{q}_{p}" for q in ("radius", "axial") for p in ("independent", "common")))


def report(rounds: int = 15) -> list[str]:
    """Markdown lines."""
    with np.errstate(all="ignore"):
        return [line for kind in ("plane", "cone") for part in (_first_order, _drawn) for line in part(kind, rounds)]


def _first_order(kind: str, rounds: int) -> list[str]:
    rig, given = _rig(kind)
    u, v = _pixels(POINTS)
    form = getattr(closed_forms, kind)
    reference, slow = "closed form, NumPy", f"`uncertainties`, {FEW} points"
    ours = {f"calibore measure, {name}": partial(_measured, rig, u, v, n) for name, n in THREADS.items()}
    theirs = {
        reference: partial(form, u, v, given),
        "closed form, NumPy, in blocks of 8192": partial(closed_forms.in_blocks, form, u, v, given),
    }
    few = {slow: partial(closed_forms.by_uncertainties, kind, *_pixels(FEW), given)}
    against_numpy = compare(ours | theirs, peer=reference, rounds=rounds, rng=np.random.default_rng(1))
    point_by_point = compare(ours | few, peer=slow, rounds=5, rng=np.random.default_rng(2))
    per_point = {name: [r * POINTS / FEW for r in point_by_point.ratio[name]] for name in ours}
    return [
        f"## Triangulation, {kind}: R, H, clock and their uncertainty of {POINTS} pixels, equidistant lens",
        *_agreement(_measured(rig, u, v, 2), form(u, v, given)),
        "| contestant | median ms | NumPy / contestant (95 %) |",
        "|---|---|---|",
        *against_numpy.rows(),
        "",
        "| contestant | `uncertainties` / contestant, per point (95 %) |",
        "|---|---|",
        *(f"| {name} | {r:.0f} ({low:.0f} ... {high:.0f}) |" for name, (r, low, high) in per_point.items()),
        "",
    ]


def _drawn(kind: str, rounds: int) -> list[str]:
    rig, given = _rig(kind)
    u, v, branch = _seen(rig)
    reference = "Monte Carlo, NumPy, mean and u"
    draw = getattr(monte_carlo, kind)
    ours = {f"calibore monte_carlo, mean and u, {name}": (n, None) for name, n in THREADS.items()}
    ours |= {f"calibore monte_carlo, intervals too, {name}": (n, 0.95) for name, n in THREADS.items()}
    contestants = {name: partial(_monte_carlo, rig, (u, v, branch), *options) for name, options in ours.items()}
    contestants[reference] = lambda: draw((u, v, branch > 0), given, DRAWS, np.random.default_rng(2))
    result = compare(contestants, peer=reference, rounds=rounds, rng=np.random.default_rng(1))
    ratio = contestants[next(iter(ours))]().radius.u / contestants[reference]()[:, 1]
    return [
        f"## Monte Carlo, {kind}: {DRAWN} pixels, {DRAWS} draws of rig and pixels",
        f"Ratio of both u(R): mean {ratio.mean():.4f}, scatter {ratio.std():.4f} "
        f"(of draws alone: {np.sqrt(1 / DRAWS):.4f}).",
        "| contestant | median ms | NumPy / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
    ]


def _agreement(ours, theirs):
    errors = [np.abs(getattr(ours, name) / row - 1) for name, row in zip(COLUMNS, theirs, strict=True)]
    return [f"Both agree within {max(np.nanmax(error) for error in errors):.0e} of every number."]


def _measured(rig, u, v, threads):
    return rigs.measure(rig, u, v, u_pixel=U_PIXEL, prior_radius=RADIUS, threads=threads)


def _monte_carlo(rig, pixels, threads, probability):
    u, v, branch = pixels
    rng = np.random.default_rng(1)
    options = {"branch": branch, "probability": probability, "threads": threads}
    return rigs.monte_carlo(rig, u, v, u_pixel=U_PIXEL, draws=DRAWS, rng=rng, **options)


def _seen(rig):
    """Pixels that surely meet the light, and the meetings that count."""
    u, v = _pixels(4 * DRAWN)
    points = rigs.triangulate(rig, u, v, prior_radius=RADIUS)
    margin = rigs.margin(rig, u, v, branch=points.branch, u_pixel=U_PIXEL)
    sure = np.flatnonzero((points.status == 0) & (margin > 10))[:DRAWN]
    return u[sure], v[sure], points.branch[sure]


def _pixels(n):
    rng = np.random.default_rng(3)
    return rng.uniform(200, 824, n), rng.uniform(100, 668, n)


def _rig(kind):
    surface = CONE if kind == "cone" else PLANE
    names = surface.parameter_names[:3]
    geometry = tuple(float(getattr(surface, name)) for name in names)
    u = RELATIVE_U * np.array([geometry[0], 1.0, 1.0, K])
    matrix = np.outer(u, u) * (CORRELATION + (1 - CORRELATION) * np.eye(4))
    covariance = Covariance((*(f"laser.{name}" for name in names), "camera.k"), matrix)
    camera = Camera(1024, 768, Lens("equidistant", K, 384.0), CENTRE)
    configuration = "single-cone" if kind == "cone" else "perpendicular-plane"
    rig = rigs.Rig(configuration, camera, (rigs.Laser(surface),), covariance=covariance)
    return rig, closed_forms.Inputs(geometry, K, covariance.factor(), CENTRE, U_PIXEL, RADIUS)
