"""The tactile scan that chapter 8 takes as reference: simulated, its probe calibrated, profiled."""

from functools import partial
from pathlib import Path

import numpy as np

from calibore.calibration import calibrate, write_calibration
from calibore.experiment._outcome import Judgement
from calibore.experiment._pipe import experimental_pipe
from calibore.experiment._plan import Plan
from calibore.experiment._published import INCH, PROBE
from calibore.experiment._workshop import Workshop
from calibore.profiling import profile_scan
from calibore.rigs import Probe
from calibore.scans import Profile
from calibore.simulation import Shank, Sticking, TactileSurvey, simulate_tactile
from calibore.status import Status
from calibore.uncertainty import Covariance

NAME = "tactile"
TIP = 0.0625 * INCH
LENGTH = 9.9 * INCH
"""From the first ring to the last."""
STROKE = (0.02, 0.48)
NOISE = 0.0005 * INCH
"""Of a reading: our assumption."""
DRIFT = 0.001 * INCH / 3**0.5
"""Standard uncertainty: the cylinder's stated repeatability as limits."""
STEPS = 3


def touch(workshop: Workshop) -> None:
    """Makes scan, probe file and profile."""
    scan, probe = workshop.out / "scans" / NAME, workshop.out / "calibrations" / "probe.toml"
    workshop.made(scan, lambda out: simulate_tactile(out, survey_of(workshop.plan), seed=100 * workshop.plan.seed + 99))
    workshop.made(probe, partial(_calibrated, scan))
    workshop.made(profile_of(workshop), lambda out: profile_scan(scan, out, probe=probe))


def profile_of(workshop: Workshop) -> Path:
    return workshop.out / "profiles" / NAME


def survey_of(plan: Plan) -> TactileSurvey:
    """The probe of section 8.2 in the pipe; it drifts, sticks beside edges, and its shank touches where it is steep."""
    rings, stops = plan.touched
    slope, intercept = (length * INCH for length in PROBE)
    known = Covariance.independent({"probe.slope": 0.0, "probe.intercept": 0.0})
    return TactileSurvey(
        name="test pipe, tactile",
        wall=experimental_pipe(),
        probe=Probe(slope, intercept, known, noise=NOISE, stroke=STROKE),
        tip_radius=TIP,
        stations=rings,
        origin=0.0,
        step=LENGTH / max(rings - 1, 1),
        stops=stops,
        drift=DRIFT / 2,
        stated_drift=DRIFT,
        sticking=Sticking(),
        shank=Shank(0.05 * INCH, 0.3 * INCH),
    )


def _calibrated(scan: Path, place: Path) -> None:
    write_calibration(calibrate("probe", scan), place)


def judged_touch(workshop: Workshop, touched: Profile) -> Judgement:
    """The tactile profile against the true wall, stuck and off-tip readings that it flags left out."""
    with np.load(workshop.out / "scans" / NAME / "truth.npz") as truth:
        true = truth["R_geometric"] * INCH
        row = np.argmin(np.abs(truth["H"] * INCH - touched.axial[:, None]), axis=1)
    radius = np.where(touched.status == Status.OK, touched.radius, np.nan)
    u = np.hypot(touched.u_independent, touched.u_common)
    return Judgement.of(true[row].ravel(), (radius - true[row]).ravel(), u.ravel())
