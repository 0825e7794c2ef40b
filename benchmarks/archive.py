"""Pictures from an archive against the same from PNG files: processor time to read, bytes, the measurement with each.

Shared pictures of an independent renderer, and simulated ones of other kinds: colour and grey, 8 and 16 bit.
"""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numcodecs.blosc
import numpy as np

from benchmarks.surveys import SHARED
from benchmarks.timing import compare as compare_by_wall
from calibore.crews import in_order
from calibore.images import ImageArchive, ImageFolder, read_image
from calibore.profiling import Job, archive_scan, measure_image, profile_scan
from calibore.rigs import read_rig
from calibore.scans import read_scan

compare = partial(compare_by_wall, clock=time.process_time)
PNG = "PNG, the decoder of calibore"
SURVEYS = ("plane-12in", "side-2.4in", "field")
KINDS = ("simulated colour 8 bit", "simulated grey 8 bit", "simulated grey 16 bit")
SCAN = 'format = "calibore-scan/1"\nname = "kinds"\nrig = "rig.toml"\n[pipe]\nnominal_radius = "6 in"\n' + (
    '[images]\npattern = "{station:03d}.png"\n[motion]\naxial = { origin = "0 m", step = "1 m" }\n'
)
CAMERA_NOISE = 6.0
"""Of the 12 bit camera that the 16 bit pictures stand for [grey values of 4095]."""


def report(rounds: int = 21) -> list[str]:
    """Markdown lines."""
    numcodecs.blosc.set_nthreads(1)
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        scans = {name: SHARED / name for name in SURVEYS} | _kinds(Path(folder))
        lines = ["## Archive against PNG, one thread, processor time", ""]
        for name, scan in scans.items():
            lines += _reading(name, scan, Path(folder) / "archives" / name, rounds)
        return lines + _measuring(Path(folder) / "archives" / "plane-12in", Path(folder), rounds)


def _kinds(folder: Path, stations: int = 6) -> dict[str, Path]:
    """The demonstration's pipe as a colour camera sees it, and its red plane as monochrome cameras would store it."""
    from calibore.simulation import demo_survey, simulate_scan

    survey = simulate_scan(folder / "demo", demo_survey(seed=3), seed=3)
    paths, rng, found = sorted(survey.glob("*.png"))[:stations], np.random.default_rng(4), {}
    for kind in KINDS:
        found[kind] = folder / kind
        found[kind].mkdir()
        (found[kind] / "scan.toml").write_text(SCAN, encoding="utf-8")
        (found[kind] / "rig.toml").write_bytes((survey / "rig.toml").read_bytes())
        for number, path in enumerate(paths):
            picture = read_image(path)
            if "grey" in kind:
                picture = np.ascontiguousarray(picture[:, :, 0] if picture.ndim == 3 else picture)
            if "16" in kind:
                wide = 16.0 * picture + rng.normal(0, CAMERA_NOISE, picture.shape)
                picture = np.clip(wide, 0, 4095).astype(np.uint16)
            cv2.imwrite(str(found[kind] / f"{number:03d}.png"), picture[..., ::-1] if picture.ndim == 3 else picture)
    return found


def _reading(name: str, scan: Path, out: Path, rounds: int) -> list[str]:
    said = archive_scan(scan, out, workers=1)
    spec = read_scan(out)
    folder, archive = ImageFolder(scan, spec.pattern or ""), ImageArchive(out / "images.zarr", spec.pattern or "")
    keys = [(station, take, angular) for station, angular, take in folder.paths][:6]
    for station, take, angular in keys:
        assert np.array_equal(archive.read(station, take, angular=angular), folder.read(station, take, angular=angular))

    def every(read: Callable[..., object], **options: object) -> Callable[[], None]:
        def one_after_the_other() -> None:
            for station, take, angular in keys:
                read(station, take, angular=angular, **options)

        return one_after_the_other

    def by_opencv() -> None:
        for path in list(folder.paths.values())[: len(keys)]:
            cv2.imread(str(path), cv2.IMREAD_UNCHANGED)

    contestants = {PNG: every(folder.read), "archive, the whole picture": every(archive.read)}
    contestants["archive, one colour"] = every(archive.read_band, channel="red")
    contestants["PNG, OpenCV imread"] = by_opencv
    result = compare(contestants, peer=PNG, rounds=rounds, rng=np.random.default_rng(5))
    files, stored = said["bytes_of_files"], said["bytes_in_archive"]
    return [
        f"### {name}: {said['forms'][0]}, {files / 1e6:.2f} MB of files, {stored / 1e6:.2f} MB in the archive, "
        f"{stored / files:.2f}",
        f"| {len(keys)} pictures | median ms | PNG / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
    ]


def _measuring(archive: Path, folder: Path, rounds: int) -> list[str]:
    scan, spec = SHARED / "plane-12in", read_scan(archive)
    assert spec.rig_path is not None
    job = Job.of(read_rig(spec.rig_path), spec.nominal_radius)
    sources = (ImageFolder(scan, spec.pattern or ""), ImageArchive(archive / "images.zarr", spec.pattern or ""))

    def radii(source: ImageFolder | ImageArchive) -> object:
        stations = list(source.stations())
        return list(in_order(stations, lambda images: measure_image(images.read(0), job), workers=1))

    contestants = {
        "PNG to radii": lambda: radii(sources[0]),
        "archive to radii": lambda: radii(sources[1]),
    }
    short = compare(contestants, peer="PNG to radii", rounds=rounds, rng=np.random.default_rng(6))
    whole = {
        "calibore profile of the PNG files": lambda: profile_scan(scan, folder / "a", workers=1),
        "calibore profile of the archive": lambda: profile_scan(archive, folder / "b", workers=1),
    }
    first = next(iter(whole))
    long = compare(whole, peer=first, rounds=max(rounds // 3, 5), rng=np.random.default_rng(7))
    return [
        "### plane-12in measured",
        "| what | median ms | PNG / contestant (95 %) |",
        "|---|---|---|",
        *short.rows(),
        *long.rows(),
    ]
