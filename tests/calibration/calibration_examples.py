"""Calibrations to write and read, made of numbers that mean nothing; run as a script it is killed while it writes."""

import json
import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibore.calibration import (
    Calibration,
    Comparison,
    InputFile,
    Observations,
    read_calibration,
    recomputed_covariance,
    write_calibration,
)
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, ValidRegion
from calibore.uncertainty import Covariance, Quantity
from calibore.units import parse_quantity

NAMES = ("laser.baseline", "laser.tilt_x", "camera.k", "camera.principal_point_u")
POSES = ("pose.0.x", "pose.1.x")
CAMERA = Camera(1024, 768, Lens("sine-law", 571.2345678901234, 384.0), (511.3, 384.7))


def observations(seed: int = 1, *, rows: int = 60, group_sigma: float = 0.3, white: bool = True) -> Observations:
    """Of two pictures with three groups each; a tenth of the residuals is left out."""
    rng = np.random.default_rng(seed)
    scale = np.array([2e3, 800.0, 0.4, 1.0, 900.0, 900.0])
    jacobian = rng.normal(size=(rows, 6)) * scale
    observed = Observations(
        file=np.arange(rows) * 2 // rows,
        u=rng.uniform(0, 1023, rows),
        v=np.where(rng.random(rows) < 0.1, np.nan, rng.uniform(0, 767, rows)),
        residual=rng.normal(0, 0.2, rows),
        sigma=rng.uniform(0.1, 0.3, rows),
        weight=(rng.random(rows) > 0.1).astype(float),
        group=np.arange(rows) * 6 // rows,
        jacobian=jacobian,
        names=(*NAMES, *POSES),
    )
    return observed if white else replace(observed, whitened=rng.normal(size=(rows + 2, 6)) * scale)


def covariance_of(observed: Observations, group_sigma: float) -> np.ndarray:
    """By the textbook: (J' V^-1 J)^-1 with V written out."""
    if observed.whitened is not None:
        return np.linalg.inv(observed.whitened.T @ observed.whitened)
    used = observed.weight > 0
    same = observed.group[used][:, None] == observed.group[used]
    v = np.diag(observed.sigma[used] ** 2) + group_sigma**2 * same
    j = observed.jacobian[used]
    return np.linalg.inv(j.T @ np.linalg.solve(v, j))


def calibration(seed: int = 1, *, group_sigma: float = 0.3, white: bool = True, **changes) -> Calibration:
    """A rig with a plane of light."""
    observed = observations(seed, white=white)
    covariance = Covariance(NAMES, covariance_of(observed, group_sigma)[:4, :4])
    values = dict(zip(NAMES, (0.15239999999999998 + 1e-3 * seed, 1e-3, CAMERA.lens.k, 511.3), strict=True))
    surface = Plane(values["laser.baseline"], 1e-3)
    valid = ValidRegion((0.1, 1.1), (0.1, 0.30480001))
    rig = Rig("perpendicular-plane", CAMERA, (Laser(surface, "red"),), covariance, valid=valid, degrees_of_freedom=41.5)
    found = Calibration(
        kind="ring-gauge",
        rig=rig,
        camera=CAMERA,
        values=values,
        covariance=covariance,
        degrees_of_freedom=41.5,
        noise=0.21,
        group_sigma=group_sigma,
        files=(InputFile("gauge 0.png", "a" * 64), InputFile('a "b"\\Größe\x7f.png', "b" * 64, "no line was found")),
        observations=observed,
        valid=valid,
        models=(
            Comparison("sine-law", 4, 0.2, 0.0, 0.0, 0.21, {"camera.k": Quantity(571.2, 0.3, 12.0)}),
            Comparison("perspective", 4, 0.9, 1234.5, 1230.0, float("nan"), {}, "misfits"),
        ),
        settings={"target": {"diameter": 0.3048, "stops": [1, 2, 3], "name": "gauge 7"}},
        findings=("Use the sine law.",),
        warnings=("Mind the gap.",),
    )
    return replace(found, **changes)


