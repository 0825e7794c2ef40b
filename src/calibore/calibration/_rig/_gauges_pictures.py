"""The laser's line in ring gauges and on flats, found in the pictures of every placing."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from calibore.calibration._input_files import InputFile
from calibore.calibration._outlines import annulus
from calibore.calibration._rig._gauges_file import GaugesTarget, Placing
from calibore.calibration._rig._line_pictures import OneSize, Progress, Takes, average_takes
from calibore.calibration._rig._looks import Look
from calibore.errors import InputError
from calibore.rigs import Rig
from calibore.stripe import detect_ring

RAYS = 720
LEAST_SEEN = 0.2
"""A ring is seen on at least this fraction of the rays."""


class RingPictures(NamedTuple):
    """`looks`, one per placing and laser; `files` with why some were not used."""

    looks: tuple[Look, ...]
    files: tuple[InputFile, ...]


def find_rings(target: GaugesTarget, *, progress: Progress | None) -> RingPictures:
    """Looks at every placing; raises InputError where pictures do not fit the rig or none shows a line."""
    camera = target.rig.camera
    size, files, looks = OneSize((camera.width, camera.height)), [], []
    for done, placing in enumerate(target.placings, start=1):
        for laser in range(len(target.rig.lasers)):
            paths = _showing(target.rig, placing, laser)
            takes = average_takes(paths, folder=target.folder, size=size)
            look = _look(takes, target, placing, laser)
            if isinstance(look, Look):
                first = next(number for number, one in enumerate(takes.files) if one.used)
                looks.append(replace(look, file=len(files) + first))
            why = "" if isinstance(look, Look) else look
            files += [replace(one, refused=why) if one.used else one for one in takes.files]
        if progress is not None:
            progress(done, len(target.placings))
    if not looks:
        reasons = "; ".join(f"{one.name}: {one.refused}" for one in files if one.refused)
        raise InputError(f"No picture shows the laser's line where the rig file expects it ({reasons}).")
    return RingPictures(tuple(looks), tuple(files))


def _showing(rig: Rig, placing: Placing, laser: int) -> dict[int, Path]:
    """The pictures in which no other laser is lit."""
    others = [one for number, one in enumerate(rig.lasers) if number != laser]
    shown = {
        take: path
        for take, path in placing.paths.items()
        if rig.lasers[laser].is_lit(take) and not any(one.is_lit(take) for one in others)
    }
    if not shown:
        raise InputError(
            f"No picture of {placing.name} shows laser {laser} alone; photograph every laser by itself, and say in the "
            "rig file which takes show which: takes = [1] in its [[laser]] table."
        )
    return shown


def _look(takes: Takes, target: GaugesTarget, placing: Placing, laser: int) -> Look | str:
    """The line in the mean picture of one placing, or why there is none."""
    if takes.picture is None:
        return "none of its takes can be used"
    rig, reference = target.rig, placing.reference
    try:
        where = annulus(rig, reference, laser=laser)
        stripe = detect_ring(
            takes.picture,
            where.centre,
            inner=where.inner,
            outer=where.outer,
            channel=target.channels[laser],
            rays=RAYS,
        )
    except InputError as error:
        why = str(error).rstrip(".")
        return f"{why[:1].lower()}{why[1:]}; check exposure, channel, and that the rig file is near the truth"
    found = np.isfinite(stripe.u) & stripe.found
    if np.count_nonzero(found) < LEAST_SEEN * RAYS:
        return f"its line was found on {np.count_nonzero(found)} of {RAYS} rays only"
    return Look(
        stripe.u[found],
        stripe.v[found],
        stripe.direction[found],
        stripe.u_position[found],
        reference,
        f"{placing.name}, laser {laser}" if len(rig.lasers) > 1 else placing.name,
        laser=laser,
        setting=placing.name,
        stop=placing.stop,
    )
