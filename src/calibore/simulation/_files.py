"""The files of a simulated scan folder: PNG and scan.toml (formats.md, section 2)."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


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
    pattern: str,
    axial: tuple[float, float],
    angular: tuple[float, float] | None = None,
) -> str:
    """scan.toml; `axial` = (origin, step) [m], `angular` = (origin, step) [rad] of a side-facing head."""
    motion = _motion("axial", axial, "m") + (_motion("angular", angular, "rad") if angular else "")
    return (
        f'format = "calibore-scan/1"\nname = {json.dumps(name)}\nrig = "rig.toml"\n\n'
        f'[pipe]\nnominal_radius = "{_quantity(nominal_radius, "m")}"\n\n'
        f"[images]\npattern = {json.dumps(pattern)}\n\n[motion]\n{motion}"
    )


def _motion(key: str, motion: tuple[float, float], unit: str) -> str:
    origin, step = (_quantity(value, unit) for value in motion)
    return f'{key} = {{ origin = "{origin}", step = "{step}" }}\n'


def _quantity(value: float, unit: str) -> str:
    """Twelve digits: no length is known better, and 6 in stays 0.1524 m."""
    return f"{value:.12g} {unit}"
