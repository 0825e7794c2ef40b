"""Calibration of planes and cones of light by ring gauges and by flats at known stand-offs."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration
from calibore.calibration._rig._findings import observations_of, scatter_of, zeniths_of
from calibore.calibration._rig._fit import RigFit, fit_rig, foreseen
from calibore.calibration._rig._gauges_file import GaugesTarget, read_gauges_target
from calibore.calibration._rig._gauges_findings import gauges_findings, gauges_warnings
from calibore.calibration._rig._gauges_pictures import RingPictures, find_rings
from calibore.calibration._rig._line_pictures import Progress
from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._stops import Suspect, without_wrong_stops
from calibore.errors import InputError
from calibore.rigs import CONFIGURATIONS, Rig, ValidRegion, value_of, values_of
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]
TELLING = 0.03
"""A parameter is told where its standard uncertainty is less than this: rad, slope, or of the references' size."""
GIVEN_UP = ("offset", "clock", "tilt_y", "tilt_x", "aim", "half_angle", "baseline")
"""In this order parameters are held that references do not tell: first what builders know best."""
LENGTHS = ("baseline", "offset")
BOUNDS = {"laser.baseline": (0.4, 2.5), "camera.k": (0.4, 2.5)}
WIDEST_TURN = np.radians(20.0)
FEWEST_STOPS = 2


@dataclass(frozen=True)
class Choice:
    """Parameters looked for; those `held` at their stated values, because nothing tells them; those of the lasers that
    are taken from what the rig file states, `stated`.
    """

    free: tuple[str, ...]
    held: tuple[str, ...] = ()
    stated: tuple[str, ...] = ()


def calibrate_gauges(path: Path | str, *, progress: Progress | None = None) -> Calibration:
    """A rig with a plane or cones of light, from pictures of its line in ring gauges of known diameter and, for cones,
    on flats at known stand-offs; `path`: target.toml or its folder.

    Found are those parameters of the lasers that the references tell; where they tell one not, what the rig file states
    of it counts, or it is held and a finding says so. The camera's parameters are looked for within what `lens_file` or
    the rig file states of them, else held. `progress` counts placings. Raises InputError where evidence is missing.
    """
    target = read_gauges_target(path)
    pictures = find_rings(target, progress=progress)
    found, choice = fit_gauges(target.rig, pictures.looks, camera=target.camera, design=target.design)
    found, wrong = without_wrong_stops(found, fewest=FEWEST_STOPS)
    return _calibration(target, pictures, found, choice, wrong)


def fit_gauges(
    rig: Rig, looks: Iterable[Look], *, camera: Covariance | None = None, design: Covariance | None = None
) -> tuple[RigFit, Choice]:
    """The rig that explains `looks`, and which parameters were looked for. `camera`: what is known of its camera;
    `design`: of its lasers, which counts where the looks do not tell.
    """
    looks = tuple(looks)
    known = [] if camera is None else [name for name, u in zip(camera.names, camera.u, strict=True) if u > 0]
    cameras = tuple(name for name in known if name in rig.parameter_names)
    choice = _what_is_told(rig, looks, cameras, camera, design)
    prior = _prior(choice, cameras, camera, design)
    try:
        return fit_rig(rig, looks, free=choice.free, prior=prior, bounds=_bounds(rig, choice.free)), choice
    except InputError as error:
        raise InputError(
            f"{str(error).rstrip('.')}. The rig was looked for near what its file says: check baseline, angles, lens "
            "and k there, and the sizes in target.toml."
        ) from error


def laser_parameters(rig: Rig) -> list[str]:
    """Those of all lasers that the configuration does not fix."""
    fixed = dict(CONFIGURATIONS[rig.configuration].fixed)
    return [
        f"{rig.laser_table(number)}.{name}"
        for number, laser in enumerate(rig.lasers)
        for name in laser.surface.parameter_names
        if name not in fixed
    ]


