"""False alarms on unchanged pipes, from pictures: `python -m benchmarks change_pictures [pairs [first]]`.

Two surveys of one rough pipe with features, each by a rig drawn from what the rig file states, placed anew, its
odometry begun elsewhere, in other light and noise: simulated, profiled and compared as the commands do. Pictures have
half the size of the demonstration's, so that a pair takes seconds.
"""

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibore.comparison import Compared, compared
from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.profiling import profile_scan
from calibore.rigs import Rig
from calibore.scans import read_profile
from calibore.simulation import (
    Dent,
    Harmonic,
    LateralOpening,
    Ovality,
    PipeWall,
    Rail,
    Roughness,
    Station,
    Survey,
    demo_rig,
    draw_rig,
    simulate_scan,
)
from calibore.uncertainty import Covariance

RADIUS = 6 * 0.0254
BASELINE = 13.1 * 0.0254
STATIONS, STEP = 6, 0.012
SMALLER = 0.625
FALSE_ALARM = 0.05


def report(pairs: str = "100", first: str = "0") -> list[str]:
    """Markdown lines: how many pairs raised an alarm, and what was found there."""
    seeds = range(int(first), int(first) + int(pairs))
    every = [_compared(seed) for seed in seeds]
    found = dict(zip(seeds, every, strict=True))
    alarms = {seed: one.changes.regions for seed, one in found.items() if one.changes and one.changes.regions}
    low, high = (f"{100 * limit:.1f}" for limit in _interval(len(alarms), len(every)))
    inside = np.concatenate([(np.abs(one.value) / one.u)[np.isfinite(one.value)] for one in every]) <= 1.96
    levels = [1e3 * np.nanmedian(one.changes.level_of_detection) for one in every if one.changes]
    lines = [f"## {pairs} unchanged pairs of surveys in pictures, stated false alarm {100 * FALSE_ALARM:g} %", ""]
    lines += [
        f"- alarms: {len(alarms)} of {len(every)}; 95 % interval of their probability {low} ... {high} %",
        f"- points within 1.96 u: {100 * inside.mean():.1f} % of {inside.size}",
        f"- noise over what profiles state: {np.median([one.registration.scatter for one in every]):.2f}",
        f"- level of detection, median: {np.median(levels):.2f} mm",
    ]
    for seed, regions in alarms.items():
        for one in regions:
            ring, position = (int(places[0]) for places in np.nonzero(one.cells))
            missed = 1e3 * float(found[seed].difference.missed[ring, position])
            peak = float(np.max(np.abs(found[seed].normalised[one.cells])))
            lines.append(
                f"- alarm in pair {seed}: {one.points} points, {np.degrees(one.clock.value):.0f} deg, ring {ring}, "
                f"{1e3 * one.mean.value:.2f} mm, {peak:.1f} u; between points {missed:.2f} mm may be missed"
            )
    return lines


def _compared(seed: int) -> Compared:
    rng = np.random.default_rng([41, seed])
    wall, stated = random_wall(rng), smaller_rig()
    with tempfile.TemporaryDirectory() as folder:
        profiles = []
        for epoch in range(2):
            scan, out = Path(folder) / f"scan-{epoch}", Path(folder) / f"profile-{epoch}"
            simulate_scan(scan, survey(wall, stated, rng), seed=2 * seed + epoch, workers=1)
            profile_scan(scan, out, workers=1)
            profiles.append(read_profile(out))
    return compared(profiles[1], profiles[0], epochs=True, names=("later", "earlier"), false_alarm=FALSE_ALARM)


def survey(wall: PipeWall, stated: Rig, rng: np.random.Generator) -> Survey:
    """Of `wall`, by a rig as it may be, from where it happens to stand."""
    roll, tilt, shift = rng.uniform(-0.03, 0.03), rng.normal(0, 0.002, 2), rng.uniform(-0.01, 0.01, 2) * RADIUS
    return Survey(
        name="unchanged",
        rig=draw_rig(stated, rng),
        wall=wall,
        stations=tuple(Station(number) for number in range(STATIONS)),
        origin=-BASELINE + STEP * rng.uniform(-0.5, 0.5),
        step=STEP,
        pose=Pose.from_roll_pitch_yaw(roll, *tilt.tolist(), translation=(*shift.tolist(), 0.0)),
        stated=stated,
    )


def random_wall(rng: np.random.Generator) -> PipeWall:
    """A rough 12 in pipe, oval, with a dent, a lateral and a low rail on its invert."""
    length = STATIONS * STEP
    return PipeWall(
        RADIUS,
        (
            Ovality((rng.uniform(0.2, 1), rng.uniform(0.2, 1)), axial=(0.0, length), axis=rng.uniform(0, np.pi)),
            Harmonic(3, RADIUS * rng.uniform(0, 2e-3), rng.uniform(0, 2 * np.pi)),
            Dent(rng.uniform(0.003, 0.01), rng.uniform(4, 6), rng.uniform(0, length), rng.uniform(0.1, 0.2), 0.04),
            LateralOpening(0.05, 0.015, rng.uniform(1, 2), rng.uniform(0, length), edge=0.02),
            Roughness(4e-5, 0.003, int(rng.integers(2**31))),
            Rail(0.005, 0.025, edge=0.003),
        ),
    )


def smaller_rig() -> Rig:
    """The demonstration's, with fewer and wider pixels, known as well."""
    rig, camera = demo_rig(), demo_rig().camera
    lens = Lens("sine-law", SMALLER * 571.0, SMALLER * 384.0)
    u, v = camera.principal_point
    camera = Camera(int(SMALLER * camera.width), int(SMALLER * camera.height), lens, (SMALLER * u, SMALLER * v))
    pixels = dict.fromkeys(("camera.k", "camera.principal_point_u", "camera.principal_point_v"), SMALLER * 0.3)
    stated = Covariance.independent(pixels | {"laser.baseline": 0.006 * 0.0254})
    return replace(rig, camera=camera, covariance=stated)


def _interval(alarms: int, pairs: int) -> tuple[float, float]:
    """Clopper and Pearson's (1934)."""
    from scipy.stats import beta

    low = float(beta.ppf(0.025, alarms, pairs - alarms + 1)) if alarms else 0.0
    return low, float(beta.ppf(0.975, alarms + 1, pairs - alarms)) if alarms < pairs else 1.0
