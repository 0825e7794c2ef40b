"""Random calibrations of every kind, without pictures, and whether what they state is right: for the tests, and for
`python -m benchmarks calibration`.
"""

from typing import NamedTuple

import numpy as np
from calibration_probe_tables import INTERCEPT, SLOPE, found_in, tables
from calibration_pupil_fixtures import PUPIL, fitted, marks
from calibration_rig_cases import CONE, INCH, PLANE, designed, looks_at_gauges, random_head
from calibration_ring_marks import random_case
from known_marks import gauge_look
from scipy import stats
from simulated_boards import SIZE, data_of, held_boards, law_camera, marks_of, truth_of

from calibore.calibration._boards._bundle import bundle
from calibore.calibration._boards._fit import fit_boards
from calibore.calibration._rig._gauges import fit_gauges
from calibore.calibration._rig._range import fit_range
from calibore.calibration._rings._fit import final_fit, fit_all
from calibore.calibration._rings._result import calibrated
from calibore.fitting import region_contains
from calibore.lasers import Plane
from calibore.optics import LENS_LAWS
from calibore.rigs import Laser, Rig, triangulate, value_of

PROBABILITY = 0.95
CLOCKS = np.arange(4) * np.pi / 2 + 0.3


class Outcome(NamedTuple):
    """Whether the 95 % region of the parameters `held` the truth; of what the calibration is for, `errors` (m,) in
    standard uncertainties, each with its `freedom` (m,).
    """

    held: bool
    errors: np.ndarray
    freedom: np.ndarray

    @property
    def scores(self):
        """(m,) The errors as they would be were u known exactly: standard normal where u and freedom are right."""
        return stats.norm.ppf(np.clip(stats.t.cdf(self.errors, self.freedom), 1e-12, 1 - 1e-12))


def rings(seed):
    """On the wall: radii at four clocks, at 0.8 of the outermost ring."""
    case = random_case(np.random.default_rng([12, seed]))
    short, fits = fit_all(case.sight, (case.lens,))
    ring_fit = final_fit(short, fits[case.lens])
    fit, names = ring_fit.fit, calibrated(ring_fit)
    held = region_contains(fit, [case.truth[name] for name in names], names=names)
    plane = Plane(*(case.truth[f"laser.{name}"] for name in Plane.parameter_names))
    true = Rig("perpendicular-plane", case.lens.camera(case.truth, width=1024, height=768), (Laser(plane),))
    x, y = 0.8 * case.radii[-1] * np.array([np.cos(CLOCKS), np.sin(CLOCKS)])
    wall = np.stack([x, y, plane.baseline + plane.tilt_x * x + plane.tilt_y * y], axis=1)
    return Outcome(held, *_on_the_wall(fit, names, ring_fit.model.rig(fit.values, 0), true, true.project(wall)))


def boards(seed):
    """Columns and rows of the image of directions at three zeniths."""
    rng = np.random.default_rng([13, seed])
    camera = law_camera(rng, list(LENS_LAWS)[seed % len(LENS_LAWS)])
    noise = float(np.exp(rng.uniform(np.log(0.02), np.log(0.3))))
    data = data_of(marks_of(camera, held_boards(camera, rng, int(rng.integers(12, 21))), rng, noise=noise))
    truth = truth_of(camera, data)
    found = fit_boards(data, bundle(data, truth, settled=1e-6))
    widest = 0.9 * float(camera.lens.zenith(np.array(min(SIZE) / 2.2)))
    zenith, turn = np.array([0.1, 0.5, 1.0]) * widest, rng.uniform(0, 2 * np.pi, 3)
    points = np.stack([np.sin(zenith) * np.cos(turn), np.sin(zenith) * np.sin(turn), np.cos(zenith)], axis=1)
    seen, names = found.estimate.camera, found.camera_names
    image = seen.project_with_sensitivities(points)
    slopes = image.by_parameters[:, :, [seen.parameter_names.index(name) for name in names]]
    error = np.stack([image.u, image.v], axis=1) - np.stack(camera.project(points), axis=1)
    held = region_contains(found.fit, truth.values, names=names)
    return Outcome(held, *_judged(found.fit, names, slopes.reshape(-1, len(names)), error.ravel()))


def flat(seed, *, stated, rows=48):
    """Ranges of 5, 8 and 11 in, of all stops as they are."""
    rng = np.random.default_rng([14, seed])
    u_range = float(np.exp(rng.uniform(np.log(1e-5), np.log(2e-4))))
    true, design, looks = random_head(rng, stated=stated, u_range=u_range, stops=int(rng.integers(8, 15)), rows=rows)
    found = fit_range(design, looks, known=None)
    ranges = np.array([[0.0, 5.0, 0.0], [0.0, 8.0, 0.0], [0.0, 11.0, 0.0]]) * INCH
    return _of_rig(found, true, true.project(ranges))


