"""A candidate appraised: how well it measures the pipe, how much of it, how small a one, and how large it is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._candidates import CONES, Candidate, inputs_of
from calibore.design._occlusion import occlusion
from calibore.design._requirement import Requirement
from calibore.design._ring import RingPrediction, predict_ring, ring_clocks
from calibore.errors import InputError
from calibore.rigs import Rig, SideFacing
from calibore.uncertainty import FIRST_ORDER_FROM

Array = NDArray[np.float64]
COVERAGE_FACTOR = 2.0
"""k of U95 (JCGM 100, 6.3.3)."""
CLOCKS, CLOCKS_OF_CONES = 72, 360
"""Positions round the wall; where one laser of a dual cone takes over from the other, gaps can be 2 deg wide."""
RANGE, BELOW, ROUNDS = 5, 8, 3
"""Radii in the pipe's range; steps below it, and how often they are divided anew."""


@dataclass(frozen=True)
class Design:
    """A candidate with what it achieves, SI: `u95` of the radius, worst over the measured clocks and the pipe's range,
    at `worst_clock` and `worst_radius`; `smallest_radius` measured all round; `occlusion` angle; `length`, `diameter`;
    `coverage`: share of the clocks measured over the whole range.
    """

    candidate: Candidate
    u95: float
    smallest_radius: float
    occlusion: float
    length: float
    diameter: float
    coverage: float
    worst_clock: float
    worst_radius: float

    @property
    def costs(self) -> Array:
        """(4,) less is better: U95, smallest radius, minus occlusion angle, length."""
        return np.array([self.u95, self.smallest_radius, -self.occlusion, self.length])


def appraise(candidate: Candidate, wanted: Requirement) -> Design | None:
    """What `candidate` achieves in the pipe; None where it cannot be built, passed through it, or measures nothing."""
    try:
        rig = candidate.rig(wanted)
    except InputError:
        return None
    aim = rig.mount.aim if isinstance(rig.mount, SideFacing) else 0.0
    if not candidate.fits(wanted, aim):
        return None
    diameter = candidate.diameter(wanted.laser, aim)
    steps = CLOCKS_OF_CONES if candidate.configuration in CONES else CLOCKS
    clock, radii = ring_clocks(rig, steps)[:, None], np.linspace(*wanted.radii, RANGE)
    ring = predict_ring(rig, clock, radii, assumptions=inputs_of(wanted))
    covered = np.asarray(ring.first_order.all(axis=1))
    if not covered.any():
        return None
    u = np.where(covered[:, None], ring.u_radius, -np.inf)
    worst = np.unravel_index(int(np.argmax(u)), u.shape)
    return Design(
        candidate,
        u95=COVERAGE_FACTOR * float(u[worst]),
        smallest_radius=_smallest(rig, clock[covered], wanted, least=diameter / 2),
        occlusion=_occlusion(rig, ring, covered, wanted),
        length=candidate.length(wanted.laser),
        diameter=diameter,
        coverage=float(covered.mean()),
        worst_clock=float(clock[worst[0], 0]),
        worst_radius=float(radii[worst[1]]),
    )


def _smallest(rig: Rig, clock: Array, wanted: Requirement, *, least: float) -> float:
    """The least radius [m] from which on every larger one is measured at every `clock`; not below `least`, where the
    rig itself is.
    """
    low, high = least, wanted.radii[0]
    for _ in range(ROUNDS):
        radii = np.linspace(high, low, BELOW + 1)
        good = predict_ring(rig, clock, radii, assumptions=inputs_of(wanted)).first_order.all(axis=0)
        if good.all():
            return float(radii[-1])
        first_bad = int(np.argmin(good))
        high, low = radii[max(first_bad - 1, 0)], radii[first_bad]
    return float(high)


def _occlusion(rig: Rig, ring: RingPrediction, covered: NDArray[np.bool_], wanted: Requirement) -> float:
    """The least angle [rad] between wall and ray, to camera or light, over the covered clocks; at each clock of the
    laser that is best off among those that measure there.
    """
    angles = [np.minimum(one.camera, one.light) for one in occlusion(rig, nominal_radius=wanted.nominal_radius)]
    middle = RANGE // 2
    sure = [(one.measurable & (one.margin >= FIRST_ORDER_FROM))[:, middle] for one in ring.predictions]
    each = len(covered) // len(angles[0])
    best = np.max([np.where(at[::each], angle, -np.inf) for angle, at in zip(angles, sure, strict=True)], axis=0)
    return float(best[covered[::each] & np.isfinite(best)].min(initial=np.pi / 2))
