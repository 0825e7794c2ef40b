"""One station from its images to its profile, its points and its row of ring quantities."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.geometry import Pose, clock_of
from calibore.images import LIMIT, ImageFileError, PictureFile, Pixels, StationImages, read_image
from calibore.metrics import RingQuantities, RingShape, ring_quantities
from calibore.profiling._fusion import fuse_lasers
from calibore.profiling._grid import Ring
from calibore.profiling._job import Job
from calibore.profiling._lasers import alone_in
from calibore.profiling._line_ring import LineOnWall, WallRays, line_on_wall
from calibore.profiling._placement import Placement
from calibore.profiling._reading import stripes_in, stripes_of
from calibore.profiling._search import find_line
from calibore.profiling._takes import combine_takes
from calibore.scans import RingPoints, RingProfile
from calibore.stripe import Stripe
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]
NOT_LIT = "laser.takes in the rig file does not name this take for one laser alone; correct one of them"
UNITS = {"area": "_m2", "clock": "_rad", "ovality": "_percent", "deflection": "_percent"}


@dataclass(frozen=True)
class RefusedImage:
    """An image that could not be used: `name` as a person would look for it, and why."""

    name: str
    reason: str


class StationRefusedError(ImageError):
    """None of a station's images can be used."""

    def __init__(self, images: Sequence[RefusedImage]) -> None:
        super().__init__("; ".join(f"{image.name}: {image.reason}" for image in images))
        self.images = tuple(images)

    def __reduce__(self) -> tuple[type, tuple[tuple[RefusedImage, ...]]]:
        return type(self), (self.images,)


class Line(NamedTuple):
    """The line of `laser` in one `take`. `displacement` (n, 3) [m], rig frame: how far its points lie from where they
    would if the rig had stood still.
    """

    take: int
    laser: int
    stripe: Stripe
    displacement: Array | None = None


@dataclass(frozen=True)
class StationResult:
    """What one station gave; `refused` images could not be used; `unlit` takes show no laser alone, as the rig file
    says; `first_image` reads the first used one again. `images`: how many were used, with a line of each laser alone:
    `lines`.
    """

    profile: RingProfile
    points: RingPoints
    row: dict[str, float | int | str]
    quantities: RingQuantities
    take_correlation: float
    scale: float
    lines: tuple[Line, ...]
    refused: tuple[RefusedImage, ...]
    first_image: Callable[[], Pixels]
    images: int
    unlit: tuple[int, ...] = ()


def measure_image(image: Pixels | Path, job: Job, *, laser: int = 0) -> Ring:
    """The ring of one laser in one picture (h, w) or (h, w, 3), or its file, on the clock grid; raises ImageError if
    there is none. The other lasers of the rig must be dark, or of another colour.
    """
    look = job.looks[laser]
    if isinstance(image, Path):
        (stripe,) = stripes_of(PictureFile(image, LIMIT), partial(read_image, image), job, [look])
    else:
        stripe = find_line(image, job.rig, look.search, channel=look.channel, estimator=job.estimator)
    return line_on_wall(stripe, job.rig, laser=laser, prior_radius=job.nominal_radius).ring


@dataclass(frozen=True)
class StationLines:
    """The `lines` found in the images of one station; `refused` images had none; `unlit` takes were not looked at."""

    images: StationImages
    lines: tuple[Line, ...]
    refused: tuple[RefusedImage, ...]
    unlit: tuple[int, ...]


def find_lines(images: StationImages, job: Job) -> StationLines:
    """Read the images of a station and find the lines in each; an image that cannot be used is refused.

    Takes in which no laser of the rig is lit alone (`Laser.takes`) are no part of it. Nearly all of this runs in
    compiled code that does not hold Python's lock, so it gains from threads; the rest would only wait for the lock.
    """
    looks = {number: alone_in(number, job.rig, job.looks) for number in images.takes}
    unlit = tuple(number for number in images.takes if not looks[number])
    refused = [RefusedImage(images.name(number), NOT_LIT) for number in unlit] if len(unlit) == len(looks) else []
    lines = []
    for number in (number for number in images.takes if looks[number]):
        try:
            for look, stripe in zip(looks[number], stripes_in(images, number, job, looks[number]), strict=True):
                lines.append(Line(number, look.laser, stripe))
        except ImageError as error:
            refused.append(refusal_of(images.name(number), error))
    return StationLines(images, tuple(lines), tuple(refused), unlit)


def refusal_of(name: str, error: ImageError) -> RefusedImage:
    """The image called `name`, which `error` says not to be usable."""
    reason = error.reason if isinstance(error, ImageFileError) else str(error)
    return RefusedImage(name, reason.rstrip("."))


def measure_station(images: StationImages, placement: Placement, job: Job) -> StationResult:
    """Everything of one station; raises StationRefusedError where none of its images can be used."""
    return evaluate_station(find_lines(images, job), placement, job)


