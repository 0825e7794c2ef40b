"""The files of a simulated scan folder: PNG, rig.toml, scan.toml (formats.md, sections 2 and 3)."""

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers import Plane
from calibore.rigs import Rig
from calibore.uncertainty import Covariance

LENGTHS = ("laser.baseline",)
CENTRE = ("camera.principal_point_u", "camera.principal_point_v")


def write_png(path: Path, image: NDArray[np.uint8 | np.uint16]) -> None:
    """Write `image` (h, w, 3), 8 or 16 bit, losslessly and fast; the same pixels give the same bytes."""
    import av

    codec = av.CodecContext.create("png", "w")
    codec.height, codec.width = image.shape[:2]
    codec.pix_fmt = "rgb24" if image.dtype == np.uint8 else "rgb48be"
    codec.time_base = Fraction(1)
    codec.options = {"compression_level": "1", "pred": "none", "threads": "1"}  # noise does not compress further
    pixels: Any = np.ascontiguousarray(image)
    frame = av.VideoFrame.from_ndarray(pixels, format=codec.pix_fmt)
    path.write_bytes(b"".join(bytes(packet) for packet in [*codec.encode(frame), *codec.encode(None)]))


def _metres(length: float) -> str:
    """Twelve digits: no length is known better, and 6 in stays 0.1524 m."""
    return f"{length:.12g} m"


def scan_toml(*, name: str, nominal_radius: float, pattern: str, origin: float, step: float) -> str:
    """scan.toml; lengths in m."""
    return (
        f'format = "calibore-scan/1"\nname = {json.dumps(name)}\nrig = "rig.toml"\n\n'
        f'[pipe]\nnominal_radius = "{_metres(nominal_radius)}"\n\n'
        f"[images]\npattern = {json.dumps(pattern)}\n\n"
        f'[motion]\naxial = {{ origin = "{_metres(origin)}", step = "{_metres(step)}" }}\n'
    )


def rig_toml(rig: Rig) -> str:
    """rig.toml of a perpendicular-plane rig, with whatever uncertainty it states."""
    camera, laser = rig.camera, rig.lasers[0]
    if len(rig.lasers) != 1 or not isinstance(laser.surface, Plane):
        raise InputError("Only rigs with one laser plane can be written; simulate one laser at a time.")
    lines = [f'format = "calibore-rig/1"\nconfiguration = "{rig.configuration}"\n', "[camera]"]
    lines += [f"width = {camera.width}", f"height = {camera.height}", f'lens = "{camera.lens.law}"']
    lines += [f"k = {float(camera.lens.k)!r}", f"principal_point = {[float(x) for x in camera.principal_point]}"]
    optional = {"c1": camera.lens.c1, "c2": camera.lens.c2, "aspect": camera.aspect if camera.aspect != 1 else 0.0}
    lines += [f"{key} = {float(value)!r}" for key, value in optional.items() if value]
    if camera.lens.polynomial:
        lines.append(f"polynomial = {[float(p) for p in camera.lens.polynomial]}")
    lines += ["", "[laser]", f'baseline = "{_metres(laser.surface.baseline)}"']
    tilts = {"tilt_x": laser.surface.tilt_x, "tilt_y": laser.surface.tilt_y}
    lines += [f"{key} = {float(value)!r}" for key, value in tilts.items() if value]
    lines.append(f'channel = "{laser.channel or "red"}"')
    return "\n".join([*lines, *_uncertainty(rig), ""])


def _uncertainty(rig: Rig) -> list[str]:
    """The tables [uncertainty] and, where parameters are correlated, [calibration]."""
    lines = [] if rig.stripe is None else [f"stripe = {float(rig.stripe)!r}"]
    covariance = rig.covariance
    plain = covariance is not None and _is_plain(covariance)
    if covariance is not None and plain:
        u = dict(zip(covariance.names, covariance.u.tolist(), strict=True))
        named = {name.split(".")[1]: value for name, value in u.items() if name not in CENTRE}
        named |= {"principal_point": u[CENTRE[0]]} if CENTRE[0] in u else {}
        lines += [
            f'{key} = "{_metres(value)}"' if f"laser.{key}" in LENGTHS else f"{key} = {value!r}"
            for key, value in named.items()
        ]
    lines = ["", "[uncertainty]", *lines] if lines else []
    if covariance is not None and not plain:
        lines += ["", "[calibration]", f"parameters = {json.dumps(covariance.names)}"]
        lines += [f"covariance = {covariance.matrix.tolist()}"]
    return lines


def _is_plain(covariance: Covariance) -> bool:
    """Whether [uncertainty] can say it: nothing correlated, the principal point alike in u and v, no polynomial."""
    u = dict(zip(covariance.names, covariance.u.tolist(), strict=True))
    alike = u.get(CENTRE[0]) == u.get(CENTRE[1])
    known = not any("polynomial" in name for name in u)
    return alike and known and not np.any(covariance.matrix - np.diag(np.diag(covariance.matrix)))
