"""A tiny scan folder and rings to write; run as a script it writes a result while it is being killed."""

import dataclasses
import json
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from calibore.scans import ResultWriter, RingPoints, RingProfile, open_points, open_profile, read_rings, read_scan
from calibore.status import Status

SCAN = """format = "calibore-scan/1"
name = "tiny pipe"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
[images]
pattern = "tiny {station:03d} {take}.png"
[motion]
axial = { origin = "-1 in", step = "0.1 in" }
"""


def make_scan(folder: Path, text: str = SCAN) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.toml").write_text('format = "calibore-rig/1"\n')
    (folder / "scan.toml").write_text(text)
    return folder


def ring(station: int, *, clocks: int = 8, modes: int = 2, points: int = 12, seed: int = 1, radius: float = 0.15):
    """A random ring whose second clock position and first point are missing."""
    random = np.random.default_rng([seed, station])
    clock = np.arange(clocks) * 2 * np.pi / clocks
    wall = radius + random.normal(0, 1e-4, clocks)
    status = np.zeros(clocks, np.uint8)
    wall[1], status[1] = np.nan, Status.NO_PEAK
    profile = RingProfile(
        station=station,
        axial=0.1 * station,
        clock=clock,
        radius=wall,
        axial_position=0.1 * station + random.normal(0, 1e-3, clocks),
        u_independent=random.uniform(1e-5, 2e-5, clocks),
        common_mode=random.normal(0, 1e-5, (modes, clocks)),
        status=status,
        centre_x=0.001,
        centre_y=-0.002,
        u_centre_x=1e-5,
        u_centre_y=2e-5,
    )
    angle = random.uniform(0, 2 * np.pi, points)
    distance = radius + random.normal(0, 1e-4, points)
    status = np.zeros(points, np.uint8)
    if points:
        distance[0], status[0] = np.nan, Status.MULTIPLE
    axial = 1234.5 + 0.1 * station + random.normal(0, 1e-3, points)
    cloud = RingPoints(
        x=distance * np.sin(angle),
        y=-distance * np.cos(angle),
        z=axial,
        radius=distance,
        clock=angle,
        axial=axial,
        u_radius=random.uniform(1e-5, 2e-5, points),
        u=random.uniform(0, 1024, points),
        v=random.uniform(0, 768, points),
        take=np.arange(points) % 2,
        status=status,
    )
    return profile, cloud


def row(profile: RingProfile) -> dict[str, float | str]:
    return {"mean_diameter": 2 * float(np.nanmean(profile.radius)), "u_mean_diameter": 1e-5 / 3, "flags": "a, b"}


def write(out: Path, scan: Path, *, stations: int = 3, **options) -> None:
    with ResultWriter(out, read_scan(scan)) as writer:
        for station in range(stations):
            profile, points = ring(station, **options)
            writer.add(profile, points, row(profile))
        writer.finish({"seed": options.get("seed", 1), "nothing": float("nan")})


def verify(out: Path, *, stations: int = 3) -> int:
    """The seed of the complete result in `out`, or 0 where there is none; anything else fails."""
    if not out.exists():
        return 0
    seed = json.loads((out / "summary.json").read_text())["seed"]
    expected = [ring(station, seed=seed) for station in range(stations)]
    assert np.array_equal(open_profile(out)["radius"].values, [p.radius for p, _ in expected], equal_nan=True)
    assert np.array_equal(open_points(out)["z"].values, np.concatenate([c.z for _, c in expected]))
    assert read_rings(out)["mean_diameter"].tolist() == [row(p)["mean_diameter"] for p, _ in expected]
    return seed


CHANGES = {"open", "os.mkdir", "os.rename", "os.remove", "os.rmdir"}


def on_change(action) -> None:
    """Call `action` with the number and the paths of each file-system change of this process, before it is made."""
    seen = 0

    def hook(name: str, arguments: tuple) -> None:
        nonlocal seen
        if name in CHANGES and not (name == "open" and arguments[1] in (None, "r")):
            seen += 1
            action(seen, [str(argument) for argument in arguments[:2]])

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


