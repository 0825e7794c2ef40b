"""The dissertation's six instruments in simulated pipes: for the tests, and `python -m benchmarks prediction`."""

from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from calibore.design import predict_on_wall
from calibore.geometry import Pose
from calibore.lasers import Cone, Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.profiling import Job, measure_image, profile_scan
from calibore.rigs import Laser, Rig, SideFacing, measure, project_ring
from calibore.scans import read_profile
from calibore.simulation import (
    LineLight,
    PipeWall,
    Roughness,
    Sensor,
    Station,
    Survey,
    head_pose,
    lit_line,
    photograph,
    read_survey,
    simulate_scan,
    true_ring,
    true_rows,
)
from calibore.stripe import detect_line, detect_ring

INCH = 0.0254
RADIUS = 6 * INCH
LINE, FINE_LINE, SENSOR = LineLight(), LineLight(sigma=0.005 * INCH), Sensor()
"""A head that magnifies five times needs a line five times as fine: the rings' would be 13 px wide, all speckle."""
SINE_LAW = {
    "plane-3in": (3.574, 399.3),
    "plane-6in": (6.85, 446.3),
    "plane-12in": (13.1, 571.0),
    "plane-30in": (34.36, 1173.0),
}
"""Baseline [in] and k [px] of Swanbom 2007, Table 6.1."""
MEASURABLE = 0.05
"""Signal from which a point counts (data README)."""
LENGTH = 9 * INCH
"""Of the test pipe."""
USUAL_NOISE, FIRST_ORDER, SMOOTHED = 0.2, 4.0, 25.0
"""px; margins from which first order holds, and from which a line is not smoothed (docs/decisions/0005)."""
SHAKE = 2e-4, 0.01
"""m, rad: how the rig strays from its place, so that lines fall on pixels everywhere alike."""
KINK, REACH, BESIDE = 0.5e-3, 2, 5
"""An edge is where the wall differs by more than KINK [m] from the mean REACH positions to both sides; BESIDE positions
from it belong to it."""


class Section(NamedTuple):
    """What was measured at one place, n points: `error`, `u` (independent), `common` [m], NaN where nothing counts;
    `away` (n,) from edges.
    """

    error: np.ndarray
    u: np.ndarray
    common: np.ndarray
    away: np.ndarray


class Rays(NamedTuple):
    """The same of single rays: `error` [m] of the radius, `u` [px] of the line, `clock` [rad]."""

    error: np.ndarray
    u: np.ndarray
    clock: np.ndarray


def instruments():
    """The rigs by name, nothing stated of their uncertainty."""
    rigs = {
        name: Rig("perpendicular-plane", _camera("sine-law", k), (Laser(Plane(baseline * INCH), "red"),))
        for name, (baseline, k) in SINE_LAW.items()
    }
    cone = Cone.for_ring(3 * INCH, 12 * INCH, RADIUS)
    rigs["cone-single"] = Rig("single-cone", _camera("sine-law", 571.0), (Laser(cone, "red"),))
    head = SideFacing(2.355 * INCH, np.radians(19.9))
    camera = _camera("equidistant", 1 / np.radians(0.0175))
    rigs["side-2.4in"] = Rig("side-facing", camera, (Laser(Sheet(), "red"),), mount=head)
    return rigs


def _camera(law, k):
    return Camera(1024, 768, Lens(law, k, 384.0), (512.0, 384.0))


def walls():
    """A plain pipe, the dissertation's test pipe without its texture, and with."""
    survey, _ = read_survey(Path(__file__).parents[2] / "examples" / "test-pipe.toml")
    smooth = tuple(part for part in survey.wall.parts if not isinstance(part, Roughness))
    return {"plain": PipeWall(RADIUS), "test pipe, smooth": PipeWall(RADIUS, smooth), "test pipe": survey.wall}


def ahead(rig):
    """From the rig's origin to its light on the wall [m]."""
    surface = rig.lasers[0].surface
    return surface.baseline if isinstance(surface, Plane) else 2 * RADIUS if isinstance(surface, Cone) else 0.0


def pose_in(rng, rig, where=None):
    """A place of the rig from which its light falls `where` [m] along the pipe, anywhere in it by default."""
    shift, turn = SHAKE
    along = rng.uniform(0, LENGTH) if where is None else where
    x, y = 0.011 * INCH + shift * rng.standard_normal(), 0.010 * INCH + shift * rng.standard_normal()
    roll = np.radians(0.5) + turn * rng.standard_normal()
    return Pose.from_roll_pitch_yaw(roll, translation=(x, y, along - ahead(rig)))


def picture(rig, wall, rng):
    """(picture, line, pose) of a ring."""
    pose = pose_in(rng, rig)
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=LINE, psf_sigma=SENSOR.psf_sigma)
    return photograph(lit, rig, line=LINE, sensor=SENSOR, rng=rng, speckle_rng=rng), lit, pose


def ring_section(rig, wall, seed, *files):
    """One station of a rig that draws rings, measured with each of the rig files `files` (none: with the exact one)."""
    rng = np.random.default_rng([41, seed])
    image, lit, pose = picture(rig, wall, rng)
    truth = true_ring(lit, rig, wall, pipe_from_rig=pose, line=LINE)
    rings = [measure_image(image, Job.of(stated, RADIUS)) for stated in files or (rig,)]
    sections = []
    for ring in rings:
        counts = truth.visible & (truth.signal > MEASURABLE) & np.isfinite(ring.radius)
        common = np.sqrt(np.sum(ring.modes**2, axis=0))
        sections.append(_section(ring.radius - truth.radius, ring.u, common, counts, truth.radius))
    return sections if files else sections[0]


