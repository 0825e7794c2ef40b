"""The light of a rig on known surfaces: how far beyond them its triangulated marks lie."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._rig._looks import Look
from calibore.calibration._rig._references import Reference
from calibore.errors import InputError
from calibore.rigs import Rig, meetings_of, moved, triangulate, value_of

Array = NDArray[np.float64]
Whole = NDArray[np.intp]


class Gaps(NamedTuple):
    """How far (n,) [m] the marks lie beyond their surfaces, the derivatives (n, p) by the parameters, and `slope` (n,)
    [m/px] by the place of each mark along its direction; NaN where a mark meets no light or the rig cannot be.
    """

    value: Array
    jacobian: Array
    slope: Array


@dataclass(frozen=True, eq=False)
class RigModel:
    """Gaps of `looks` at known surfaces.

    Its parameters `names`: changes of the parameters `free` of the `rig`, and what is unknown of each setting of a
    reference ("setting.nuisance"). `branches`: which meeting of its rays each look shows.
    """

    rig: Rig
    looks: tuple[Look, ...]
    free: tuple[str, ...]
    branches: tuple[Whole, ...] = ()
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        nuisances = [name for setting in self.settings for name in self.nuisances(setting)]
        object.__setattr__(self, "names", (*self.free, *nuisances))

    @cached_property
    def settings(self) -> dict[str, Reference]:
        return {look.of_setting: look.reference for look in self.looks}

    @cached_property
    def stops(self) -> dict[str, Reference]:
        return {look.of_stop: look.reference for look in self.looks}

    @cached_property
    def stated(self) -> bool:
        """Whether the references say how well they are known; all of them do, or none does."""
        said = {reference.u is not None for reference in self.stops.values()}
        if len(said) > 1:
            raise InputError("Some references state the uncertainty of their size or place and some do not; state all.")
        return said == {True}

    @cached_property
    def look_of(self) -> Whole:
        """Index of the look that each of the n marks belongs to."""
        return np.repeat(np.arange(len(self.looks)), [look.u.size for look in self.looks])

    @cached_property
    def stop_of(self) -> Whole:
        """Index of its stop, for each of the n marks."""
        stops = list(self.stops)
        return np.array([stops.index(look.of_stop) for look in self.looks])[self.look_of]

    @cached_property
    def chain_of(self) -> Whole:
        """Number of the stretch of neighbours that each of the n marks belongs to."""
        chains = [look.chain for look in self.looks]
        starts = np.cumsum([0, *(chain[-1] + 1 for chain in chains)])
        return np.concatenate([chain + start for chain, start in zip(chains, starts, strict=False)])

    @cached_property
    def sigma(self) -> Array:
        """(n,) [px]."""
        return np.concatenate([look.sigma for look in self.looks])

    def nuisances(self, setting: str) -> list[str]:
        return [f"{setting}.{name}" for name in self.settings[setting].nuisance_names]

    def moved_rig(self, values: Array) -> Rig:
        return moved(self.rig, dict(zip(self.free, values[: len(self.free)].tolist(), strict=True)))

    def doubting(self, values: Array, covariance: Array) -> tuple["RigModel", Array]:
        """The model whose references are known only as well as the `covariance` (p, p) of all parameters says, and the
        `values` (p,) of its parameters.
        """
        looks = []
        for look in self.looks:
            own = [self.names.index(name) for name in self.nuisances(look.of_setting)]
            looks.append(replace(look, reference=look.reference.doubting(covariance[np.ix_(own, own)])))
        model, found = replace(self, looks=tuple(looks)), dict(zip(self.names, values.tolist(), strict=True))
        return model, np.array([found.get(name, 0.0) for name in model.names])

    def residuals(self, values: Array) -> tuple[Array, Array, Array]:
        """Pixels (n,) from where each mark should be, along its direction; minus their derivatives (n, p): how what is
        predicted moves; and the slope (n,) [m/px] there.

        Taken where the mark should be, found by a Newton step, not where noise has put it: derivatives that hold the
        noise of the residuals would let a fit trade the one for the other, and bias it.
        """
        value, _, slope = self.gaps(values)
        away = value / slope
        value, jacobian, slope = self.gaps(values, away)
        return away + value / slope, -jacobian / slope[:, None], slope

    def gaps(self, values: Array, away: Array | None = None) -> Gaps:
        """Of the marks, or of places `away` (n,) [px] against their directions."""
        n = self.look_of.size
        gaps = Gaps(np.full(n, np.nan), np.zeros((n, len(self.names))), np.full(n, np.nan))
        try:
            rig = self.moved_rig(values)
        except InputError:
            return gaps
        columns = [rig.parameter_names.index(name) for name in self.free]
        for laser, marks in self._lit.items():
            place = marks.place if away is None else marks.place - away[marks.rows, None] * marks.direction
            found = triangulate(rig, place[:, 0], place[:, 1], laser=laser, branch=marks.branch)
            by_point = np.empty_like(found.points)
            for own, rows, reference, nuisance in marks.looks:
                gap = reference.gap(found.points[own], values[nuisance])
                gaps.value[rows], by_point[own] = gap.value, gap.by_point
                gaps.jacobian[rows, nuisance] = gap.by_nuisance
            by_pixel = np.einsum("ni,nik->nk", by_point, found.d_pixel)
            gaps.slope[marks.rows] = np.einsum("nk,nk->n", by_pixel, marks.direction)
            by_rig = (by_point[:, None, :] @ found.d_parameters)[:, 0]
            gaps.jacobian[marks.rows, : len(columns)] = by_rig[:, columns]
        return gaps

    def start(self, near: Rig) -> Array:
        """Parameters (p,) of the rig `near`, and of references as it sees them."""
        values = np.zeros(len(self.names))
        values[: len(self.free)] = [value_of(near, name) - value_of(self.rig, name) for name in self.free]
        for setting, reference in self.settings.items():
            looks = [number for number, look in enumerate(self.looks) if look.of_setting == setting]
            points = np.concatenate([self._points(near, number) for number in looks])
            points = points[np.isfinite(points[:, 0])]
            if len(points) > reference.nuisance_u.size:
                values[[self.names.index(name) for name in self.nuisances(setting)]] = reference.first_guess(points)
        return values

    def _points(self, rig: Rig, number: int) -> Array:
        look = self.looks[number]
        branch = self.branches[number] if self.branches else 0
        return triangulate(rig, look.u, look.v, laser=look.laser, branch=branch).points

    @cached_property
    def _lit(self) -> dict[int, "_Lit"]:
        """The marks on the light of each laser."""
        starts = np.concatenate([[0], np.cumsum([look.u.size for look in self.looks])])
        lit = {}
        for laser in dict.fromkeys(look.laser for look in self.looks):
            numbers, start, looks = [i for i, look in enumerate(self.looks) if look.laser == laser], 0, []
            for number in numbers:
                look = self.looks[number]
                nuisance = [self.names.index(name) for name in self.nuisances(look.of_setting)]
                columns = slice(nuisance[0], nuisance[-1] + 1) if nuisance else slice(0, 0)
                own = slice(start, start + look.u.size)
                looks.append((own, slice(*starts[number : number + 2]), look.reference, columns))
                start = own.stop
            place = np.concatenate([np.stack([self.looks[i].u, self.looks[i].v], axis=1) for i in numbers])
            direction = np.concatenate([self.looks[i].direction for i in numbers])
            branch = np.concatenate([self.branches[i] for i in numbers]) if self.branches else None
            lit[laser] = _Lit(place, direction, branch, np.isin(self.look_of, numbers), looks)
        return lit


class _Lit(NamedTuple):
    """`place`, `direction` (m, 2) and `branch` (m,) of the marks of one laser, which are those `rows` (n,) of all; of
    each look which of these they are, which of all, its reference and the columns of its nuisance.
    """

    place: Array
    direction: Array
    branch: Whole | None
    rows: NDArray[np.bool_]
    looks: list[tuple[slice, slice, Reference, slice]]


def nearest_branches(model: RigModel, values: Array) -> tuple[Whole, ...]:
    """For every look the meetings (n,) of its rays that lie nearest to its reference, grazing ones among them."""
    rig, chosen = model.moved_rig(values), []
    for look in model.looks:
        own = [model.names.index(name) for name in model.nuisances(look.of_setting)]
        rays = rig.mount.place(rig.camera.unproject(look.u, look.v))
        distances = []
        for along in meetings_of(rig, look.u, look.v, laser=look.laser).distance:
            there = np.isfinite(along) & (along > 0)
            points = rays.origin + np.where(there, along, np.nan)[:, None] * rays.direction
            distances.append(np.where(there, np.abs(look.reference.gap(points, values[own]).value), np.inf))
        chosen.append(np.argmin(distances, axis=0))
    return tuple(chosen)
