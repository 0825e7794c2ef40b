"""Uncertainty round the pipe, against the measured radius, and against the lengths a rig is built to."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._ring import predict_ring, ring_clocks
from calibore.design._study import Study
from calibore.rigs import Rig

Array = NDArray[np.float64]
POINTS = 41
MEASUREMENTS = (0.5, 2.0)  # nominal radii, as far as published
USEFUL = 3.0
"""Clocks at which u is more than so many times that of the middle clock are no part of what a rig is built for."""


@dataclass(frozen=True, eq=False)
class RoundPipe:
    """Standard uncertainties [m] at `clock` (c,) [rad] on the nominal wall; `margin`; NaN where nothing measures."""

    clock: Array
    u_radius: Array
    u_independent: Array
    u_common: Array
    u_axial: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Sweep:
    """Standard uncertainty of the radius against `values` (n,): at the `best`, the `middle` (median) and the `worst`
    clock of those that measure at first order and are useful, and the `fraction` of the clocks that are.
    """

    name: str
    values: Array
    best: Array
    middle: Array
    worst: Array
    fraction: Array


def round_pipe(rig: Rig, *, radius: float, assumptions: Assumptions = HONEST) -> RoundPipe:
    """On the wall of `radius` [m]."""
    clock = ring_clocks(rig)
    ring = predict_ring(rig, clock, radius, assumptions=assumptions)
    return RoundPipe(clock, ring.u_radius, ring.u_independent, ring.u_common, ring.u_axial, ring.margin)


def against_radius(rig: Rig, *, nominal_radius: float, assumptions: Assumptions = HONEST) -> Sweep:
    """Walls from 0.5 to 2 nominal radii; `values` in nominal radii."""
    scale = np.linspace(*MEASUREMENTS, POINTS)
    clock = ring_clocks(rig, 120)
    ring = predict_ring(rig, clock, scale[:, None] * nominal_radius, assumptions=assumptions)
    return _summed("radius", scale, [_useful(u, ok) for u, ok in zip(ring.u_radius, ring.first_order, strict=True)])


def against_baseline(study: Study) -> Sweep:
    """The nominal wall, each rig built anew; `values` in nominal radii."""
    return _against(study, "baseline", study.baselines(POINTS))


def against_projection(study: Study) -> Sweep | None:
    """The same over projections; None for rigs that have none."""
    values = study.projections(POINTS)
    return _against(study, "projection", values) if values.size else None


def useful_clocks(u: Array, first_order: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where first order holds and u is at most `USEFUL` times its median over those places."""
    good = first_order & np.isfinite(u)
    return good & (u <= USEFUL * np.median(u[good])) if good.any() else good


def _against(study: Study, name: str, values: Array) -> Sweep:
    rigs = study.varied(name, values)
    return _summed(name, values, [_on_wall(rig, study.nominal_radius, study.inputs) for rig in rigs])


def _on_wall(rig: Rig | None, radius: float, assumptions: Assumptions) -> tuple[Array, float]:
    if rig is None:
        return np.zeros(0), 0.0
    ring = predict_ring(rig, ring_clocks(rig, 120), radius, assumptions=assumptions)
    return _useful(ring.u_radius, ring.first_order)


def _useful(u: Array, first_order: NDArray[np.bool_]) -> tuple[Array, float]:
    good = useful_clocks(u, first_order)
    return u[good], float(good.mean())


def _summed(name: str, values: Array, found: Sequence[tuple[Array, float]]) -> Sweep:
    def over(summary: Callable[[Array], np.floating]) -> Array:
        return np.array([float(summary(u)) if u.size else np.nan for u, _ in found])

    return Sweep(name, values, over(np.min), over(np.median), over(np.max), np.array([share for _, share in found]))
