"""The files of a simulated folder: PNG and scan.toml (formats.md, section 2), and truth.npz that lists them."""

import json
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

TRUTH = "truth.npz"


def earlier_simulation(folder: Path) -> set[str] | None:
    """The names of what an earlier simulation has written into `folder`."""
    with suppress(OSError, KeyError, ValueError, zipfile.BadZipFile), np.load(folder / TRUTH) as truth:
        return set(truth["files"].tolist())
    return None


def write_truth(folder: Path, columns: Mapping[str, Any]) -> None:
    """truth.npz, the last file to be written: `columns`, and the names of all files."""
    names = [*sorted(path.name for path in folder.iterdir()), TRUTH]
    np.savez(folder / TRUTH, allow_pickle=False, files=np.array(names), **columns)


def write_png(path: Path, image: NDArray[np.uint8 | np.uint16]) -> None:
    """Write `image` (h, w, 3), 8 or 16 bit, losslessly and fast; the same pixels give the same bytes."""
    path.write_bytes(png_bytes(image))


def png_bytes(image: NDArray[np.uint8 | np.uint16]) -> bytes:
    """The file that `write_png` writes."""
    import av

    codec = av.CodecContext.create("png", "w")
    codec.height, codec.width = image.shape[:2]
    codec.pix_fmt = "rgb24" if image.dtype == np.uint8 else "rgb48be"
    codec.time_base = Fraction(1)
    codec.options = {"compression_level": "1", "pred": "none", "threads": "1"}  # noise does not compress further
    pixels: Any = np.ascontiguousarray(image)
    frame = av.VideoFrame.from_ndarray(pixels, format=codec.pix_fmt)
    return b"".join(bytes(packet) for packet in [*codec.encode(frame), *codec.encode(None)])


def scan_toml(
    *,
    name: str,
    nominal_radius: float,
    images: tuple[str, str],
    axial: tuple[float, float],
    angular: tuple[float, float] | None = None,
    odometry: str | None = None,
) -> str:
    """scan.toml; `images` is ("pattern", ...) or ("video", ...); `axial` = (origin, step) [m] and `angular` = (origin,
    step) [rad] of a side-facing head, or the name of the table `odometry` in their place.
    """
    motion = _motion("axial", axial, "m") + (_motion("angular", angular, "rad") if angular else "")
    if odometry is not None:
        motion = f"table = {json.dumps(odometry)}\n"
    return (
        f'format = "calibore-scan/1"\nname = {json.dumps(name)}\nrig = "rig.toml"\n\n'
        f'[pipe]\nnominal_radius = "{_quantity(nominal_radius, "m")}"\n\n'
        f"[images]\n{images[0]} = {json.dumps(images[1])}\n\n[motion]\n{motion}"
    )


def odometry_csv(axial: Sequence[float], *, rate: float) -> str:
    """odometry.csv of a video of `rate` frames a second: the `axial` position [m] of every frame."""
    rows = [f"{number / rate:.12g},{place:.12g}\n" for number, place in enumerate(axial)]
    return "".join(["time_s,axial_m\n", *rows])


def tactile_toml(
    *,
    name: str,
    nominal_radius: float,
    tip_radius: float,
    axial: tuple[float, float],
    angular: tuple[float, float],
    probe: str | None = None,
    drift: float | None = None,
) -> str:
    """scan.toml of a scan by touch; `probe` names its file, None where tables beside it calibrate the probe."""
    said = f"probe = {json.dumps(probe)}\n" if probe else ""
    said += "" if drift is None else f'drift = "{_quantity(drift, "m")}"\n'
    return (
        f'format = "calibore-scan/1"\nname = {json.dumps(name)}\n\n'
        f'[pipe]\nnominal_radius = "{_quantity(nominal_radius, "m")}"\n\n'
        f'[tactile]\nsignal = "signal.csv"\nbias = "bias.csv"\ntip_radius = "{_quantity(tip_radius, "m")}"\n{said}\n'
        f"[motion]\n{_motion('axial', axial, 'm')}{_motion('angular', angular, 'rad')}"
    )


def _motion(key: str, motion: tuple[float, float], unit: str) -> str:
    origin, step = (_quantity(value, unit) for value in motion)
    return f'{key} = {{ origin = "{origin}", step = "{step}" }}\n'


def _quantity(value: float, unit: str) -> str:
    """Twelve digits: no length is known better, and 6 in stays 0.1524 m."""
    return f"{value:.12g} {unit}"
