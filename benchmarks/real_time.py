"""Does it keep up with a film? Radii with uncertainty per second on two workers, decoding included.

A film of a simulated pipe (H.264 and MJPEG, as `calibore simulate` writes them) and a native archive of the same
pictures are measured with everything that `calibore profile` measures; the rate of decoding alone stands beside it.
Ten times the densest known system is 10 x 1,080 radii x 30 pictures = 324,000 radii per second.
"""

import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibore.geometry import Pose
from calibore.images import ImageSource
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import Tally, archive_scan, measure_scan, prepare, profile_scan
from calibore.rigs import Laser, Rig, write_rig
from calibore.scans import read_scan
from calibore.simulation import Film, demo_rig, demo_wall, render_ring
from calibore.status import has_value

TARGET = 10 * 1080 * 30
SIZES = ((640, 480), (1024, 768))
DISTINCT = 16
"""Pictures that are rendered; a film shows them there and back again."""
STEP = 0.002
"""m between pictures: 60 mm/s at 30 pictures a second."""
SCAN = """format = "calibore-scan/1"
name = "real time"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
[images]
{images}
[motion]
axial = {{ origin = "0 m", step = "2 mm" }}
"""


def report(seconds: float = 10.0, workers: int = 2) -> list[str]:
    """Markdown lines; `seconds` of film at 30 pictures a second."""
    lines = [
        f"## Real time: {workers} workers, target {TARGET:,} radii with uncertainty per second",
        "| source | decoding alone, pictures/s | measured, pictures/s | radii/s | of the target | the same written, "
        "radii/s | processor ms per picture |",
        "|---|---|---|---|---|---|---|",
    ]
    for width, height in SIZES:
        with tempfile.TemporaryDirectory() as folder:
            scans = _made(Path(folder), _pictures(width, height), round(30 * seconds))
            for name, scan in scans.items():
                lines.append(_row(f"{name}, {width} x {height}", scan, workers))
    return lines


def _rig(width: int, height: int) -> Rig:
    """The demonstration's, its image as large as the camera; the line is looked for in luma."""
    camera = Camera(width, height, Lens("sine-law", 571.0 * height / 768, height / 2), (width / 2, height / 2))
    return replace(demo_rig(), camera=camera, lasers=(Laser(Plane(0.3327), None),))


def _pictures(width: int, height: int) -> list[np.ndarray]:
    """(h, w, 3) each."""
    rig, wall, rng = _rig(width, height), demo_wall(), np.random.default_rng(4)
    start = Pose.from_roll_pitch_yaw(0.026, 0.002, -0.003, translation=(0.004, 0.002, 0.0))
    poses = [start @ Pose.from_roll_pitch_yaw(translation=(0.0, 0.0, STEP * n)) for n in range(DISTINCT)]
    lit = replace(rig, lasers=(Laser(rig.lasers[0].surface, "red"),))
    return [render_ring(lit, wall, pipe_from_rig=pose, rng=rng) for pose in poses]


def _made(folder: Path, pictures: list[np.ndarray], count: int) -> dict[str, Path]:
    """Scan folders with `count` pictures each."""
    from PIL import Image

    there_and_back = [*range(DISTINCT), *range(DISTINCT - 2, 0, -1)]
    order = [there_and_back[n % len(there_and_back)] for n in range(count)]
    shape = pictures[0].shape
    scans = {name: folder / name for name in ("H.264", "MJPEG", "pictures", "archive")}
    for name, codec in (("H.264", "h264"), ("MJPEG", "mjpeg")):
        film = Film(codec, rate=30, quality=20 if codec == "h264" else 3)
        _scan(scans[name], shape, f'video = "film.{film.suffix}"')
        with film.album(scans[name], "film", shape[:2]) as add:
            for n in order:
                add("", film.prepared(pictures[n]))
    _scan(scans["pictures"], shape, 'pattern = "{station:04d} {take}.png"')
    for n, picture in enumerate(order):
        Image.fromarray(pictures[picture]).convert("L").save(scans["pictures"] / f"{n:04d} 0.png", compress_level=1)
    archive_scan(scans["pictures"], scans["archive"])
    del scans["pictures"]
    return {"H.264": scans["H.264"], "MJPEG": scans["MJPEG"], "native archive": scans["archive"]}


def _scan(folder: Path, shape: tuple[int, ...], images: str) -> None:
    folder.mkdir()
    (folder / "scan.toml").write_text(SCAN.format(images=images))
    write_rig(_rig(shape[1], shape[0]), folder / "rig.toml")


def _row(name: str, scan: Path, workers: int) -> str:
    job, source, place = prepare(read_scan(scan), estimator="zero-crossing")
    decoded, _, pictures = _timed(lambda: _decoded(source))

    def measured() -> Iterator[int]:
        for result in measure_scan(job, source, place, workers=workers, tally=Tally()):
            points = result.points
            yield int(np.count_nonzero(np.isfinite(points.u_radius) & has_value(points.status)))

    wall, processor, radii = _timed(measured)
    with tempfile.TemporaryDirectory() as out:
        written, _, _ = _timed(lambda: iter([len(profile_scan(scan, Path(out) / "out", workers=workers))]))
    rates = f"{pictures / decoded:.0f} | {pictures / wall:.0f} | {radii / wall:,.0f} | {radii / wall / TARGET:.2f}"
    return f"| {name} | {rates} | {radii / written:,.0f} | {1e3 * processor / pictures:.2f} |"


def _decoded(source: ImageSource) -> Iterator[int]:
    for station in source.stations():
        for take in station.takes:
            yield int(station.read(take).ndim > 0)


def _timed(counts: Callable[[], Iterator[int]]) -> tuple[float, float, int]:
    """Seconds of wall clock and of processor, and the sum of what is counted."""
    start, busy = time.perf_counter(), time.process_time()
    total = sum(counts())
    return time.perf_counter() - start, time.process_time() - busy, total
