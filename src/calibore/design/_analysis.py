"""Everything that is told of one design, together."""

from dataclasses import dataclass

from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._curves import (
    RoundPipe,
    Sweep,
    against_baseline,
    against_projection,
    against_radius,
    round_pipe,
    useful_clocks,
)
from calibore.design._deployment import Deployment, deployment
from calibore.design._limits import Limits, measuring_limits
from calibore.design._misalignment import Misalignment, misalignments
from calibore.design._occlusion import Occlusion, Shadow, occlusion, shadows
from calibore.design._regions import ImageMap, maps_of
from calibore.design._ring import predict_ring, ring_clocks
from calibore.design._shares import grouped, ring_shares
from calibore.design._study import Study
from calibore.design._tolerances import Tolerances, tolerances
from calibore.errors import InputError
from calibore.rigs import Rig
from calibore.uncertainty import Covariance

TARGET = 0.005
"""Of the nominal radius: the expanded uncertainty of a good plane rig (Swanbom 2007, section 4.5)."""
MANHOLE = 0.6096
"""[m]: 24 in, a common manhole."""
BUMP = 0.02  # of the nominal radius


@dataclass(frozen=True)
class Wishes:
    """What the design is held against [m]: `target` expanded uncertainty, `manhole` diameter, crawler `body_length` x
    `body_height`, `bump` height; None takes 0.5 % of the radius, 24 in, one diameter x one radius, 2 % of the radius.
    """

    target: float | None = None
    manhole: float | None = None
    body_length: float | None = None
    body_height: float | None = None
    bump: float | None = None


@dataclass(frozen=True, eq=False)
class Analysis:
    """One rig in a pipe of `nominal_radius` [m], and what is told of it; `study` is None for a rig that was given.

    Standard uncertainties in m; `shares` of the variance by input, correlated inputs together.
    """

    rig: Rig
    study: Study | None
    nominal_radius: float
    assumptions: Assumptions
    bump: float
    maps: list[ImageMap]
    limits: Limits
    ring: RoundPipe
    radius: Sweep
    baseline: Sweep | None
    projection: Sweep | None
    misalignment: list[Misalignment]
    occlusion: list[Occlusion]
    shadow: Shadow
    bump_shadow: Shadow
    deployment: Deployment
    tolerances: Tolerances | None
    shares: dict[str, float]

    @property
    def u_worst(self) -> float:
        """Standard uncertainty [m] of the radius at the worst useful clock of the nominal wall; NaN where none is."""
        good = useful_clocks(self.ring.u_radius, self.ring.margin >= 4)
        return float(self.ring.u_radius[good].max()) if good.any() else float("nan")


def analyse(study: Study, wishes: Wishes | None = None) -> Analysis:
    """All of a study; raises InputError where its numbers make no rig."""
    return _analysed(study.rig(), study.nominal_radius, study.inputs, wishes or Wishes(), study)


def analyse_rig(
    rig: Rig, *, nominal_radius: float, assumptions: Assumptions = HONEST, wishes: Wishes | None = None
) -> Analysis:
    """All of a given rig, with the uncertainties it states; those it does not state are the defaults of a rig file.

    There are no sweeps over baseline and projection: its other parameters would have to follow, nobody says how.
    """
    return _analysed(
        rig.with_default_uncertainty(nominal_radius), nominal_radius, assumptions, wishes or Wishes(), None
    )


def _analysed(rig: Rig, radius: float, assumptions: Assumptions, wishes: Wishes, study: Study | None) -> Analysis:
    if not 0 < radius < float("inf"):
        raise InputError(f"The nominal radius must be positive, got {radius} m.")
    bump = BUMP * radius if wishes.bump is None else wishes.bump
    target = TARGET * radius if wishes.target is None else wishes.target
    ring = predict_ring(rig, ring_clocks(rig), radius, assumptions=assumptions)
    return Analysis(
        rig=rig,
        study=study,
        nominal_radius=radius,
        assumptions=assumptions,
        bump=bump,
        maps=maps_of(rig, nominal_radius=radius, assumptions=assumptions),
        limits=measuring_limits(rig, nominal_radius=radius, assumptions=assumptions),
        ring=round_pipe(rig, radius=radius, assumptions=assumptions),
        radius=against_radius(rig, nominal_radius=radius, assumptions=assumptions),
        baseline=against_baseline(study) if study else None,
        projection=against_projection(study) if study else None,
        misalignment=misalignments(rig, nominal_radius=radius, assumptions=assumptions),
        occlusion=occlusion(rig, nominal_radius=radius),
        shadow=shadows(rig, nominal_radius=radius),
        bump_shadow=shadows(rig, nominal_radius=radius, heights=bump),
        deployment=_deployment(rig, radius, wishes),
        tolerances=tolerances(
            rig, nominal_radius=radius, target=target / assumptions.coverage_factor, assumptions=assumptions
        ),
        shares=grouped(ring_shares(ring), rig.covariance or Covariance.independent({})),
    )


def _deployment(rig: Rig, radius: float, wishes: Wishes) -> Deployment:
    return deployment(
        rig,
        nominal_radius=radius,
        manhole=MANHOLE if wishes.manhole is None else wishes.manhole,
        body_length=2 * radius if wishes.body_length is None else wishes.body_length,
        body_height=radius if wishes.body_height is None else wishes.body_height,
    )
