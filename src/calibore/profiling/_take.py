"""One image of one station: find the line, triangulate it, say how well each point is known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.rigs import Rig, Triangulation, project_ring, triangulate
from calibore.status import Status
from calibore.stripe import Stripe, detect_ring

Array = NDArray[np.float64]
OUTLINE = 128
"""Points with which the nominal ring is outlined in the image."""
NARROWEST = 8.0
"""Least width [px] of the annulus a ring is looked for in: twice the width of a line."""


@dataclass(frozen=True)
class Search:
    """Where in the image the ring is looked for: rough `centre` (column, row), radii `inner` to `outer` [px]."""

    centre: tuple[float, float]
    inner: float
    outer: float

    def __str__(self) -> str:
        column, row = self.centre
        return f"looked for {self.inner:.0f} to {self.outer:.0f} px from column {column:.0f}, row {row:.0f}"


@dataclass(frozen=True)
class TakePoints:
    """The rays of one image as wall points in the rig frame, n rays in order round the ring.

    `clock` [rad] is given for rays without a point too (interpolated). `along` (n,) [m/px]: radius per pixel along the
    ray the peak was measured on, at fixed clock; `turn` (n,) [rad/px]: clock per pixel along it. `u_position` (n,) [px]
    """

    points: Triangulation
    clock: Array
    along: Array
    turn: Array
    u_position: Array
    status: NDArray[np.uint8]
    stripe: Stripe


def search_region(rig: Rig, nominal_radius: float, *, inner: float, outer: float) -> Search:
    """The annulus that holds every ring of radius `inner` to `outer` times `nominal_radius` [m] about the rig axis."""
    _, u, v = project_ring(rig, nominal_radius, OUTLINE)
    seen = np.isfinite(u)
    if not seen.any():
        raise InputError(
            f"The rig's camera cannot see a pipe of radius {nominal_radius:g} m in its laser plane; "
            "check nominal_radius, baseline, lens and k."
        )
    centre = (float(u[seen].mean()), float(v[seen].mean()))
    near, far = (_distances(rig, nominal_radius * factor, centre) for factor in (inner, outer))
    right, low = rig.camera.width, rig.camera.height
    corners = np.array([[0, 0], [0, low], [right, 0], [right, low]])
    corner = float(np.hypot(*(corners - centre).T).max())
    least = float(near.min()) if near.size else 0.0
    most = min(float(far.max()) if far.size == OUTLINE else corner, corner)
    search = Search(centre, least, most)
    beside = float(np.hypot(*np.maximum(np.maximum(-np.array(centre), centre - corners[-1]), 0)))
    if max(least, beside) + NARROWEST > most:
        raise InputError(
            f"A pipe of radius {nominal_radius:g} m leaves no room for its ring in the image of {rig.camera.width} x "
            f"{rig.camera.height} px ({search}); check nominal_radius, baseline, lens, k and principal_point."
        )
    return search


def _distances(rig: Rig, radius: float, centre: tuple[float, float]) -> Array:
    _, u, v = project_ring(rig, radius, OUTLINE)
    distance = np.hypot(u - centre[0], v - centre[1])
    return distance[np.isfinite(distance)]


def measure_take(image: NDArray[np.generic], rig: Rig, search: Search, *, channel: str, estimator: str) -> TakePoints:
    """Wall points of one image; raises ImageError where it cannot be used."""
    return place_on_wall(find_line(image, rig, search, channel=channel, estimator=estimator), rig)


def find_line(image: NDArray[np.generic], rig: Rig, search: Search, *, channel: str, estimator: str) -> Stripe:
    """The line in one image of the rig's camera; raises ImageError where there is none."""
    height, width = image.shape[:2]
    if (width, height) != (rig.camera.width, rig.camera.height):
        raise ImageError(
            f"it is {width} x {height} px but the rig's camera has {rig.camera.width} x {rig.camera.height} px; "
            "use the rig file of the camera that took it"
        )
    try:
        return detect_ring(
            image, search.centre, inner=search.inner, outer=search.outer, channel=channel, estimator=estimator
        )
    except ImageError as error:
        why = str(error).rstrip(".")
        raise ImageError(
            f"{why[:1].lower()}{why[1:]} ({_exposure(image, channel)}, {search}); check exposure, laser.channel and "
            "pipe.nominal_radius"
        ) from error


def place_on_wall(stripe: Stripe, rig: Rig) -> TakePoints:
    """The line as points of the wall; raises ImageError where none of it lies on the laser's surface."""
    points = triangulate(rig, stripe.u, stripe.v)
    status = np.where(points.status == Status.OK, stripe.status, points.status)
    status = np.where(stripe.found, status, stripe.status).astype(np.uint8)
    along = np.einsum("nk,nk->n", points.radius_sensitivities.pixel, stripe.direction)
    turn = np.einsum("nk,nk->n", points.clock_sensitivities.pixel, stripe.direction)
    return TakePoints(points, _every_clock(points.clock), along, turn, stripe.u_position, status, stripe)


def _exposure(image: NDArray[np.generic], channel: str) -> str:
    """What somebody who looks for a line in vain wants to know first: "red values 0 to 12 of 255"."""
    colours = ("red", "green", "blue")
    seen = image[:, :, colours.index(channel)] if image.ndim == 3 and channel in colours else image
    name = channel if image.ndim == 3 else "grey"
    low, high, white = int(seen.min()), int(seen.max()), 2 ** (8 * image.dtype.itemsize) - 1
    if low == high:
        return f"every {name} value is {low} of {white}"
    return f"{name} values {low} to {high} of {white}"


def _every_clock(clock: Array) -> Array:
    """`clock` (n,) with its gaps interpolated round the ring."""
    index, found = np.arange(clock.size), np.flatnonzero(np.isfinite(clock))
    if found.size == 0:
        raise ImageError("no point of its line lies on the laser plane in front of the camera; check the rig file")
    turns = np.unwrap(clock[found])
    sense = np.sign(turns[-1] - turns[0]) or 1.0
    before, after = found[-1] - clock.size, found[0] + clock.size
    places = np.concatenate([[before], found, [after]])
    values = np.concatenate([[turns[-1] - sense * 2 * np.pi], turns, [turns[0] + sense * 2 * np.pi]])
    return np.mod(np.interp(index, places, values), 2 * np.pi)
