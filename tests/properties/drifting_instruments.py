"""The six instruments, moved since they were calibrated: for the tests, and `python -m benchmarks prediction`."""

import numpy as np
from known_instruments import FIRST_ORDER, RADIUS, ring_section, strip

from calibore.design import scan_direction
from calibore.rigs import SideFacing, lit_points, margin, measure, moved, read_rig, triangulate, write_rig
from calibore.simulation import PipeWall

DRIFT = 'baseline = "{baseline} m"\nk = {k}\n'
SHARES = 0.0015, 0.005
"""Of baseline and k: how far they drift, as between the calibrations of Tables 8.1 and 8.2."""
ANGLES = {
    "perpendicular-plane": "",
    "single-cone": 'aim = "0.1 deg"\nhalf_angle = "0.1 deg"\n',
    "side-facing": 'aim = "0.1 deg"\n',
}


def drifting(rig, folder):
    """(as its file states it without drift, with drift): the same rig, known exactly when it was calibrated."""
    write_rig(rig, folder / "rig.toml")
    text, (baseline, k) = (folder / "rig.toml").read_text(), SHARES
    whole = rig.mount.baseline if isinstance(rig.mount, SideFacing) else rig.lasers[0].surface.baseline
    drift = DRIFT.format(baseline=baseline * whole, k=k * rig.camera.lens.k) + ANGLES[rig.configuration]
    exact = "\n[uncertainty]\n" + "".join(f"{line.partition('=')[0]}= {_zero(line)}\n" for line in drift.splitlines())
    (folder / "exact.toml").write_text(text + exact)
    (folder / "drift.toml").write_text(text + exact + "\n[drift]\n" + drift)
    return read_rig(folder / "exact.toml"), read_rig(folder / "drift.toml")


def _zero(line):
    return '"0 deg"' if "deg" in line else '"0 m"' if " m" in line else "0.0"


def true_rigs(drift, count, seed):
    """`count` (a power of 2) rigs that have moved as far as `drift` says, spread evenly over its distribution (Sobol'),
    so that few of them stand for all.
    """
    from scipy.special import ndtri
    from scipy.stats.qmc import Sobol

    names = [name for name, u in zip(drift.covariance.names, drift.covariance.u, strict=True) if u > 0]
    scores = ndtri(Sobol(len(names), seed=seed).random(count))
    changes = scores @ drift.covariance.restricted(names).factor().T
    return [moved(drift, dict(zip(names, change, strict=True))).knowing(None) for change in changes.tolist()]


def drifted_section(true, exact, drift, seed):
    """One station in a plain pipe of the rig `true`, measured with the files `exact` and `drift`: (error, u without
    drift, u with drift) (n,) [m].
    """
    seen = strip if isinstance(true.mount, SideFacing) else ring_section
    before, after = seen(true, PipeWall(RADIUS), seed, exact, drift)
    return after.error, np.hypot(before.u, before.common), np.hypot(after.u, after.common)


def drifted_points(true, drift, rng, *, points, u_pixel):
    """The same without a picture: (error, u with drift) (points,) [m] where the line is found with `u_pixel`."""
    along = np.zeros(points)
    if isinstance(drift.mount, SideFacing):
        clock, along = np.zeros(points), rng.uniform(-0.015, 0.015, points)
    else:
        clock = rng.uniform(0, 2 * np.pi, points)
    u, v = true.project(lit_points(true, clock, RADIUS, axial=along))
    direction = scan_direction(drift, u, v)
    u, v = np.stack([u, v]) + u_pixel * rng.standard_normal(points) * direction.T
    found = measure(drift, u, v, u_pixel=u_pixel, direction=direction, prior_radius=RADIUS)
    counts = drift_margin(drift, u, v, direction, u_pixel) >= FIRST_ORDER
    return (np.where(counts, values, np.nan) for values in (found.radius - RADIUS, found.u_radius))


def drift_margin(rig, u, v, direction, u_pixel):
    """How far first order carries, of points on the nominal wall."""
    branch = triangulate(rig, u, v, prior_radius=RADIUS).branch
    return margin(rig, u, v, branch=branch, u_pixel=u_pixel, direction=direction)