def lens(seed: int = 1) -> Calibration:
    """A camera without a laser."""
    found = calibration(seed)
    names = NAMES[2:]
    values = {name: found.values[name] for name in names}
    covariance = found.covariance.restricted(names)
    return replace(found, kind="chessboard", rig=None, values=values, covariance=covariance, settings={})


def probe(seed: int = 1) -> Calibration:
    """Neither camera nor laser."""
    observed = replace(observations(seed), names=("probe.slope", "probe.intercept", *"abcd"), unit="m")
    covariance = Covariance(observed.names[:2], covariance_of(observed, 0.3)[:2, :2])
    return replace(
        calibration(seed),
        kind="probe",
        rig=None,
        camera=None,
        values={"probe.slope": 0.1, "probe.intercept": -0.01},
        covariance=covariance,
        observations=observed,
        valid=None,
        settings={"probe": {"slope": "0.1 m", "intercept": "-0.01 m", "tip_radius": "1.5875 mm"}},
    )


def seed_in(out: Path) -> int:
    """Which calibration is whole in `out`, 0 where there is none; anything else fails."""
    if not out.exists():
        return 0
    found = read_calibration(out)
    seed = round((found.values["laser.baseline"] - 0.15239999999999998) / 1e-3)
    expected = calibration(seed)
    assert np.array_equal(found.observations.jacobian, expected.observations.jacobian)
    assert np.allclose(recomputed_covariance(out).matrix, expected.covariance.matrix, rtol=1e-6)
    return seed


CHANGES = {"open", "os.mkdir", "os.rename", "os.remove", "os.rmdir"}


def on_change(action) -> None:
    """Call `action` with the number of each file-system change of this process, before it is made."""
    seen = 0

    def hook(name: str, arguments: tuple) -> None:
        nonlocal seen
        if name in CHANGES and not (name == "open" and arguments[1] in (None, "r")):
            seen += 1
            action(seen)

    sys.addaudithook(hook)


def in_child(action) -> int:
    """`action` in a forked process (no imports to wait for): its result 0..200, or minus the signal that killed it."""
    child = os.fork()
    if child == 0:
        try:
            os._exit(action() or 0)
        except BaseException as error:
            print(f"child failed: {error!r}", flush=True)
            os._exit(255)
    _, status = os.waitpid(child, 0)
    return -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def survive_kills(out: Path, kills: int) -> None:
    """Kill runs that replace an earlier FILE at many changes of the disk; look at what is there."""
    import xarray.backends.zarr  # noqa: F401
    import zarr.codecs  # noqa: F401

    parse_quantity("1 m", "length")
    assert in_child(lambda: write_calibration(calibration(1), out)) == 0
    total = _changes_of_a_run(out)
    moments = [*range(total - 9, total + 1), *np.random.default_rng(3).choice(total - 10, kills, replace=False)]
    assert in_child(lambda: write_calibration(calibration(1), out)) == 0
    old, found = 1, set()
    for new, moment in enumerate(map(int, moments), start=2):

        def killed(moment: int = moment, new: int = new) -> None:
            on_change(lambda seen: seen == moment and os.kill(os.getpid(), signal.SIGKILL))
            write_calibration(calibration(new), out)

        assert in_child(killed) == -signal.SIGKILL, moment
        left = in_child(lambda: seed_in(out))
        assert left in (old, new), (moment, left)
        found.add(left == new)
        old = left
    assert found == {True, False}, "some moments are after the new FILE got its name"


def _changes_of_a_run(out: Path) -> int:
    read, write = os.pipe()

    def counted() -> None:
        total = 0

        def keep(seen: int) -> None:
            nonlocal total
            total = seen

        on_change(keep)
        write_calibration(calibration(2), out)
        os.write(write, json.dumps(total).encode())

    assert in_child(counted) == 0
    return json.loads(os.read(read, 100))


if __name__ == "__main__":
    survive_kills(Path(sys.argv[1]), int(sys.argv[2]))