def evaluate_station(lines: StationLines, placement: Placement, job: Job) -> StationResult:
    """Everything that follows from the lines of one station; raises StationRefusedError where none is of use."""
    images, refused = lines.images, list(lines.refused)
    placed: list[LineOnWall] = []
    used: list[Line] = []
    for line in lines.lines:
        try:
            placed.append(_placed(line, job))
            used.append(line)
        except ImageError as error:
            refused.append(refusal_of(images.name(line.take), error))
    if not used:
        raise StationRefusedError(refused)
    numbers = [line.take for line in used]
    ring, shared = _one_ring([line.laser for line in used], [one.ring for one in placed])
    shape = RingShape(ring.clock, ring.radius, ring.u, ring.modes, ring.correlation)
    quantities = ring_quantities(shape, nominal_radius=job.nominal_radius, roll=placement.roll)
    return StationResult(
        ring_profile(images.station, placement, ring, quantities),
        wall_points([one.rays for one in placed], numbers, placement.pipe_from_rig, placement.roll),
        ring_row(quantities, takes=len(set(numbers))),
        quantities,
        shared,
        float(np.mean([line.stripe.scale for line in used])),
        tuple(used),
        tuple(refused),
        partial(images.read, numbers[0]),
        len(set(numbers)),
        lines.unlit,
    )


def _placed(line: Line, job: Job) -> LineOnWall:
    how: dict[str, Any] = {"laser": line.laser, "prior_radius": job.nominal_radius, "displacement": line.displacement}
    return line_on_wall(line.stripe, job.rig, **how)


def _one_ring(lasers: Sequence[int], takes: Sequence[Ring]) -> tuple[Ring, float]:
    """The takes of each laser combined, then the lasers fused; the mean correlation of takes of one laser, NaN where
    none has two.
    """
    rings: dict[int, list[Ring]] = {}
    for laser, ring in zip(lasers, takes, strict=True):
        rings.setdefault(laser, []).append(ring)
    combined = [combine_takes(of_laser) for of_laser in rings.values()]
    shared = [share for (_, share), of_laser in zip(combined, rings.values(), strict=True) if len(of_laser) > 1]
    return fuse_lasers([ring for ring, _ in combined]), float(np.mean(shared)) if shared else float("nan")


def ring_profile(station: int, placement: Placement, ring: Ring, quantities: RingQuantities) -> RingProfile:
    """A ring in the form in which it is stored."""
    return RingProfile(
        station=station,
        axial=placement.axial,
        clock=ring.clock,
        radius=ring.radius,
        axial_position=placement.axial + ring.axial,
        u_independent=ring.u,
        common_mode=ring.modes,
        status=ring.status,
        centre_x=quantities.centre_x.value,
        centre_y=quantities.centre_y.value,
        u_centre_x=quantities.centre_x.u,
        u_centre_y=quantities.centre_y.u,
        time_s=placement.time,
        roll=placement.roll,
        correlation=ring.correlation,
    )


def wall_points(lines: Sequence[WallRays], numbers: Sequence[int], pose: Pose, roll: float) -> RingPoints:
    """Every ray of the `lines` of takes with these `numbers`, in the pipe frame; rays without a point are kept with the
    status that says why. `pose`: pipe_from_rig, rolled by `roll` [rad].
    """

    def joined(name: str) -> Array:
        return np.concatenate([getattr(rays, name) for rays in lines])

    wall = pose.apply(joined("points"))
    x, y, z = np.ascontiguousarray(wall.T)
    turned = np.mod(joined("clock") + roll, 2 * np.pi)
    return RingPoints(
        x=x,
        y=y,
        z=z,
        radius=joined("radius"),
        clock=np.where(np.isfinite(x), clock_of(x, y), turned),
        axial=z,
        u_radius=joined("u_radius"),
        u=joined("u"),
        v=joined("v"),
        take=np.repeat(numbers, [rays.clock.size for rays in lines]),
        status=np.concatenate([rays.status for rays in lines]),
    )


def ring_row(quantities: RingQuantities, *, takes: int) -> dict[str, float | int | str]:
    """The row of rings.csv: every quantity in SI (percent where it is a percentage), each followed by its u."""
    row: dict[str, float | int | str] = {
        "takes": takes,
        "points": quantities.points,
        "fraction": quantities.fraction_measured,
        "fraction_directions": quantities.fraction_directions,
    }
    for field in fields(quantities):
        value = getattr(quantities, field.name)
        if isinstance(value, Quantity):
            name = field.name + unit_suffix(field.name)
            row[name], row[f"u_{name}"] = value.value, value.u
    row["flags"] = " ".join(quantities.flags)
    return row


def unit_suffix(name: str) -> str:
    """`"diameter_min"` -> `"_m"`, `"diameter_min_clock"` -> `"_rad"`, `"area"` -> `"_m2"`."""
    if name.endswith("_clock"):
        return "_rad"
    return UNITS.get(name.split("_")[0], "_m")
