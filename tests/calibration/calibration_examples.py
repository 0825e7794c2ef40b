"""Calibrations to write and read, made of numbers that mean nothing; run as a script it is killed while it writes."""

import json
import os
import shutil
import signal
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from calibore.calibration import (
    Calibration,
    Comparison,
    InputFile,
    Observations,
    read_calibration,
    write_calibration,
)
from calibore.calibration._evidence import of_fit
from calibore.fitting import Fit, least_squares
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, ValidRegion
from calibore.uncertainty import Covariance, Quantity
from calibore.units import parse_quantity

NAMES = ("laser.baseline", "laser.tilt_x", "camera.k", "camera.principal_point_u")
POSES = ("pose.0.x", "pose.1.x")
CAMERA = Camera(1024, 768, Lens("sine-law", 571.2345678901234, 384.0), (511.3, 384.7))


TRUTH = np.array([0.1534, 1e-3, 571.2, 511.3, 0.2, 0.3])
SCALE = np.array([1e-3, 1e-3, 1.0, 1.0, 1e-3, 1e-3])


@cache
def fitted(seed: int = 1, *, rows: int = 240, tied: bool = True) -> tuple[Fit, Observations]:
    """A fit of two pictures with six groups of neighbours each, two parameters known before, a few outliers."""
    rng = np.random.default_rng(seed)
    a, b = rng.normal(size=(rows, 6)), 0.1 * rng.normal(size=(rows, 6))
    group, load = np.arange(rows) * 12 // rows, rng.uniform(0.5, 1.5, rows)
    noise = rng.normal(0, 0.2, rows)
    if tied:
        noise[1:] += 0.5 * noise[:-1]
        noise += load * rng.normal(0, 0.3, 12)[group]
    noise[::50] += 5.0

    def predicted(values):
        x = (values - TRUTH) / SCALE
        return a @ x + (b @ x) ** 2, (a + 2 * (b @ x)[:, None] * b) / SCALE

    def model(values):
        y, jacobian = predicted(values)
        return noise - y, jacobian

    names = (*NAMES, *POSES)
    known = (["camera.k", "pose.0.x"], TRUTH[[2, 4]], np.diag([0.01**2, 1e-8])) if tied else None
    ties = {"groups": group, "group_loads": load, "chains": group} if tied else {}
    fit = least_squares(
        model, TRUTH + 0.5 * SCALE, names=names, prior=known, robust=True, sigma=0.1 + 0.1 * load, **ties
    )
    u, v = rng.uniform(0, 1023, rows), np.where(rng.random(rows) < 0.1, np.nan, rng.uniform(0, 767, rows))
    return fit, Observations(file=np.arange(rows) * 2 // rows, u=u, v=v, **of_fit(fit))


def calibration(seed: int = 1, *, tied: bool = True, **changes) -> Calibration:
    """A rig with a plane of light, whose baseline tells the seed; neighbouring seeds have other evidence."""
    fit, observed = fitted(1 + seed % 3, tied=tied)
    covariance = Covariance(NAMES, fit.covariance[:4, :4])
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
        group_sigma=fit.group_sigma,
        files=(
            InputFile("gauge 0.png", "a" * 64),
            InputFile('a "b"\\Größe\x7f.png', "b" * 64, "no line was found"),
            InputFile("gauge 1.png", "c" * 64, set_aside="it has room light"),
        ),
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
    fit, observed = fitted(1 + seed % 3)
    observed = replace(observed, names=("probe.slope", "probe.intercept", *"abcd"), unit="m")
    freedom = [float("inf"), 12.5]
    covariance = Covariance(observed.names[:2], fit.covariance[:2, :2], degrees_of_freedom=freedom)
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
    assert np.array_equal(found.covariance.matrix, expected.covariance.matrix)
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
    old, new = calibration(1), calibration(2)
    assert in_child(lambda: write_calibration(old, out)) == 0
    before = out.parent.with_name("before")
    shutil.copytree(out.parent, before)
    total = _changes_of_a_run(lambda: write_calibration(new, out))
    moments = [*range(total - 8, total + 1), *np.random.default_rng(3).choice(total - 9, kills, replace=False)]
    found = set()
    for moment in map(int, moments):

        def killed(moment: int = moment) -> None:
            on_change(lambda seen: seen == moment and os.kill(os.getpid(), signal.SIGKILL))
            write_calibration(new, out)

        shutil.rmtree(out.parent)
        shutil.copytree(before, out.parent)
        assert in_child(killed) == -signal.SIGKILL, moment
        left = in_child(lambda: seed_in(out))
        assert left in (1, 2), (moment, left)
        found.add(left)
    assert found == {1, 2}, "some moments are after the new FILE got its name"


def _changes_of_a_run(action) -> int:
    read, write = os.pipe()

    def counted() -> None:
        total = 0

        def keep(seen: int) -> None:
            nonlocal total
            total = seen

        on_change(keep)
        action()
        os.write(write, json.dumps(total).encode())

    assert in_child(counted) == 0
    return json.loads(os.read(read, 100))


if __name__ == "__main__":
    survive_kills(Path(sys.argv[1]), int(sys.argv[2]))
