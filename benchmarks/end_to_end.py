"""Files to radii, and files to pixels: PNG, JPEG and raw pixels, against the script a user would write.

Raw are PPM files, 15 bytes of text and the pixels, which the peer reads with np.fromfile.
"""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from itertools import count
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from benchmarks.peers import opencv_script
from benchmarks.surveys import PLANE, SHARED, image_paths, stated_rig
from benchmarks.timing import Comparison, compare
from calibore.crews import in_order
from calibore.images import read_image
from calibore.profiling import Job, Ring, Tally, measure_image, measure_scan, prepare, profile_scan
from calibore.scans import read_scan

PEER = "OpenCV warpPolar + NumPy, radii only"
OURS = "calibore, radii with uncertainties (the same job)"
TWO_STEPS = "calibore, the same in two steps, with an array of the picture"
READING = "calibore, reading alone"
JPEG_QUALITY = 95
GROSS_IN = 0.15
INCH = 0.0254


def report(workers: int, rounds: int = 15) -> list[str]:
    """Markdown lines: on one thread by processor time, which other jobs disturb least, on several by the wall's."""
    cv2.setNumThreads(workers)
    with tempfile.TemporaryDirectory() as folder, np.errstate(all="ignore"):
        kinds = kinds_in(Path(folder))
        lines = [f"## End to end: {len(kinds['PNG'])} pictures of plane-12in, {workers} thread(s)"]
        for number, (kind, paths) in enumerate(kinds.items()):
            lines += _kind(kind, paths, workers, np.random.default_rng([2, number]), rounds)
        lines += _whole(Path(folder), kinds["PNG"], workers, rounds // 2)
        return lines + _accuracy(kinds["PNG"])


def kinds_in(folder: Path) -> dict[str, list[Path]]:
    """The pictures in each kind of file, the lossy ones made from the others."""
    paths = image_paths()
    kinds: dict[str, list[Path]] = {"PNG": paths, "JPEG": [], "raw": []}
    for path in paths:
        picture = Image.open(path)
        for kind, suffix in (("JPEG", ".jpg"), ("raw", ".ppm")):
            kinds[kind].append(folder / f"{path.stem}{suffix}")
            picture.save(kinds[kind][-1], quality=JPEG_QUALITY)
    return kinds


def _kind(kind: str, paths: list[Path], workers: int, rng: np.random.Generator, rounds: int) -> list[str]:
    rig, nominal = stated_rig()
    job = Job.of(rig, nominal)

    def each(work: Callable[[Path], object], hands: int = workers) -> Callable[[], list[object]]:
        return lambda: list(in_order(paths, work, workers=hands))

    def in_two_steps(path: Path) -> Ring:
        return measure_image(read_image(path), job)

    def read(path: Path) -> None:
        read_image(path)

    peer = opencv_script.profile_raw if kind == "raw" else opencv_script.profile
    ours = partial(measure_image, job=job)
    contestants: dict[str, Callable[[], object]] = {OURS: each(ours), TWO_STEPS: each(in_two_steps)}
    contestants |= {READING: each(read), PEER: lambda: peer(paths)}
    clock = time.process_time if workers == 1 else time.perf_counter
    lines = _table(kind, compare(contestants, peer=PEER, rounds=rounds, rng=rng, clock=clock), "peer")
    if workers > 1:
        alone = "calibore, one thread"
        hands = {f"calibore, {workers} threads": each(ours), alone: each(ours, 1)}
        lines += _table(f"{kind}, more threads", compare(hands, peer=alone, rounds=rounds, rng=rng), "one thread")
    return lines


def _whole(folder: Path, paths: list[Path], workers: int, rounds: int) -> list[str]:
    numbers = count()

    def measured() -> list[object]:
        job, source, place = prepare(read_scan(PLANE), estimator="zero-crossing")
        return list(measure_scan(job, source, place, workers=workers, tally=Tally()))

    contestants: dict[str, Callable[[], object]] = {
        "calibore, rings with all quantities and uncertainties": measured,
        "calibore, the same written to OUT": lambda: profile_scan(PLANE, folder / f"{next(numbers)}", workers=workers),
        PEER: lambda: opencv_script.profile(paths),
    }
    clock = time.process_time if workers == 1 else time.perf_counter
    result = compare(contestants, peer=PEER, rounds=rounds, rng=np.random.default_rng(3), clock=clock)
    return _table("PNG, everything", result, "peer")


def _table(title: str, result: Comparison, peer: str) -> list[str]:
    return [
        f"### {title}",
        f"| contestant | median ms | {peer} / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
    ]


def _accuracy(paths: list[Path]) -> list[str]:
    job, source, place = prepare(read_scan(PLANE), estimator="zero-crossing")
    results = measure_scan(job, source, place, workers=1, tally=Tally())
    ours = {result.profile.station: result.profile.radius / INCH for result in results}
    first = {path: radii for path, radii in opencv_script.profile(paths).items() if path.stem.endswith(" 0")}
    by_station = {int(path.stem.split()[1]): radii for path, radii in first.items()}
    return [
        "| contestant | rms radius error in | missed % | beyond 0.15 in % |",
        "|---|---|---|---|",
        _score("calibore (both takes)", ours),
        _score("peer (one take)", by_station),
    ]


def _score(name: str, radii: dict[int, np.ndarray]) -> str:
    with np.load(PLANE / "truth.npz") as truth:
        rows = [int(np.flatnonzero(truth["stop"] == station)[0]) for station in radii]
        true = truth["ring_rig_R"][rows, 0]
        want = truth["ring_rig_visible"][rows, 0] & (truth["ring_rig_signal"][rows, 0] > 0.05)
    error = np.stack(list(radii.values())) - true
    good = want & (np.abs(error) < GROSS_IN)
    missed = want & ~np.isfinite(error)
    outliers = want & np.isfinite(error) & ~good
    rms = np.sqrt(np.mean(error[good] ** 2))
    return f"| {name} | {rms:.4f} | {100 * missed.sum() / want.sum():.2f} | {100 * outliers.sum() / want.sum():.2f} |"


def decoding(rounds: int = 31) -> list[str]:
    """Markdown lines: files to arrays of pixels, one thread, processor time."""
    cv2.setNumThreads(1)
    lines = ["## Decoding: one picture of 1024 x 768, one thread, processor time", ""]
    with tempfile.TemporaryDirectory() as folder:
        for number, (kind, path) in enumerate(_files(Path(folder)).items()):
            contestants: dict[str, Callable[[], object]] = {
                "calibore": partial(read_image, path),
                "OpenCV imread": partial(cv2.imread, str(path), cv2.IMREAD_UNCHANGED),
                "Pillow": lambda path=path: np.asarray(Image.open(path)),
            }
            if path.suffix == ".ppm":
                contestants["np.fromfile"] = partial(opencv_script.raw, path)
            rng = np.random.default_rng([6, number])
            result = compare(contestants, peer="OpenCV imread", rounds=rounds, rng=rng, clock=time.process_time)
            lines += _table(f"{kind}, {path.stat().st_size / 1e6:.2f} MB", result, "OpenCV")
    return lines


def _files(folder: Path) -> dict[str, Path]:
    """One of every kind, as Pillow writes it."""
    found = {f"PNG of {name}": min((SHARED / name).glob("*.png")) for name in ("plane-12in", "side-2.4in", "field")}
    picture = Image.open(next(iter(found.values())))
    grey = picture.getchannel("R")
    made = {
        "PNG, grey": ("grey.png", grey),
        "PNG, grey, 16 bit": ("wide.png", Image.fromarray(np.asarray(grey).astype(np.uint16) * 257)),
        "JPEG": ("a.jpg", picture),
        "JPEG, grey": ("grey.jpg", grey),
        "TIFF, uncompressed": ("a.tif", picture),
        "PPM": ("a.ppm", picture),
    }
    for kind, (name, pixels) in made.items():
        found[kind] = folder / name
        pixels.save(found[kind], quality=JPEG_QUALITY)
    return found
