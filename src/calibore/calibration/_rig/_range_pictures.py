"""The laser's line on a flat target, found in the pictures of every stop."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._input_files import InputFile
from calibore.calibration._rig._line_pictures import OneSize, Picture, Progress, average_takes
from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._range_file import RangeTarget
from calibore.calibration._rig._references import FlatTarget
from calibore.errors import InputError
from calibore.stripe import detect_line

Array = NDArray[np.float64]
STRIPS = 96
"""Rows are averaged to this many strips before the line is looked for: on a flat it is straight, and what speckle does
to a line that is wider than its grains averages out better in brightness than in place."""
LEAST_SEEN = 0.3
"""A line is seen in at least this fraction of the strips."""
BORDER = 4.0
"""Line widths from the image's border within which a line may be cut off."""


@dataclass(frozen=True, eq=False)
class LinePictures:
    """`looks` at the target by increasing range; `files` with why some were not used; the takes that have room `light`
    and how often; `size` of the pictures [px].
    """

    looks: tuple[Look, ...]
    files: tuple[InputFile, ...]
    light: dict[int, int]
    size: tuple[int, int]


def find_lines(target: RangeTarget, *, channel: str, progress: Progress | None) -> LinePictures:
    """Looks at every stop of the target; raises InputError where pictures differ in size or no stop shows a line."""
    one_size, files, looks, light = OneSize(), [], [], {}
    for done, (index, paths) in enumerate(target.paths.items(), start=1):
        takes = average_takes(paths, folder=target.folder, size=one_size)
        own, why = list(takes.files), ""
        for take in takes.lit:
            light[take] = light.get(take, 0) + 1
        if takes.picture is not None:
            look = _look(takes.picture, target, index, channel)
            if isinstance(look, Look):
                first = next(number for number, one in enumerate(own) if one.used)
                looks.append(replace(look, file=len(files) + first))
            else:
                why = look
        files += [replace(one, refused=why) if one.used else one for one in own]
        if progress is not None:
            progress(done, len(target.paths))
    if one_size.known is None:
        raise InputError(f"None of the {len(files)} pictures can be used; the first: {files[0].refused}.")
    if not looks:
        reasons = "; ".join(dict.fromkeys(one.refused for one in files if one.refused))
        raise InputError(
            f"No picture of the {len(target.paths)} stops shows the laser's line ({reasons}); check exposure and the "
            f"channel ({channel}), and take one picture per stop with the laser alone."
        )
    return LinePictures(tuple(looks), tuple(files), light, one_size.known)


def _look(picture: Picture, target: RangeTarget, index: int, channel: str) -> Look | str:
    """The line in a picture of one stop, or why there is none."""
    height, width = picture.shape[:2]
    rows = max(1, height // STRIPS)
    strips = height // rows
    stripe = detect_line(_strips(picture, rows, strips), channel=channel)
    border = BORDER * stripe.noise.width
    whole = stripe.found & (stripe.v > border) & (stripe.v < width - 1 - border)
    if np.count_nonzero(whole) < LEAST_SEEN * strips:
        cut = np.count_nonzero(stripe.found & ~whole)
        return (
            f"it shows no whole line (found in {np.count_nonzero(whole)} of {strips} strips"
            f"{f', cut off by the border in {cut}' if cut else ''}); the target may be outside the view"
        )
    place = target.range_of(index)
    reference = FlatTarget(place, u=target.said.u_range, u_tilt=(0.0, target.said.u_tilt))
    v = np.arange(strips) * rows + (rows - 1) / 2
    across = np.tile([1.0, 0.0], (int(np.count_nonzero(whole)), 1))
    name = target.unit.said(place, 0.01 * target.said.range_step)
    return Look(stripe.v[whole], v[whole], across, stripe.u_position[whole], reference, name, setting="target")


def _strips(picture: Picture, rows: int, strips: int) -> NDArray[Any]:
    """The mean of every `rows` rows, turned so that the line runs from left to right (w, strips[, 3])."""
    cut = picture[: rows * strips].reshape(strips, rows, *picture.shape[1:])
    mean = np.rint(cut.mean(axis=1)).astype(picture.dtype)
    return np.ascontiguousarray(mean.swapaxes(0, 1))
