"""Calibration targets as a laboratory would photograph or read them, with the truth beside them.

`simulate_target`   the folder of a `Target`: photographs or tables, target.toml, truth.npz
`RingTarget`, `RangeTarget`, `GaugeTarget` of `Gauge`s, `PinTarget`, `BoardTarget` with `held_boards`, `ProbeTarget`
"""

from calibore.simulation._targets._boards import BoardTarget, held_boards
from calibore.simulation._targets._gauges import Gauge, GaugeTarget
from calibore.simulation._targets._pins import PinTarget
from calibore.simulation._targets._probe import ProbeTarget
from calibore.simulation._targets._range import RangeTarget
from calibore.simulation._targets._rings import RingTarget
from calibore.simulation._targets._target import Target, simulate_target

__all__ = [
    "BoardTarget",
    "Gauge",
    "GaugeTarget",
    "PinTarget",
    "ProbeTarget",
    "RangeTarget",
    "RingTarget",
    "Target",
    "held_boards",
    "simulate_target",
]
