"""A small pipe photographed a dozen times, as picture files and as a film, and the runs that measure it live."""

import os
import socket
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import av
import numpy as np
from PIL import Image

from calibore.acquisition import Limits, Vitals, Wanted, described, live_scan
from calibore.geometry import Pose
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, write_rig
from calibore.simulation import LineLight, Ovality, PipeWall, Sensor, lit_line, photograph
from calibore.uncertainty import Covariance

INCH = 0.0254
SIZE = (320, 240)
PICTURES = 12
PATTERN = "ring {station:03d} {take}.png"
HERE = Path(__file__).parent
SCAN = """format = "calibore-scan/1"
name = "live pipe"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
[images]
{images}
[motion]
axial = {{ origin = "0 mm", step = "50 mm" }}
"""


def rig_of(size: tuple[int, int] = SIZE) -> Rig:
    camera = Camera(*size, Lens("sine-law", 0.6 * size[0], size[1] / 2), (size[0] / 2, size[1] / 2))
    stated = Covariance.independent({"laser.baseline": 0.006 * INCH, "camera.k": 0.1})
    return Rig("perpendicular-plane", camera, (Laser(Plane(13.1 * INCH)),), covariance=stated)


def photographs(count: int = PICTURES, size: tuple[int, int] = SIZE) -> list[np.ndarray]:
    """What a rig sees that moves through an oval pipe."""
    rig, wall = rig_of(size), PipeWall(6 * INCH, (Ovality((1.0, 1.0), axial=(0.0, 1.0), axis=0.7),))
    line, found = LineLight(colour=(1.0, 1.0, 1.0)), []
    for n in range(count):
        pose = Pose.from_roll_pitch_yaw(0.0, 0.001, -0.002, translation=(0.002, -0.001, 0.05 * n))
        lit = lit_line(rig, wall, pipe_from_rig=pose, line=line, psf_sigma=Sensor().psf_sigma)
        rng, speckle = np.random.default_rng([1, n]), np.random.default_rng([2, n])
        found.append(photograph(lit, rig, line=line, sensor=Sensor(), rng=rng, speckle_rng=speckle))
    return found


def write_film(path: Path, frames: list[np.ndarray]) -> Path:
    """H.264 as a camera sends it: no picture waits for a later one, a key frame every five pictures."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=25)
        stream.height, stream.width = frames[0].shape[:2]
        stream.pix_fmt = "yuv420p"
        stream.options = {"tune": "zerolatency", "crf": "14", "g": "5", "x264-params": "keyint=5:scenecut=0"}
        for number, image in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24").reformat(format="yuv420p")
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def write_scan(folder: Path, images: str, size: tuple[int, int] = SIZE) -> Path:
    """scan.toml and rig.toml of pictures that are named by `images`."""
    folder.mkdir(exist_ok=True)
    write_rig(rig_of(size), folder / "rig.toml")
    (folder / "scan.toml").write_text(SCAN.format(images=images), encoding="utf-8")
    return folder


def write_picture(path: Path, image: np.ndarray) -> None:
    Image.fromarray(image).save(path)


@dataclass
class Record:
    """Watches a run and keeps what it saw; `each` is called with the vitals after every ring."""

    each: Callable[[Vitals], None] = lambda vitals: None
    rows: list[dict] = field(default_factory=list)
    latencies: list[float] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)
    beats: int = 0

    def ring(self, vitals: Vitals) -> None:
        self.rows.append(dict(vitals.row or {}))
        self.latencies.append(vitals.latency)
        self.each(vitals)

    def beat(self, vitals: Vitals) -> None:
        self.beats += 1

    def say(self, sentence: str) -> None:
        self.sentences.append(sentence)


def run(wanted: Wanted, out: Path, *, watch: Record | None = None, **options) -> dict:
    """`live_scan` of what is wanted; what tunes its source is as `LiveStream` and `GrowingFolder` have it."""
    job, opened = described(replace(wanted, workers=2))
    tuned = {name: options.pop(name) for name in ("silence", "patience", "late", "grace") if name in options}

    def source(book):
        found = opened(book)
        for name, value in tuned.items():
            setattr(found, name, value)
        return found

    limits = options.pop("limits", Limits(options.pop("count", None), options.pop("duration", 60.0)))
    return live_scan(job, source, out, limits=limits, watch=watch or Record(), **options)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def contents(folder: Path, *parts: str) -> dict[str, bytes]:
    """Every file of these parts of a result, with its bytes."""
    files = (path for part in parts for path in [folder / part, *(folder / part).rglob("*")] if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def python(*arguments: object, **options) -> subprocess.Popen[str]:
    """A Python program of its own."""
    return subprocess.Popen(
        [sys.executable, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "MPLBACKEND": "Agg"},
        **options,
    )
