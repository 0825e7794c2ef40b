"""Columns of one clock position from several stops of the carriage, made one where they overlap."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibore.profiling._side._column import Column
from calibore.status import Status
from calibore.uncertainty import least_variance_weights

Array = NDArray[np.float64]
DISAGREE = 4.0
"""Stops that differ by more standard uncertainties of their difference than this see different pieces of wall."""


def merged(columns: Sequence[Column]) -> Column:
    """One column over all rows of `columns`: of least variance where several stops saw one wall; where they differ,
    what agrees with their weighted median.
    """
    if len(columns) == 1:
        return columns[0]
    first, end = min(column.first for column in columns), max(column.end for column in columns)
    lanes = _lanes(columns)
    radius, u, offset = (_table(lanes, name, first, end) for name in ("radius", "u", "offset"))
    modes, turns = (_table(lanes, name, first, end) for name in ("modes", "turns"))
    status = _statuses(lanes, first, end)
    seen = np.isfinite(radius)
    usable = _agreeing(radius, u, modes, seen)
    weight = least_variance_weights(u, modes, usable)
    found = np.asarray(seen.any(axis=0))

    def mean(table: Array) -> Array:
        by = weight if table.ndim == 2 else weight[:, None, :]
        return np.where(found, np.sum(np.where(by > 0, table, 0.0) * by, axis=0), np.nan)

    total = np.where(found, np.sqrt(np.sum((weight * np.where(usable, u, 0.0)) ** 2, axis=0)), np.nan)
    return Column(
        first,
        mean(radius),
        total,
        mean(modes),
        mean(offset),
        mean(turns),
        _status(status, weight, found, seen & ~usable),
        np.mean([column.correlation for column in columns], axis=0),
    )


def _lanes(columns: Sequence[Column]) -> list[list[Column]]:
    """`columns` laid into as few lanes as keep those of one lane from overlapping."""
    lanes: list[list[Column]] = []
    for column in sorted(columns, key=lambda one: (one.first, one.end)):
        free = next((lane for lane in lanes if lane[-1].end <= column.first), None)
        if free is None:
            lanes.append([column])
        else:
            free.append(column)
    return lanes


def _table(lanes: list[list[Column]], name: str, first: int, end: int) -> Array:
    """(l, n) or (l, m, n) of one field; NaN where a lane has no column."""
    shape = getattr(lanes[0][0], name).shape[:-1]
    table = np.full((len(lanes), *shape, end - first), np.nan)
    for row, lane in zip(table, lanes, strict=True):
        for column in lane:
            row[..., column.first - first : column.end - first] = getattr(column, name)
    return table


def _statuses(lanes: list[list[Column]], first: int, end: int) -> NDArray[np.uint8]:
    table = np.full((len(lanes), end - first), Status.NO_IMAGE, dtype=np.uint8)
    for row, lane in zip(table, lanes, strict=True):
        for column in lane:
            row[column.first - first : column.end - first] = column.status
    return table


def _agreeing(radius: Array, u: Array, modes: Array, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which stops (l, n) saw the same piece of wall as their weighted median."""
    weight = np.where(seen, 1 / np.maximum(np.where(seen, u, 1.0), 1e-12) ** 2, 0.0)
    order = np.argsort(np.where(seen, radius, np.inf), axis=0, kind="stable")
    share = np.cumsum(np.take_along_axis(weight, order, 0), axis=0)
    middle = np.argmax(share >= 0.5 * share[-1], axis=0)[None]
    chosen = np.take_along_axis(order, middle, 0)
    value, doubt = np.take_along_axis(radius, chosen, 0), np.take_along_axis(u, chosen, 0)
    shared = np.take_along_axis(modes, chosen[:, None], 0)
    spread = np.sqrt(u**2 + doubt**2 + np.sum((modes - shared) ** 2, axis=1))
    return seen & (np.abs(radius - value) <= DISAGREE * spread)


def _status(
    status: NDArray[np.uint8], weight: Array, found: NDArray[np.bool_], left_out: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """The best of those that count; RESOLVED where one was left out, EXTRAPOLATED where the value is so in part.
    Without a value, the least of the reasons.
    """
    counted = np.where(weight > 0, status, 255).min(axis=0)
    counted = np.where((left_out.any(axis=0)) & (counted == Status.OK), Status.RESOLVED, counted)
    partly = ((weight > 0) & (status == Status.EXTRAPOLATED)).any(axis=0)
    reason = np.where(status == Status.NO_IMAGE, 255, status).min(axis=0)
    reason = np.where(reason == 255, Status.NO_IMAGE, reason)
    return np.where(found, np.where(partly, Status.EXTRAPOLATED, counted), reason).astype(np.uint8)
