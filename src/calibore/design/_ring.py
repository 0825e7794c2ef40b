"""What a rig makes of round walls, all its lasers together."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._fusion import combine_lasers
from calibore.design._prediction import Prediction, predict_on_wall
from calibore.lasers import Beam
from calibore.rigs import Rig, SideFacing
from calibore.uncertainty import FIRST_ORDER_FROM

Array = NDArray[np.float64]
CLOCKS = 360


@dataclass(frozen=True, eq=False)
class RingPrediction:
    """At `clock` [rad] on walls of `radius` [m], arrays of one shape: standard uncertainties [m], the `margin` of the
    `laser` that weighs most (-1: none measures), which share each laser's `predictions` have.
    """

    clock: Array
    radius: Array
    u_radius: Array
    u_independent: Array
    u_common: Array
    u_axial: Array
    margin: Array
    laser: NDArray[np.intp]
    predictions: tuple[Prediction, ...]

    @property
    def first_order(self) -> NDArray[np.bool_]:
        """Where the laser that weighs most is far enough from the frontier (m >= 4)."""
        return (self.laser >= 0) & (self.margin >= FIRST_ORDER_FROM)


def ring_clocks(rig: Rig, n: int = CLOCKS) -> Array:
    """`n` clocks round the pipe [rad]; those of the beams where a rig lights nothing else; one clock for heads that
    turn, which measure all clocks alike.
    """
    beams = [laser.surface for laser in rig.lasers if isinstance(laser.surface, Beam)]
    if beams:
        return np.array([beam.clock % (2 * np.pi) for beam in beams])
    n = 1 if isinstance(rig.mount, SideFacing) else n
    return np.linspace(0.0, 2 * np.pi, n, endpoint=False)


def predict_ring(rig: Rig, clock: ArrayLike, radius: ArrayLike, *, assumptions: Assumptions = HONEST) -> RingPrediction:
    """At `clock` and `radius`, broadcast; for spot arrays the last axis of `clock` is the beams."""
    clock, radius = np.broadcast_arrays(np.asarray(clock, dtype=float), np.asarray(radius, dtype=float))
    noise = {"u_pixel": assumptions.u_pixel, "direction": assumptions.direction}
    if isinstance(rig.lasers[0].surface, Beam):
        return _of_beams(rig, clock, radius, noise)
    each = tuple(predict_on_wall(rig, clock, radius, laser=laser, **noise) for laser in range(len(rig.lasers)))
    both = combine_lasers(each, rule=assumptions.rule)
    u_axial, margin = (_chosen(np.stack(a), both.laser) for a in ([p.u_axial for p in each], [p.margin for p in each]))
    return RingPrediction(
        clock, radius, both.u_radius, both.u_independent, both.u_common, u_axial, margin, both.laser, each
    )


def _of_beams(rig: Rig, clock: Array, radius: Array, noise: dict) -> RingPrediction:
    """Each beam lights its own clock."""
    each = [
        predict_on_wall(rig, clock[..., laser], radius[..., laser], laser=laser, **noise)
        for laser in range(len(rig.lasers))
    ]
    seen = np.stack([one.measurable for one in each], axis=-1)

    def gathered(parts: list[Array]) -> Array:
        return np.where(seen, np.stack(parts, axis=-1), np.nan)

    return RingPrediction(
        clock,
        radius,
        gathered([one.u_radius for one in each]),
        gathered([one.of_radius.independent for one in each]),
        gathered([one.of_radius.common for one in each]),
        gathered([one.u_axial for one in each]),
        gathered([one.margin for one in each]),
        np.where(seen, np.arange(len(each)), -1),
        tuple(each),
    )


def _chosen(values: Array, laser: NDArray[np.intp]) -> Array:
    taken = np.take_along_axis(values, np.maximum(laser, 0)[None], axis=0)[0]
    return np.where(laser >= 0, taken, np.nan)