def _what_is_told(
    rig: Rig, looks: tuple[Look, ...], cameras: tuple[str, ...], camera: Covariance | None, design: Covariance | None
) -> Choice:
    """Gives parameters up one by one until what is left is told."""
    seen = {look.laser for look in looks}
    tables = tuple(rig.laser_table(number) for number in seen)
    lasers = [name for name in laser_parameters(rig) if name.rpartition(".")[0] in tables]
    size = float(np.mean([_size(rig, look) for look in looks]))
    choice = Choice((*lasers, *cameras))
    while True:
        prior = _prior(choice, cameras, camera, design)
        u = foreseen(rig, looks, free=choice.free, prior=prior)
        weak = [
            name
            for name in choice.free
            if name in lasers
            and name not in choice.stated
            and not u[name] < TELLING * (size if name.rpartition(".")[2] in LENGTHS else 1.0)
        ]
        if not weak:
            return choice
        name = min(weak, key=lambda one: GIVEN_UP.index(one.rpartition(".")[2]))
        if design is not None and name in design.names and design.restricted([name]).u[0] > 0:
            choice = replace(choice, stated=(*choice.stated, name))
        else:
            free = tuple(one for one in choice.free if one != name)
            choice = replace(choice, free=free, held=(*choice.held, name))
        if not set(choice.free) & set(lasers):
            raise InputError(
                "These pictures tell nothing of the laser; photograph its line in a ring gauge that shows it all round."
            )


def _prior(
    choice: Choice, cameras: tuple[str, ...], camera: Covariance | None, design: Covariance | None
) -> Covariance | None:
    parts = []
    if camera is not None and cameras:
        parts.append(camera.restricted(cameras))
    if design is not None and choice.stated:
        parts.append(design.restricted(choice.stated))
    if len(parts) == 2:
        return parts[0].joined(parts[1])
    return parts[0] if parts else None


def _size(rig: Rig, look: Look) -> float:
    """Roughly how large [m] what was looked at is."""
    reference = look.reference
    return float(getattr(reference, "diameter", 0.0)) / 2 or float(getattr(reference, "distance", 0.0))


def _bounds(rig: Rig, free: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    """Of the changes."""
    bounds = {}
    for name in free:
        key, value = name.rpartition(".")[2], value_of(rig, name)
        table = f"{name.partition('.')[0]}.{key}"
        if table in BOUNDS and value > 0:
            least, most = BOUNDS[table]
            bounds[name] = (least - 1) * value, (most - 1) * value
        elif key in ("aim", "half_angle", "tilt_x", "tilt_y"):
            bounds[name] = -WIDEST_TURN, WIDEST_TURN
    return bounds


def _calibration(
    target: GaugesTarget, pictures: RingPictures, found: RigFit, choice: Choice, wrong: list[Suspect]
) -> Calibration:
    left_out = {one.stop: one for one in wrong}
    files = list(pictures.files)
    for look in pictures.looks:
        if look.of_stop in left_out:
            off = target.unit.said(left_out[look.of_stop].off, 0.001 * target.unit.size)
            files[look.file] = replace(files[look.file], refused=f"its size or place is off by {off}")
    radius = found.radii()
    noise, shared = scatter_of(found)
    return Calibration(
        kind="ring-gauge",
        rig=found.rig,
        camera=found.rig.camera,
        values=values_of(found.rig, found.free),
        covariance=found.covariance,
        degrees_of_freedom=found.fit.degrees_of_freedom,
        noise=noise,
        group_sigma=shared,
        files=tuple(files),
        observations=observations_of(found),
        valid=ValidRegion(zeniths_of(found), (float(radius.min()), float(radius.max()))),
        settings={
            "stated": values_of(found.model.rig, found.free),
            "stops": {"count": len(found.model.stops), "scatter_m": found.stop_scatter},
        },
        findings=tuple(gauges_findings(target, found, choice.held, choice.stated)),
        warnings=tuple(gauges_warnings(target, pictures, found, wrong)),
    )
