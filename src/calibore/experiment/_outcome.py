"""What an experiment found, read from its folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.comparison import difference
from calibore.experiment._instruments import Instrument, instrument_named
from calibore.experiment._published import OUTLIER
from calibore.experiment._scans import DRIFTED, EXACT, FRESH, variants_of
from calibore.experiment._truth import SAME, true_radius
from calibore.experiment._workshop import Workshop
from calibore.registration import RIGID, Motion, Registration, register
from calibore.scans import Profile, joined, read_profile
from calibore.uncertainty import Quantity

Array = NDArray[np.float64]
FACTOR = 1.96
"""Times u: half of a 95 % interval."""
NEAR, STEP = 3, 3.0
"""Positions of the grid beside a point, and standard uncertainties that the wall may differ there, on plain wall."""
UNSTATED = "unstated"
"""The rig file that is out of date, without its [drift]."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """Errors `value` (n,) [m] at the `radius` (n,) [m] of what they are judged by, and their stated standard
    uncertainty `u` (n,) [m]; errors beyond the dissertation's limit are left out, `outliers` of them.
    """

    radius: Array
    value: Array
    u: Array
    outliers: int

    @classmethod
    def of(cls, radius: Array, value: Array, u: Array) -> "Judgement":
        """Points without a value are left out."""
        known = np.isfinite(value) & np.isfinite(u)
        kept = known & (np.abs(np.nan_to_num(value)) <= OUTLIER)
        return cls(radius[kept], value[kept], u[kept], int(np.count_nonzero(known & ~kept)))

    @property
    def rms(self) -> float:
        """m; eq. 8-4 of Swanbom 2007."""
        return float(np.sqrt(np.mean(self.value**2)))

    @property
    def predicted(self) -> float:
        """m; root mean square of the stated uncertainties."""
        return float(np.sqrt(np.mean(self.u**2)))

    @property
    def relative(self) -> float:
        """Root mean square of errors over their own stated uncertainties: 1 where these are right."""
        return float(np.sqrt(np.mean((self.value / self.u) ** 2)))

    @property
    def spread(self) -> float:
        """m; standard deviation of the absolute errors."""
        return float(np.std(np.abs(self.value)))

    @property
    def worst_case(self) -> float:
        """m; "approximate worst case" of Table 8.3."""
        return self.rms + self.spread

    @property
    def inside(self) -> float:
        """Fraction of the points whose 95 % interval holds what they are judged by."""
        return float(np.mean(np.abs(self.value) <= FACTOR * self.u))


@dataclass(frozen=True, eq=False)
class LaserOutcome:
    """Of the instrument `name`: errors by rig file (EXACT, FRESH, DRIFTED, UNSTATED) against the truth and against the
    tactile profile; with the exact one against the truth `on_plain_wall`, away from edges; the fraction of visible
    points `missed`; its `profile` by the exact rig file; how the one by the day's calibration was brought onto the
    tactile one, `registration`; the `scale` that suits the one whose rig file is out of date (None where there is
    none), its uncertainty counting how well the day's calibration knows the size.
    """

    name: str
    by_truth: Mapping[str, Judgement]
    by_touch: Mapping[str, Judgement]
    on_plain_wall: Judgement
    missed: float
    profile: Profile
    registration: Registration
    scale: Quantity | None

    @property
    def instrument(self) -> Instrument:
        return instrument_named(self.name)


def read_laser(instrument: Instrument, workshop: Workshop, touched: Profile) -> LaserOutcome:
    """Everything of one instrument once its sections are profiled."""
    sections = _sections(instrument, workshop)
    profiles = {variant: joined(some) for variant, some in sections.items()}
    by_touch: dict[str, Judgement] = {}
    registrations: dict[str, Registration] = {}
    start: Motion | None = None
    for variant, profile in profiles.items():
        by_touch[variant], registrations[variant] = _against_touch(profile, touched, start)
        start = registrations[variant].motion
    scale = _scale(profiles[UNSTATED], touched, start) if UNSTATED in profiles else None
    truths = [workshop.scan(instrument.name, number) / "truth.npz" for number in range(len(sections[EXACT]))]
    return LaserOutcome(
        instrument.name,
        {variant: _against_truth(some, truths) for variant, some in sections.items()},
        by_touch,
        _against_truth(sections[EXACT], truths, plain=instrument.kind),
        _missed(sections[EXACT], truths),
        profiles[EXACT],
        registrations[FRESH],
        scale,
    )


def _scale(profile: Profile, touched: Profile, start: Motion | None) -> Quantity:
    """As chapter 8 does it: moved and scaled until it fits, whatever the calibration knows."""
    bare = replace(profile, common_mode=profile.common_mode[:0])
    found = register(bare, touched, free=(*RIGID, "scale"), start=start, search=False)
    known = np.nanmedian(profile.common_mode / profile.radius, axis=(1, 2))
    u = float(np.hypot(found.u("scale"), np.linalg.norm(known)))
    return Quantity(found.motion.scale, u)


def _sections(instrument: Instrument, workshop: Workshop) -> dict[str, list[Profile]]:
    count = len(instrument.sections(workshop.plan))
    found = {
        variant: [read_profile(workshop.profile(variant, instrument.name, number)) for number in range(count)]
        for variant in variants_of(instrument)
    }
    if DRIFTED in found:
        found[UNSTATED] = [_unaware(*pair) for pair in zip(found[DRIFTED], found[FRESH], strict=True)]
    return found


def _unaware(drifted: Profile, fresh: Profile) -> Profile:
    """What the rig file that is out of date gives, with the uncertainty of one that is not: of the same pictures."""
    apart = np.abs(drifted.axial[:, None] - fresh.axial)
    rows = np.flatnonzero(apart.min(axis=1) < SAME)
    modes = fresh.common_mode[:, apart.argmin(axis=1)[rows]]
    known, some = np.isfinite(modes).all(axis=0), drifted.rings(rows)
    return replace(some, radius=np.where(known, some.radius, np.nan), common_mode=np.where(known, modes, 0.0))


def _against_truth(sections: Sequence[Profile], truths: Sequence[Path], *, plain: str = "") -> Judgement:
    """Of all points, or of those of an instrument of the kind `plain` that lie on plain wall."""
    trues, errors, us = [], [], []
    for profile, truth in zip(sections, truths, strict=True):
        true, u = true_radius(profile, truth), np.hypot(profile.u_independent, profile.u_common)
        counts = _is_plain(true, u, axis=0 if plain == "side" else 1) if plain else np.isfinite(true)
        trues.append(true[counts])
        errors.append(np.where(profile.measured, profile.radius, np.nan)[counts] - true[counts])
        us.append(u[counts])
    return Judgement.of(*map(np.concatenate, (trues, errors, us)))


def _is_plain(true: Array, u: Array, *, axis: int) -> NDArray[np.bool_]:
    """Where (n, m) the wall is known and, within `NEAR` positions along the line of light, no step exceeds noise."""
    plain = np.isfinite(true)
    for steps in (*range(-NEAR, 0), *range(1, NEAR + 1)):
        plain &= np.abs(np.roll(true, steps, axis=axis) - true) < STEP * u
    return plain


def _missed(sections: Sequence[Profile], truths: Sequence[Path]) -> float:
    visible = [np.isfinite(true_radius(*pair)) for pair in zip(sections, truths, strict=True)]
    lost = sum(int((seen & ~one.measured).sum()) for seen, one in zip(visible, sections, strict=True))
    return lost / max(sum(int(seen.sum()) for seen in visible), 1)


def _against_touch(profile: Profile, touched: Profile, start: Motion | None) -> tuple[Judgement, Registration]:
    """As chapter 8 does it: moved onto the tactile profile, which is taken for what it is worth."""
    found = difference(profile, touched, start=start, search=start is None)
    return Judgement.of(found.radius - found.value, found.value, found.u), found.registration