def gauges(seed, *, true, marks=160):
    """Radii at the clocks of four marks in a gauge of 240 mm."""
    rng = np.random.default_rng([15, seed])
    found, _ = fit_gauges(designed(true, rng), looks_at_gauges(true, rng, marks=marks))
    at = gauge_look(true, 0.24, rng, name="wall", noise=1e-9, marks=4)
    return _of_rig(found, true, (at.u, at.v), near=0.12)


def pupil(seed, *, bias):
    """The pupil's slide reading, the only parameter calibrated."""
    found = fitted(*marks(np.random.default_rng([16, seed]), bias=bias)).pupil
    error, freedom = np.array([(found.value - PUPIL) / found.u]), np.array([found.degrees_of_freedom])
    return Outcome(bool(abs(error[0]) <= stats.t.ppf((1 + PROBABILITY) / 2, freedom[0])), error, freedom)


def probe(seed):
    """Radii at three ratios of the stroke."""
    rng = np.random.default_rng([17, seed])
    made = tables(
        rng, lengths=int(rng.integers(12, 40)), diameters=int(rng.integers(3, 6)), noise=rng.uniform(0.5e-4, 3e-4)
    )
    found, _, _ = found_in(made)
    error, covariance = np.array([found.slope - SLOPE, found.intercept - INTERCEPT]), found.covariance.matrix
    limit = 2 * stats.f.ppf(PROBABILITY, 2, found.degrees_of_freedom)
    slopes = np.stack([[0.1, 0.35, 0.6], np.ones(3)], axis=1)
    u = np.sqrt(np.einsum("ni,ij,nj->n", slopes, covariance, slopes))
    held = bool(error @ np.linalg.solve(covariance, error) <= limit)
    return Outcome(held, slopes @ error / u, np.full(3, found.degrees_of_freedom))


KINDS = {
    "concentric rings": (rings, {}),
    "boards": (boards, {}),
    "range, u_range stated": (flat, {"stated": True}),
    "range of 24 rows, u_range stated": (flat, {"stated": True, "rows": 24}),
    "range, nothing stated": (flat, {"stated": False}),
    "ring gauges, plane": (gauges, {"true": PLANE}),
    "ring gauges, cone": (gauges, {"true": CONE}),
    "gauges of 64 marks, plane": (gauges, {"true": PLANE, "marks": 64}),
    "gauges of 64 marks, cone": (gauges, {"true": CONE, "marks": 64}),
    "two pins": (pupil, {"bias": 0.02}),
    "two pins, all marks independent": (pupil, {"bias": 0.0}),
    "probe": (probe, {}),
}
"""Function and its arguments after the seed."""


def outcome(kind, seed):
    function, more = KINDS[kind]
    return function(seed, **more)


def _of_rig(found, true, pixels, *, near=None):
    away = [value_of(true, name) - value_of(found.model.rig, name) for name in found.free]
    held = region_contains(found.fit, away, names=found.free)
    return Outcome(held, *_on_the_wall(found.fit, found.free, found.rig, true, pixels, near=near))


def _on_the_wall(fit, names, found, true, pixels, *, near=None):
    """Errors outwards, along the range of a head, of what `found` makes of `pixels`, and their freedom."""
    seen, wall = (triangulate(rig, *pixels, prior_radius=near) for rig in (found, true))
    side = found.configuration == "side-facing"
    outwards = np.array(wall.points) * ([0, 1, 0] if side else [1, 1, 0])
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    slopes = np.einsum("ni,nip->np", outwards, seen.d_parameters)
    columns = [seen.parameter_names.index(name) for name in names]
    return _judged(fit, names, slopes[:, columns], np.sum(outwards * (seen.points - wall.points), axis=1))


def _judged(fit, names, slopes, error):
    """`error` (m,) over its u by `slopes` (m, k), and the degrees of freedom of that."""
    whole = np.zeros((error.size, len(fit.names)))
    whole[:, [fit.names.index(name) for name in names]] = slopes
    u = np.sqrt(np.einsum("ni,ij,nj->n", slopes, _part(fit, names), slopes))
    return error / u, np.array([fit.degrees_of_freedom_of(row) for row in whole])


def _part(fit, names):
    index = [fit.names.index(name) for name in names]
    return fit.covariance[np.ix_(index, index)]
