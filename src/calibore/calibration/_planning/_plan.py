"""Which picture to take next: the one after which the wall is known best.

The information of a picture does not depend on what will be seen, so it is known beforehand: its Jacobian at the
present parameters, less what its unknown pose and the errors of the target take up, is added to what is known now.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._on_the_wall import stated, wall_clocks, wall_slopes, wall_uncertainty
from calibore.calibration._planning._pictures import Picture, picture_of
from calibore.calibration._planning._shots import Shot, usual_shots
from calibore.calibration._planning._targets import PlannedTarget
from calibore.calibration._planning._words import advice_of
from calibore.errors import InputError
from calibore.rigs import Rig
from calibore.uncertainty import Covariance

Array = NDArray[Any]
REACH = (0.6, 1.4)
RADII = 33
UNKNOWN = 1e4
"""rad, m: as good as no knowledge of a pose, and finite, so that what no mark feels takes nothing up."""


class Step(NamedTuple):
    """A picture, and the standard uncertainty `u` [m] of the radius on the nominal wall after it (root of the mean
    variance over the clocks).
    """

    shot: Shot
    u: float


@dataclass(frozen=True, eq=False)
class Plan:
    """Pictures `steps` in the order in which to take them, each the best after those before; `ranking`: all that could
    come first, the best first. `before` [m]: u of the radius on the wall of `nominal_radius` now. Against `radius` (r,)
    [m]: `u_before`, `u_after` all steps (r,). `covariance` after all steps.
    """

    nominal_radius: float
    before: float
    steps: tuple[Step, ...]
    ranking: tuple[Step, ...]
    radius: Array
    u_before: Array
    u_after: Array
    covariance: Covariance

    @property
    def after(self) -> float:
        """Standard uncertainty [m] after all steps."""
        return self.steps[-1].u

    def advice(self, unit: str = "mm") -> str:
        """The next picture and what it brings, in sentences, lengths in "mm" or "in"."""
        return advice_of(self, unit)


def plan(
    rig: Rig,
    target: PlannedTarget,
    *,
    nominal_radius: float,
    candidates: Iterable[Shot] | None = None,
    count: int = 3,
) -> Plan:
    """The `count` pictures of `target` that tell most of the radius on the wall of `nominal_radius`, chosen one after
    the other among `candidates`, by default a round choice of places, tilts, gauges or stops.

    Each picture's pose is unknown, or as uncertain as the target says; errors of the target's making are common to all
    its pictures. Raises InputError where the rig states no covariance, or the camera sees none of the candidates.
    """
    known = stated(rig)
    if count < 1:
        raise InputError(f"At least one picture is planned, got {count}.")
    slopes = wall_slopes(rig, np.array([nominal_radius]), wall_clocks(rig))[0]
    seen = np.isfinite(slopes).all(axis=1)
    if not seen.any():
        raise InputError("The rig does not see a wall of that radius; give the nominal radius that it measures.")
    shots = tuple(usual_shots(rig, target, nominal_radius) if candidates is None else candidates)
    pictures = {shot: picture for shot in shots if (picture := picture_of(rig, target, shot)) is not None}
    if not pictures:
        raise InputError(
            "The camera sees the target whole, or its light on it, in none of the pictures considered; choose a target "
            "that suits its field of view."
        )
    state = _State.of(rig, known, pictures.values())
    wall = state.weighed(rig, slopes[seen])
    steps, ranking = [], None
    before = _u(wall, state.factor)
    informative = {shot: state.information(rig, picture) for shot, picture in pictures.items()}
    for _ in range(count):
        after = (Step(shot, _u(wall, state.told(rows).factor)) for shot, rows in informative.items())
        ranked = sorted(after, key=_by_u)
        ranking = ranking or tuple(ranked)
        steps.append(ranked[0])
        state = state.told(informative[ranked[0].shot])
    found = state.covariance(known.names)
    radius = np.linspace(*REACH, RADII) * nominal_radius
    now, then = (wall_uncertainty(rig.knowing(one), radii=radius).mean for one in (known, found))
    return Plan(nominal_radius, before, tuple(steps), ranking or (), radius, now, then, found)


@dataclass(frozen=True, eq=False)
class _State:
    """`factor` (k, m) of the covariance of `names` (k,): parameters of the rig, then errors of the target."""

    names: tuple[str, ...]
    factor: Array

    @classmethod
    def of(cls, rig: Rig, known: Covariance, pictures: Iterable[Picture]) -> "_State":
        making = {key: u for picture in pictures for key, u in zip(picture.keys, picture.shared_u, strict=True)}
        p = len(known.names)
        factor = np.zeros((p + len(making), p + len(making)))
        factor[:p, :p] = known.factor()
        factor[p:, p:] = np.diag(list(making.values()))
        return cls((*known.names, *making), factor)

    def information(self, rig: Rig, picture: Picture) -> Array:
        """(k', k): rows of unit noise, to which the picture comes down when its pose is unknown."""
        rows = np.zeros((len(picture.rows), len(self.names)))
        for number, name in enumerate(self.names):
            if name in rig.parameter_names:
                rows[:, number] = picture.rows[:, rig.parameter_names.index(name)]
            elif name in picture.keys:
                rows[:, number] = picture.shared[:, picture.keys.index(name)]
        return without_pose(rows, picture.beside, picture.beside_u)

    def told(self, rows: Array) -> "_State":
        """After a picture: P - P r' (1 + r P r')^-1 r P, singular P included."""
        left, size, _ = np.linalg.svd((rows @ self.factor).T, full_matrices=False)
        return _State(self.names, self.factor - (self.factor @ left) * (1 - 1 / np.sqrt(1 + size**2)) @ left.T)

    def weighed(self, rig: Rig, slopes: Array) -> Array:
        """`slopes` (c, p) by the rig's parameters, by `names`."""
        columns = [rig.parameter_names.index(name) if name in rig.parameter_names else -1 for name in self.names]
        return np.column_stack([slopes, np.zeros(len(slopes))])[:, columns]

    def covariance(self, names: tuple[str, ...]) -> Covariance:
        factor = self.factor[: len(names)]
        return Covariance(names, factor @ factor.T)


def without_pose(rows: Array, beside: Array, beside_u: Array) -> Array:
    """(k, k): `rows` (n, k) of unit noise with `beside` (n, q) marginalised, of which `beside_u` (q,) is known before.

    From the triangle of a QR factorisation of both and of what is known before.
    """
    prior = 1 / np.minimum(beside_u, UNKNOWN)
    size = np.hypot(np.linalg.norm(beside, axis=0), prior)
    q, k = beside.shape[1], rows.shape[1]
    known = np.block([[beside / size, rows], [np.diag(prior / size), np.zeros((q, k))]])
    return np.asarray(np.linalg.qr(known, mode="r"))[q:, q:]


def _u(wall: Array, factor: Array) -> float:
    """[m] root of the mean variance."""
    return float(np.sqrt(((wall @ factor) ** 2).sum() / len(wall)))


def _by_u(step: Step) -> float:
    return step.u
