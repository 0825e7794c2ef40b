"""Rig -> rig.toml, so that `read_rig` gives the same rig back."""

import json
import re
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs._configurations import CONFIGURATIONS
from calibore.rigs._documents import ANGLES, LENGTHS, laser_keys
from calibore.rigs._mount import SideFacing
from calibore.rigs._rig import Laser, Rig
from calibore.rigs._valid import ValidRegion
from calibore.uncertainty import Covariance, Distribution

CENTRE = "camera.principal_point_"
FORMAT = 'format = "calibore-rig/1"'
Quantity = Callable[[float, str], str]


def write_rig(rig: Rig, path: Path | str) -> None:
    """Write `rig` as a rig file (formats.md, section 3). Inputs that nothing is correlated with stand in [uncertainty],
    the others, and those of several lasers, in [calibration], which knows no distributions.
    """
    Path(path).write_text(rig_toml(rig), encoding="utf-8")


def rig_toml(rig: Rig) -> str:
    """The text of the rig file."""
    return "\n".join(_lines(rig)) + "\n"


def parts_toml(part: Rig | Camera | None) -> str:
    """What a calibration found, to the last bit, with what is stated of other inputs but without [calibration]: a rig,
    a camera only, or none. Raises InputError where an input is correlated, which only [calibration] can say.
    """
    if not isinstance(part, Rig):
        camera = _camera(part) if part else ()
        return "\n".join([FORMAT, *camera]) + "\n"
    alone, rest = _apart(part)
    if rest.names:
        raise InputError(f"{', '.join(rest.names)} are correlated; a rig file says so of calibrated parameters only.")
    return "\n".join([*_tables(part, _exact), *_uncertainty(alone, part.stripe)]) + "\n"


def _lines(rig: Rig) -> Iterator[str]:
    alone, rest = _apart(rig)
    yield from _tables(rig, _quantity)
    yield from _uncertainty(alone, rig.stripe)
    if rest.names:
        yield from ("", "[calibration]", f"parameters = {json.dumps(rest.names)}")
        yield from ("covariance = [", *(f"    {row}," for row in rest.matrix.tolist()), "]")
        if rig.degrees_of_freedom is not None:
            yield f"degrees_of_freedom = {float(rig.degrees_of_freedom)!r}"
        if not np.isinf(rest.degrees_of_freedom).all():
            yield f"parameter_degrees_of_freedom = {[float(freedom) for freedom in rest.degrees_of_freedom]}"
    yield from _valid(rig.valid)


def _tables(rig: Rig, quantity: Quantity) -> Iterator[str]:
    yield from (FORMAT, f'configuration = "{rig.configuration}"')
    yield from _camera(rig.camera)
    listed = len(rig.lasers) > 1
    for laser in rig.lasers:
        yield ""
        yield "[[laser]]" if listed else "[laser]"
        yield from _laser(laser, rig, quantity)


def _camera(camera: Camera) -> Iterator[str]:
    lens = camera.lens
    yield from ("", "[camera]", f"width = {camera.width}", f"height = {camera.height}")
    yield from (f'lens = "{lens.law}"', f"k = {float(lens.k)!r}")
    yield f"principal_point = [{', '.join(repr(float(p)) for p in camera.principal_point)}]"
    for name, value in (("c1", lens.c1), ("c2", lens.c2), ("aspect", camera.aspect)):
        if value != (1.0 if name == "aspect" else 0.0):
            yield f"{name} = {float(value)!r}"
    if lens.polynomial:
        yield f"polynomial = [{', '.join(repr(float(p)) for p in lens.polynomial)}]"
    if camera.pupil_walk:
        yield "pupil_walk = [" + ", ".join(f'"{float(d)!r} m"' for d in camera.pupil_walk) + "]"
    if camera.port:
        yield from ("", "[camera.port]")
        for field in fields(camera.port):
            value = getattr(camera.port, field.name)
            yield f"{field.name} = {value!r}" if "index" in field.name else f'{field.name} = "{value!r} m"'