def _section(error, u, common, counts, truth):
    error, u, common = (np.where(counts, values, np.nan) for values in (error, u, common))
    return Section(error, u, common, counts & ~edges(truth))


def edges(radius):
    """Which places (n,) of a wall lie at an edge, or beside what is not seen."""
    kinked = ~(np.abs(radius - 0.5 * (np.roll(radius, REACH) + np.roll(radius, -REACH))) < KINK)
    return np.logical_or.reduce([np.roll(kinked, shift) for shift in range(-BESIDE, BESIDE + 1)])


def ring_rays(rig, wall, seed):
    """The same station, ray by ray."""
    rng = np.random.default_rng([41, seed])
    image, lit, pose = picture(rig, wall, rng)
    truth = true_ring(lit, rig, wall, pipe_from_rig=pose, line=LINE)
    _, u, v = project_ring(rig, RADIUS, 128)
    centre, reach = (np.nanmean(u), np.nanmean(v)), np.hypot(u - np.nanmean(u), v - np.nanmean(v))
    stripe = detect_ring(image, centre, inner=0.7 * np.nanmin(reach), outer=1.4 * np.nanmax(reach), channel="red")
    found = measure(rig, stripe.u, stripe.v, u_pixel=stripe.u_position, direction=stripe.direction, prior_radius=RADIUS)
    true = np.interp(found.clock, truth.clock, np.where(truth.visible, truth.radius, np.nan), period=2 * np.pi)
    counts = stripe.found & np.isfinite(true + found.radius)
    return Rays((found.radius - true)[counts], stripe.u_position[counts], found.clock[counts])


def strip(rig, wall, seed, *files):
    """One picture of a side-facing head, row by row, measured with each of the `files` (none: with the exact one)."""
    rng = np.random.default_rng([43, seed])
    pose = pose_in(rng, rig) @ head_pose(rng.uniform(0, 2 * np.pi))
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=FINE_LINE, psf_sigma=SENSOR.psf_sigma)
    image = photograph(lit, rig, line=FINE_LINE, sensor=SENSOR, rng=rng, speckle_rng=rng)
    truth = true_rows(lit, rig, wall, pipe_from_rig=pose, line=FINE_LINE)
    stripe = detect_line(image, down=True, channel="red")
    sections = []
    for stated in files or (rig,):
        known = stated.with_default_uncertainty(RADIUS)
        found = measure(known, stripe.u, stripe.v, u_pixel=stripe.u_position, direction=stripe.direction)
        counts = truth.visible & (truth.signal > MEASURABLE) & stripe.found
        u, common = found.u_radius_independent, found.u_radius_common
        sections.append(_section(found.radius - truth.radius, u, common, counts, truth.radius))
    if files:
        return sections
    counts = np.isfinite(sections[0].error)
    return Rays(sections[0].error[counts], stripe.u_position[counts], np.zeros(int(counts.sum())))


def head_sections(rig, wall, seed, folder, *, stations=4, clocks=12):
    """Columns of the profile of a side-facing scan, one for each picture."""
    rng = np.random.default_rng([45, seed])
    step, stops = LENGTH / stations, [(n, a) for n in range(stations) for a in range(clocks)]
    origin, turn = rng.uniform(0, step), 2 * np.pi / clocks
    pose = pose_in(rng, rig, 0.0)
    survey = Survey(
        "head",
        rig,
        wall,
        tuple(Station(n, angular=a) for n, a in stops),
        origin,
        step,
        pose,
        line=FINE_LINE,
        sensor=SENSOR,
        angular=(rng.uniform(0, turn), turn),
    )
    simulate_scan(folder / "scan", survey, seed=seed, workers=1)
    profile_scan(folder / "scan", folder / "out", workers=1)
    profile = read_profile(folder / "out")
    with np.load(folder / "scan" / "truth.npz") as truth:
        rows = {name: truth[f"row_{name}"] for name in ("rig_R", "rig_H", "visible", "signal")}
    return [_column(profile, rows, n, origin + n * step, survey.angular[0] + a * turn, a) for n, a in stops]


def _column(profile, rows, station, axial, clock, stop):
    """What the profile says where one picture looked."""
    at = int(np.argmin(np.abs(np.mod(profile.clock - clock + np.pi, 2 * np.pi) - np.pi)))
    seen = rows["visible"][station, stop] & (rows["signal"][station, stop] > MEASURABLE)
    place = axial + rows["rig_H"][station, stop] * INCH
    order = np.argsort(np.where(np.isfinite(place), place, np.inf))[: int(np.isfinite(place).sum())]
    inside = (profile.axial > place[order[0]]) & (profile.axial < place[order[-1]])
    where = profile.axial[inside]
    true = np.interp(where, place[order], rows["rig_R"][station, stop][order] * INCH)
    lit = np.interp(where, place[order], seen[order].astype(float)) == 1
    found, u = profile.radius[inside, at], profile.u_independent[inside, at]
    common = np.sqrt(np.sum(profile.common_mode[:, inside, at] ** 2, axis=0))
    return _section(found - true, u, common, lit & np.isfinite(found), true)


@cache
def beside_fold(name):
    """Which of the clocks of a ring (400,) lie where the rig's line is smoothed, near a fold of its light."""
    rig, clock = instruments()[name], np.arange(400) * (2 * np.pi / 400)
    found = predict_on_wall(rig, clock, RADIUS, u_pixel=USUAL_NOISE)
    return ~(found.margin >= SMOOTHED)
