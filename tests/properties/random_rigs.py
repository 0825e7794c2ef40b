"""One simulated picture of a random pipe by a random rig: for the tests, and for `python -m benchmarks coverage`."""

import numpy as np

from calibore.profiling import Job, measure_image
from calibore.simulation import (
    LineLight,
    Sensor,
    draw_rig,
    lit_line,
    photograph,
    random_pose,
    random_rig,
    random_wall,
    true_ring,
)


def one_ring(seed, *, exact, features):
    """(ring, truth, nominal radius) of one simulated picture; the rig file is `exact` or a little wrong."""
    rng = np.random.default_rng([7, seed])
    wall = random_wall(rng, features=features)
    stated = random_rig(rng, wall.nominal_radius)
    rig = stated if exact else draw_rig(stated, rng)
    pose = random_pose(rng, stated, wall.nominal_radius)
    line = LineLight(sigma=wall.nominal_radius * rng.uniform(0.002, 0.006))
    sensor = Sensor(speckle_contrast=rng.uniform(0, 0.5), psf_sigma=rng.uniform(0.8, 1.5))
    lit = lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=sensor.psf_sigma)
    image = photograph(lit, rig, line=line, sensor=sensor, rng=rng, speckle_rng=rng)
    truth = true_ring(lit, rig, wall, pipe_from_rig=pose, line=line)
    ring = measure_image(image, Job.of(stated, wall.nominal_radius))
    return ring, truth, wall.nominal_radius