def survive_kills(out: Path, scan: Path, kills: int) -> None:
    """Kill runs that replace an earlier result at many changes of the disk; look at what is there, run again."""
    _import_before_forking(scan)
    assert in_child(lambda: write(out, scan, seed=1)) == 0
    moments, old, absent = _moments(out, scan, kills), 1, 0
    for new, moment in enumerate(moments, start=2):

        def killed(moment: int = moment, new: int = new) -> None:
            on_change(lambda seen, paths: seen == moment and os.kill(os.getpid(), signal.SIGKILL))
            write(out, scan, seed=new)

        assert in_child(killed) == -signal.SIGKILL, moment
        left = in_child(lambda: verify(out))
        assert left in (0, old, new), (moment, left)
        absent += left == 0
        old, before = in_child(lambda: abandon(out, scan)), old
        assert old in (before, new), (moment, old)
        assert {path.name for path in out.parent.iterdir()} == {out.name, scan.name}
    assert absent == 1, "one of the moments is between the two renames"
    assert in_child(lambda: write(out, scan, seed=99)) == 0
    assert in_child(lambda: verify(out)) == 99
    assert {path.name for path in out.parent.iterdir()} == {out.name, scan.name}


def _moments(out: Path, scan: Path, kills: int) -> list[int]:
    """Every change around the final renames, and others at random."""
    read, write_end = os.pipe()

    def counted() -> None:
        renames, total = [], 0

        def keep(seen: int, paths: list[str]) -> None:
            nonlocal total
            total = seen
            if str(out) in paths:
                renames.append(seen)

        on_change(keep)
        write(out, scan, seed=1)
        os.write(write_end, json.dumps([total, renames]).encode())

    assert in_child(counted) == 0
    total, renames = json.loads(os.read(read, 10000))
    assert len(renames) == 2, renames
    near = set(range(renames[0] - 1, renames[1] + 4))
    elsewhere = sorted(set(range(1, total + 1)) - near)
    return [*sorted(near), *np.random.default_rng(7).choice(elsewhere, kills - len(near), replace=False).tolist()]


def survive_random_kills(out: Path, scan: Path, kills: int) -> None:
    """Kill runs after random times; nothing but a complete result is ever found, and the next run works."""
    _import_before_forking(scan)
    random = np.random.default_rng(8)
    for seed in range(1, kills + 1):
        child = os.fork()
        if child == 0:
            while True:
                write(out, scan, seed=seed)
        time.sleep(random.uniform(0.0, 0.3))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        assert in_child(lambda: verify(out)) <= seed
    assert in_child(lambda: write(out, scan, seed=99)) == 0
    assert in_child(lambda: verify(out)) == 99
    assert {path.name for path in out.parent.iterdir()} == {out.name, scan.name}


def _import_before_forking(scan: Path) -> None:
    """Everything but zarr's own thread, which must not exist in a process that forks."""
    import xarray
    import zarr  # noqa: F401

    xarray.backends.list_engines()
    read_scan(scan)


def abandon(out: Path, scan: Path, _: int = 0) -> int:
    """A run that starts and writes nothing: what an earlier, killed one left is put in order."""
    with ResultWriter(out, read_scan(scan)):
        pass
    return verify(out)


def write_with_small_files(out: Path, scan: Path, limit: int) -> None:
    """Under a file size limit, which fails like a full disk."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    write(out, scan, stations=40, clocks=400)


def print_peak_memory(out: Path, scan: Path, stations: int) -> None:
    """The peak memory of this process after 50 stations of 400 clock positions, and after `stations`, bytes."""
    import resource

    (profile, points), peaks = ring(0, clocks=400, modes=2, points=1400), []
    for count in (50, stations):
        with ResultWriter(out, read_scan(scan)) as writer:
            for station in range(count):
                writer.add(dataclasses.replace(profile, station=station), points, {"station": station})
            writer.finish({})
        peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024))
    print(json.dumps(peaks))


if __name__ == "__main__":
    globals()[sys.argv[1]](Path(sys.argv[2]), Path(sys.argv[3]), int(sys.argv[4]))
