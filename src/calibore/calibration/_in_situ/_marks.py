"""Marks of the laser's line in the pipe: from a profiled survey, or from the pictures of a side-facing head."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._in_situ._file import ProfileTarget
from calibore.calibration._input_files import InputFile, input_file
from calibore.errors import ImageError, InputError
from calibore.images import ImageFolder, read_image
from calibore.rigs import Rig, SideFacing
from calibore.scans import AxialMotion, open_points, open_profile, read_scan
from calibore.status import Status

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
SIGMA = 0.5
"""px; relative only: the residuals tell how noisy marks are."""
MOST_RINGS, MOST_PICTURES, MOST_MARKS = 60, 160, 375
"""Stations, pictures of a side-facing head, and marks of each ring that are used: neighbours are alike."""
FEWEST_MARKS = 20
ROWS = 8
"""Rows averaged before the line of a side-facing head is looked for, as on a flat target."""


@dataclass(frozen=True, eq=False)
class Marks:
    """Marks at `u`, `v` (n,) [px] of one station's ring, or of one picture of a side-facing head, in order along the
    line; measured along `direction` (n, 2) with relative standard deviation `sigma` (n,) [px]. The rig stands at
    `axial` [m], turned by `roll` [rad]; `file`: index of what they come from.
    """

    name: str
    u: Array
    v: Array
    direction: Array
    sigma: Array
    axial: float
    roll: float
    laser: int = 0
    file: int = 0


def read_marks(
    target: ProfileTarget, *, progress: Progress | None = None
) -> tuple[tuple[Marks, ...], tuple[InputFile, ...]]:
    """The marks, and the files they come from after those of the target; raises InputError where there are none."""
    if target.said.profile is not None:
        marks, files = _of_profile(target), [input_file(target.folder / target.said.profile / "summary.json")]
    else:
        marks, files = _of_scan(target, progress)
    if not marks:
        reasons = "; ".join(dict.fromkeys(file.refused for file in files if file.refused))
        raise InputError(
            f"{target.path}: nothing of the scan can be compared with the "
            f"reference{f' ({reasons})' if reasons else ''}; check stations, channel and exposure."
        )
    return tuple(marks), tuple(files)


def _of_profile(target: ProfileTarget) -> list[Marks]:
    """Rings of the stations of a result folder, takes of one laser averaged ray by ray."""
    out = target.folder / str(target.said.profile)
    points, profile = open_points(out), open_profile(out)
    if isinstance(target.rig.mount, SideFacing):
        raise InputError(f"{target.path}: {target.said.rig} is a side-facing head; give scan, its scan.toml.")
    columns = {name: np.asarray(points[name]) for name in ("u", "v", "station", "take", "status")}
    columns["u"], columns["v"] = (
        np.where(columns["status"] <= Status.SATURATED, columns[name], np.nan).astype(float) for name in "uv"
    )
    stations = np.asarray(profile["station"])
    wanted = [s for s in stations.tolist() if target.said.stations is None or s in target.said.stations]
    wanted = wanted[:: max(1, -(-len(wanted) // MOST_RINGS))]
    axial = dict(zip(stations.tolist(), np.asarray(profile["axial"]).tolist(), strict=True))
    roll = dict(zip(stations.tolist(), np.nan_to_num(np.asarray(profile["roll"])).tolist(), strict=True))
    file = len(target.files)
    marks = []
    for station in wanted:
        mine = columns["station"] == station
        for laser in range(len(target.rig.lasers)):
            u, v = _mean_of_takes({name: column[mine] for name, column in columns.items()}, target.rig, laser)
            name = f"station {station}" + (f", laser {laser}" if len(target.rig.lasers) > 1 else "")
            marks += _ring(target.rig, name, u, v, axial[station], roll[station], laser, file)
    return marks


def _mean_of_takes(columns: dict[str, Array], rig: Rig, laser: int) -> tuple[Array, Array]:
    """Rays (n,) of a laser over the takes that show it alone: noise of speckle is shared, so takes are one ring."""
    lit = {take: [i for i, one in enumerate(rig.lasers) if one.is_lit(take)] for take in np.unique(columns["take"])}
    rings = [
        np.stack([columns[name][columns["take"] == take] for name in "uv"]) for take in lit if lit[take] == [laser]
    ]
    if not rings:
        return np.zeros(0), np.zeros(0)
    whole = [ring for ring in rings if ring.shape == rings[0].shape]
    known = np.sum([np.isfinite(ring[0]) for ring in whole], axis=0)
    total = np.nansum(whole, axis=0)
    u, v = np.where(known > 0, total / np.maximum(known, 1), np.nan)
    return u, v


def _ring(rig: Rig, name: str, u: Array, v: Array, axial: float, roll: float, laser: int, file: int) -> Iterator[Marks]:
    kept = np.flatnonzero(np.isfinite(u))
    kept = kept[:: max(1, -(-kept.size // MOST_MARKS))]
    if kept.size >= FEWEST_MARKS:
        u, v = u[kept], v[kept]
        arms = np.stack([u, v], axis=1) - np.array(rig.camera.principal_point)
        direction = arms / np.linalg.norm(arms, axis=1)[:, None]
        yield Marks(name, u, v, direction, np.full(u.size, SIGMA), axial, roll, laser, file)


def _of_scan(target: ProfileTarget, progress: Progress | None) -> tuple[list[Marks], list[InputFile]]:
    """One line per picture of a side-facing head."""
    scan = read_scan(target.folder / str(target.said.scan))
    if scan.kind != "side-facing" or not isinstance(target.rig.mount, SideFacing):
        raise InputError(
            f"{target.path}: scan names pictures of a side-facing head and rig its rig file, got a {scan.kind} scan "
            f"and a {target.rig.configuration} rig; profile other scans first and give profile, the result folder."
        )
    if not isinstance(scan.motion, AxialMotion) or scan.angular is None:
        raise InputError(f"{scan.folder}: its scan.toml needs motion.axial and motion.angular for this comparison.")
    paths = [
        (*key, path)
        for key, path in ImageFolder(scan.folder, str(scan.pattern)).paths.items()
        if target.said.stations is None or key[0] in target.said.stations
    ]
    paths = paths[:: max(1, -(-len(paths) // MOST_PICTURES))]
    marks, files = [], []
    for done, (station, stop, take, path) in enumerate(paths, start=1):
        found = _line(path, target)
        files.append(input_file(path, refused=found if isinstance(found, str) else ""))
        if isinstance(found, tuple):
            u, v, sigma = found
            across, name = np.tile([1.0, 0.0], (u.size, 1)), f"station {station}, stop {stop}"
            name += f", take {take}" if take else ""
            roll, axial = float(scan.angular.clock(stop)) + np.pi, float(scan.motion.axial(station))
            file = len(target.files) + len(files) - 1
            marks.append(Marks(name, u, v, across, sigma, axial, roll, file=file))
        if progress is not None:
            progress(done, len(paths))
    return marks, files


def _line(path: Path, target: ProfileTarget) -> tuple[Array, Array, Array] | str:
    """u, v, sigma of the line, rows averaged in strips; or why there is none."""
    from calibore.stripe import detect_line

    try:
        picture = read_image(path)
    except ImageError as error:
        return str(error)
    camera = target.rig.camera
    if picture.shape[:2] != (camera.height, camera.width):
        return f"it is {picture.shape[1]} x {picture.shape[0]} px, the rig's camera {camera.width} x {camera.height} px"
    strips = picture.shape[0] // ROWS
    mean = picture[: strips * ROWS].reshape(strips, ROWS, *picture.shape[1:]).mean(axis=1)
    turned = np.ascontiguousarray(np.rint(mean).astype(picture.dtype).swapaxes(0, 1))
    stripe = detect_line(turned, channel=target.rig.lasers[0].channel or "red")
    found = stripe.found & np.isfinite(stripe.u_position) & (stripe.u_position > 0)
    if np.count_nonzero(found) < FEWEST_MARKS:
        return "it shows no line of the laser"
    v = np.arange(strips) * ROWS + (ROWS - 1) / 2
    return stripe.v[found], v[found], stripe.u_position[found]
