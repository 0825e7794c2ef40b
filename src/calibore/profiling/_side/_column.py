"""A strip of wall at one clock position: R along the pipe on the axial grid."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._grid import SLOPE_REACH, Places, average
from calibore.profiling._take import TakePoints
from calibore.profiling._takes import correlation_of, mixed
from calibore.status import Status, has_value
from calibore.stripe import Stripe
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """Rows `first` ... `first` + n of the axial grid at one clock position, m modes; NaN where nothing was measured.

    `radius`, `u` (independent) (n,) [m]; `modes` (m, n) [m]; `offset` (n,) [rad] of the points from the grid's clock,
    `turns` (m, n) [rad] its common modes; `status` (n,); `correlation` (k,) of the independent part at lags of 1 ... k
    rows.
    """

    first: int
    radius: Array
    u: Array
    modes: Array
    offset: Array
    turns: Array
    status: NDArray[np.uint8]
    correlation: Array

    @property
    def end(self) -> int:
        return self.first + self.radius.size


@dataclass(frozen=True)
class Strip:
    """One picture: its points `take`, and for each of its n rows the axial position `axial` (n,) [m], given for rows
    without a point too, and the `offset` (n,) [rad] from the clock of the grid.
    """

    take: TakePoints
    axial: Array
    offset: Array


def column_of(
    strip: Strip, covariance: Covariance, *, step: float, rows: tuple[int, int], stripe: float | None
) -> Column:
    """The `rows` (first, end) of the grid of `step` [m] that the rows of the picture fall on."""
    first, end = rows
    points, count = strip.take.points, end - first
    nearest = np.rint(strip.axial / step)
    along = np.einsum("nk,nk->n", points.axial_sensitivities.pixel, strip.take.stripe.direction)
    # the grid of rings is closed: enough empty rows keep the ends of this one apart
    home = np.clip(nearest.astype(np.intp) - first, 0, count - 1)
    places = Places(
        home, strip.axial - nearest * step, along, points.axial_sensitivities.parameters, step, count + 2 * SLOPE_REACH
    )
    at = average(strip.take, places, covariance, stripe=stripe)
    turns = np.stack([at.mean(by) for by in points.clock_sensitivities.parameters.T], axis=1)
    return Column(
        first,
        at.radius[:count],
        at.u[:count],
        at.modes[:, :count],
        at.mean(strip.offset)[:count],
        propagate(turns[:count], covariance, names=points.parameter_names).modes,
        at.status[:count],
        at.correlation,
    )


def rows_of(strips: list[Strip], step: float) -> tuple[int, int]:
    """First and end row of the grid of `step` [m] that the points of `strips` fall on."""
    axial = np.concatenate([strip.axial[has_value(strip.take.status)] for strip in strips])
    rows = np.rint(axial / step).astype(np.intp)
    return int(rows.min()), int(rows.max()) + 1


def one_of_takes(columns: list[Column], stripes: list[Stripe]) -> tuple[Column, float]:
    """The takes of one stop, on the same rows, as one column, and their correlation (NaN of a single take)."""
    if len(columns) == 1:
        return columns[0], float("nan")
    lines = correlation_of(np.stack([one.u for one in stripes]), np.stack([one.u_position for one in stripes]))
    radius, u, status = (np.stack([getattr(column, name) for column in columns]) for name in ("radius", "u", "status"))
    takes = mixed(radius, u, status, otherwise=lines)
    modes, offset, turns = (
        takes.mean([getattr(one, name) for one in columns]) for name in ("modes", "offset", "turns")
    )
    correlation = np.mean([column.correlation for column in columns], axis=0)
    first = columns[0].first
    return Column(first, takes.radius, takes.u, modes, offset, turns, takes.status, correlation), takes.shared


def empty_column(first: int, end: int, modes: int) -> Column:
    """A column of which nobody has taken a picture."""
    count = end - first
    gone, none = np.full(count, np.nan), np.full((modes, count), np.nan)
    status = np.full(count, Status.NO_IMAGE, dtype=np.uint8)
    return Column(first, gone, gone, none, gone, none, status, np.zeros(0))