def _laser(laser: Laser, rig: Rig, quantity: Quantity) -> Iterator[str]:
    for key, default in laser_keys(CONFIGURATIONS[rig.configuration]).items():
        source: Any = rig.mount if isinstance(rig.mount, SideFacing) and key in ("baseline", "aim") else laser.surface
        value = float(getattr(source, key))
        unit = "m" if key in LENGTHS else "rad" if key in ANGLES else ""
        if default is None or value != default:
            yield f"{key} = {quantity(value, unit)}"
    if laser.channel is not None:
        yield f'channel = "{laser.channel}"'
    if laser.takes is not None:
        yield f"takes = [{', '.join(map(str, laser.takes))}]"


def _apart(rig: Rig) -> tuple[Covariance, Covariance]:
    """What [uncertainty] can say, and the rest."""
    covariance = rig.covariance or Covariance.independent({})
    alone = {name for name in covariance.names if _stands_alone(covariance, name)}
    rest = [name for name in covariance.names if name not in alone]
    return covariance.restricted([name for name in covariance.names if name in alone]), covariance.restricted(rest)


def _uncertainty(covariance: Covariance, stripe: float | None) -> Iterator[str]:
    lines = [] if stripe is None else [f"stripe = {float(stripe)!r}"]
    lines += list(_plain(covariance))
    if lines:
        yield from ("", "[uncertainty]", *lines)


def _valid(valid: ValidRegion | None) -> Iterator[str]:
    if valid and valid.said():
        yield from ("", "[calibration.valid]")
        for name, unit in (("zenith", "rad"), ("radius", "m")):
            limits = getattr(valid, name)
            if limits:
                yield f"{name} = [{', '.join(_quantity(float(limit), unit) for limit in limits)}]"


def _stands_alone(covariance: Covariance, name: str) -> bool:
    """Whether a key of [uncertainty] can say it: one laser's or the camera's, correlated with nothing; the principal
    point's two share a key where they are alike.
    """
    if re.match(r"laser\.\d|camera\.(port|pupil_walk|polynomial)", name):
        return False
    if not name.startswith(CENTRE):
        row = covariance.matrix[covariance.names.index(name)]
        return bool(np.count_nonzero(row) <= 1)
    pair = [covariance.names.index(f"{CENTRE}{axis}") for axis in "uv" if f"{CENTRE}{axis}" in covariance.names]
    return len(pair) == 2 and np.count_nonzero(covariance.matrix[pair]) == 2 and bool(np.ptp(covariance.u[pair]) == 0)


def _plain(covariance: Covariance) -> Iterator[str]:
    for name, u in zip(covariance.names, covariance.u.tolist(), strict=True):
        key = name.split(".")[1]
        unit = "m" if key in LENGTHS else "rad" if key in ANGLES else ""
        if name == f"{CENTRE}v":
            continue
        key = "principal_point" if name == f"{CENTRE}u" else key
        yield f"{key} = {_table(covariance, name, _quantity(u, unit))}"


def _table(covariance: Covariance, name: str, u: str) -> str:
    """`u`, or a table where the input is not normal or has degrees of freedom."""
    index = covariance.names.index(name)
    shape, freedom = covariance.distributions[index], covariance.degrees_of_freedom[index]
    said = [] if shape is Distribution.NORMAL else [f'distribution = "{shape}"']
    said += [] if np.isinf(freedom) else [f"degrees_of_freedom = {float(freedom)!r}"]
    return f"{{ {', '.join([f'u = {u}', *said])} }}" if said else u


def _quantity(value: float, unit: str) -> str:
    """Fourteen digits: 6 in stays 0.1524 m."""
    return f'"{value:.14g} {unit}"' if unit else repr(value)


def _exact(value: float, unit: str) -> str:
    """As many digits as the value has."""
    return f'"{value!r} {unit}"' if unit else repr(value)
