"""Where in an image the ring of one laser is looked for, and finding its line there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.errors import ImageError, InputError
from calibore.rigs import Rig, project_ring
from calibore.stripe import Stripe, detect_ring

Array = NDArray[np.float64]
OUTLINE = 128
"""Points with which the nominal ring is outlined in the image."""
NARROWEST = 8.0
"""Least width [px] of the annulus a ring is looked for in: twice the width of a line."""

WIDEST = 1.5
"""Farthest that a line is looked for on the side of a cone's apex, over the nominal ring: a wall near the apex is
imaged anywhere, and an annulus much wider than the ring spoils what is learnt from neighbouring rays."""


@dataclass(frozen=True)
class Search:
    """Where in the image the ring is looked for: rough `centre` (column, row), radii `inner` to `outer` [px]."""

    centre: tuple[float, float]
    inner: float
    outer: float

    def __str__(self) -> str:
        column, row = self.centre
        return f"looked for {self.inner:.0f} to {self.outer:.0f} px from column {column:.0f}, row {row:.0f}"


def search_region(rig: Rig, nominal_radius: float, *, inner: float, outer: float, laser: int = 0) -> Search:
    """The annulus that holds every ring of `laser` on a wall of radius `inner` to `outer` times `nominal_radius` [m].

    A wall further out is not always imaged further out: towards the side of a cone's apex it is imaged further in.
    """
    _, u, v = project_ring(rig, nominal_radius, OUTLINE, laser=laser)
    seen = np.isfinite(u)
    if not seen.any():
        raise InputError(
            f"The rig's camera cannot see a pipe of radius {nominal_radius:g} m in its laser light; "
            "check nominal_radius, baseline, lens and k."
        )
    centre = (float(u[seen].mean()), float(v[seen].mean()))
    near, far = (_distances(rig, nominal_radius * factor, centre, laser) for factor in (inner, outer))
    right, low = rig.camera.width, rig.camera.height
    corners = np.array([[0, 0], [0, low], [right, 0], [right, low]])
    corner = float(np.hypot(*(corners - centre).T).max())
    least = float(min(near.min(initial=np.inf), far.min(initial=np.inf))) if near.size else 0.0
    most = min(_outermost(near, far, np.hypot(u - centre[0], v - centre[1])[seen]), corner)
    search = Search(centre, least, most)
    beside = float(np.hypot(*np.maximum(np.maximum(-np.array(centre), centre - corners[-1]), 0)))
    if max(least, beside) + NARROWEST > most:
        raise InputError(
            f"A pipe of radius {nominal_radius:g} m leaves no room for its ring in the image of {rig.camera.width} x "
            f"{rig.camera.height} px ({search}); check nominal_radius, baseline, lens, k and principal_point."
        )
    return search


def _outermost(near: Array, far: Array, nominal: Array) -> float:
    """The largest distance [px] of a ring: that of the far wall, unless a near one is imaged further out."""
    outermost = float(far.max()) if far.size == OUTLINE else np.inf
    if near.size and near.max() > outermost:
        return min(float(near.max()), WIDEST * float(nominal.max()))
    return outermost


def _distances(rig: Rig, radius: float, centre: tuple[float, float], laser: int) -> Array:
    _, u, v = project_ring(rig, radius, OUTLINE, laser=laser)
    distance = np.hypot(u - centre[0], v - centre[1])
    return distance[np.isfinite(distance)]


def find_line(image: NDArray[np.generic], rig: Rig, search: Search, *, channel: str, estimator: str) -> Stripe:
    """The line in one image of the rig's camera; raises ImageError where there is none."""
    check_size(image, rig)
    try:
        return detect_ring(
            image, search.centre, inner=search.inner, outer=search.outer, channel=channel, estimator=estimator
        )
    except ImageError as error:
        why = str(error).rstrip(".")
        raise ImageError(
            f"{why[:1].lower()}{why[1:]} ({exposure(image, channel)}, {search}); check exposure, laser.channel and "
            "pipe.nominal_radius"
        ) from error


def check_size(image: NDArray[np.generic], rig: Rig) -> None:
    """Raise ImageError where `image` was not taken by the rig's camera."""
    height, width = image.shape[:2]
    if (width, height) != (rig.camera.width, rig.camera.height):
        raise ImageError(
            f"it is {width} x {height} px but the rig's camera has {rig.camera.width} x {rig.camera.height} px; "
            "use the rig file of the camera that took it"
        )


def exposure(image: NDArray[np.generic], channel: str) -> str:
    """What somebody who looks for a line in vain wants to know first: "red values 0 to 12 of 255"."""
    colours = ("red", "green", "blue")
    seen = image[:, :, colours.index(channel)] if image.ndim == 3 and channel in colours else image
    name = channel if image.ndim == 3 else "grey"
    low, high, white = int(seen.min()), int(seen.max()), 2 ** (8 * image.dtype.itemsize) - 1
    if low == high:
        return f"every {name} value is {low} of {white}"
    return f"{name} values {low} to {high} of {white}"
