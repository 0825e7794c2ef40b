"""One station from its images to its profile, its points and its row of ring quantities."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import partial

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError
from calibore.geometry import clock_of
from calibore.images import ImageFileError, Pixels, StationImages
from calibore.metrics import RingQuantities, RingShape, ring_quantities
from calibore.profiling._grid import Ring, grid_ring
from calibore.profiling._placement import Placement
from calibore.profiling._take import Search, TakePoints, find_line, measure_take, place_on_wall, search_region
from calibore.profiling._takes import combine_takes
from calibore.rigs import Rig
from calibore.scans import RingPoints, RingProfile, ScanSpec
from calibore.stripe import Stripe
from calibore.uncertainty import Covariance, Quantity, propagate

Array = NDArray[np.float64]
NOT_LIT = "laser.takes in the rig file does not name this take; correct one of them"
UNITS = {"area": "_m2", "clock": "_rad", "ovality": "_percent", "deflection": "_percent"}


@dataclass(frozen=True)
class Job:
    """What all stations share. `covariance` is the rig's, of parameters common to the scan."""

    rig: Rig
    covariance: Covariance
    search: Search
    channel: str
    estimator: str
    nominal_radius: float

    @classmethod
    def of(cls, rig: Rig, nominal_radius: float, *, channel: str = "red", estimator: str = "zero-crossing") -> "Job":
        """For pictures taken with `rig` in a pipe of `nominal_radius` [m], searched as wide as scans are by default."""
        rig = rig.with_default_uncertainty(nominal_radius)
        search = search_region(rig, nominal_radius, inner=ScanSpec.search_inner, outer=ScanSpec.search_outer)
        return cls(rig, rig.covariance or Covariance.independent({}), search, channel, estimator, nominal_radius)


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


@dataclass(frozen=True)
class StationResult:
    """What one station gave; `refused` images could not be used; `first_image` reads the first used one again."""

    profile: RingProfile
    points: RingPoints
    row: dict[str, float | int | str]
    quantities: RingQuantities
    take_correlation: float
    scale: float
    takes: tuple[TakePoints, ...]
    refused: tuple[RefusedImage, ...]
    first_image: Callable[[], Pixels]


def measure_image(image: Pixels, job: Job) -> Ring:
    """The ring in one picture (h, w) or (h, w, 3) on the clock grid; raises ImageError where there is none."""
    take = measure_take(image, job.rig, job.search, channel=job.channel, estimator=job.estimator)
    return grid_ring(take, job.covariance, stripe=job.rig.stripe)


@dataclass(frozen=True)
class StationLines:
    """The lines found in the images of one station: `stripes` in the takes `numbers`; `refused` images had none."""

    images: StationImages
    numbers: tuple[int, ...]
    stripes: tuple[Stripe, ...]
    refused: tuple[RefusedImage, ...]


def find_lines(images: StationImages, job: Job) -> StationLines:
    """Read the images of a station and find the line in each; an image that cannot be used is refused.

    Takes in which the rig's laser is not lit (`Laser.takes`) are no part of it. Nearly all of this runs in compiled
    code that does not hold Python's lock, so it gains from threads; the rest of a station would only wait for the lock.
    """
    lit = [number for number in images.takes if job.rig.lasers[0].is_lit(number)]
    refused = [] if lit else [RefusedImage(images.name(number), NOT_LIT) for number in images.takes]
    numbers, stripes = [], []
    for number in lit:
        try:
            picture = images.read(number)
            stripes.append(find_line(picture, job.rig, job.search, channel=job.channel, estimator=job.estimator))
            numbers.append(number)
        except ImageError as error:
            refused.append(_refusal(images.name(number), error))
    return StationLines(images, tuple(numbers), tuple(stripes), tuple(refused))


def _refusal(name: str, error: ImageError) -> RefusedImage:
    reason = error.reason if isinstance(error, ImageFileError) else str(error)
    return RefusedImage(name, reason.rstrip("."))


def measure_station(images: StationImages, placement: Placement, job: Job) -> StationResult:
    """Everything of one station; raises StationRefusedError where none of its images can be used."""
    return evaluate_station(find_lines(images, job), placement, job)


def evaluate_station(lines: StationLines, placement: Placement, job: Job) -> StationResult:
    """Everything that follows from the lines of one station; raises StationRefusedError where none is of use."""
    images, refused = lines.images, list(lines.refused)
    takes: list[TakePoints] = []
    numbers: list[int] = []
    for number, stripe in zip(lines.numbers, lines.stripes, strict=True):
        try:
            takes.append(place_on_wall(stripe, job.rig))
            numbers.append(number)
        except ImageError as error:
            refused.append(_refusal(images.name(number), error))
    if not takes:
        raise StationRefusedError(refused)
    rings = [grid_ring(take, job.covariance, stripe=job.rig.stripe) for take in takes]
    ring, shared = combine_takes(rings)
    shape = RingShape(ring.clock, ring.radius, ring.u, ring.modes, ring.correlation)
    quantities = ring_quantities(shape, nominal_radius=job.nominal_radius, roll=placement.roll)
    return StationResult(
        _profile(images.station, placement, ring, quantities),
        _points(takes, numbers, placement, job.covariance),
        ring_row(quantities, takes=len(takes)),
        quantities,
        shared,
        float(np.mean([take.stripe.scale for take in takes])),
        tuple(takes),
        tuple(refused),
        partial(images.read, numbers[0]),
    )


def _profile(station: int, placement: Placement, ring: Ring, quantities: RingQuantities) -> RingProfile:
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


def _points(takes: list[TakePoints], numbers: list[int], placement: Placement, covariance: Covariance) -> RingPoints:
    """Every ray of every take, in the pipe frame; rays without a point are kept with the status that says why."""
    pose = placement.pipe_from_rig
    columns: dict[str, list[Array]] = {name.name: [] for name in fields(RingPoints)}
    for number, take in zip(numbers, takes, strict=True):
        valued = np.where(np.isfinite(take.u_position), 0.0, np.nan)
        wall = pose.apply(take.points.points)
        sensitivities = take.points.radius_sensitivities.parameters
        turned = np.mod(take.clock + placement.roll, 2 * np.pi)
        common = propagate(sensitivities, covariance, names=take.points.parameter_names).u
        values = {
            "x": wall[:, 0],
            "y": wall[:, 1],
            "z": wall[:, 2],
            "radius": take.points.radius + valued,
            "clock": np.where(np.isfinite(wall[:, 0]), clock_of(wall[:, 0], wall[:, 1]), turned),
            "axial": wall[:, 2],
            "u_radius": np.hypot(take.along * take.u_position, common),
            "u": take.stripe.u,
            "v": take.stripe.v,
            "take": np.full(take.clock.size, number),
            "status": take.status,
        }
        for name, value in values.items():
            columns[name].append(value)
    joined = {name: np.concatenate(parts) for name, parts in columns.items()}
    return RingPoints(**joined)  # pyright: ignore[reportArgumentType]


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
