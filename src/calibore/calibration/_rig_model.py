"""The light of a rig on known surfaces: how far beyond them its triangulated marks lie."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._looks import Look
from calibore.calibration._references import Reference
from calibore.errors import InputError
from calibore.rigs import Rig, meetings_of, moved, triangulate

Array = NDArray[np.float64]
LOST = 1e3
"""m: residual of a mark that meets no light; no step of a fit may end there."""
ERROR = "error"


@dataclass(frozen=True, eq=False)
class RigModel:
    """Residuals of `looks` at known surfaces, a model for `fitting.least_squares`.

    Its parameters `names`: changes of the parameters `free` of the `rig`, what is unknown of each setting of a
    reference ("setting.nuisance"), and the error of each stop whose uncertainty is stated ("stop.error" [m]).
    `branches`: which meeting of its rays each look shows.
    """

    rig: Rig
    looks: tuple[Look, ...]
    free: tuple[str, ...]
    branches: tuple[NDArray[np.intp], ...] = ()
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        nuisances = [name for setting in self.settings for name in self.nuisances(setting)]
        errors = [f"{stop}.{ERROR}" for stop in self.uncertain_stops]
        object.__setattr__(self, "names", (*self.free, *nuisances, *errors))

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
    def uncertain_stops(self) -> list[str]:
        """Stops whose reference states an uncertainty of its size or place."""
        return [stop for stop, reference in self.stops.items() if self.stated and reference.u]

    @cached_property
    def look_of(self) -> NDArray[np.intp]:
        """Index of the look that each of the n residuals belongs to."""
        return np.repeat(np.arange(len(self.looks)), [look.u.size for look in self.looks])

    @cached_property
    def stop_of(self) -> NDArray[np.intp]:
        """Index of its stop, for each of the n residuals."""
        stops = list(self.stops)
        return np.array([stops.index(look.of_stop) for look in self.looks])[self.look_of]

    def nuisances(self, setting: str) -> list[str]:
        return [f"{setting}.{name}" for name in self.settings[setting].nuisance_names]

    def moved_rig(self, values: Array) -> Rig:
        return moved(self.rig, dict(zip(self.free, values[: len(self.free)].tolist(), strict=True)))

    def __call__(self, values: Array) -> tuple[Array, Array]:
        """How far (n,) [m] the marks lie beyond their surfaces, and minus its derivatives (n, p): measured minus known,
        and how what is predicted moves.
        """
        value, jacobian, _ = self.evaluate(values)
        lost = ~np.isfinite(value)
        value[lost], jacobian[lost] = LOST, 0.0
        return value, -jacobian

    def evaluate(self, values: Array) -> tuple[Array, Array, Array]:
        """Gaps (n,) [m], their derivatives (n, p) by the parameters, and (n,) [m/px] by the pixel along each mark's
        direction; NaN where a mark meets no light or the rig cannot be.
        """
        n = self.look_of.size
        value, slope, jacobian = np.full(n, np.nan), np.full(n, np.nan), np.zeros((n, len(self.names)))
        try:
            rig = self.moved_rig(values)
        except InputError:
            return value, jacobian, slope
        columns = [rig.parameter_names.index(name) for name in self.free]
        for number, look in enumerate(self.looks):
            rows = self.look_of == number
            branch = self.branches[number] if self.branches else None
            found = triangulate(rig, look.u, look.v, laser=look.laser, branch=branch)
            own = [self.names.index(name) for name in self.nuisances(look.of_setting)]
            gap = look.reference.gap(found.points, values[own])
            value[rows] = gap.value
            slope[rows] = np.einsum("ni,nij,nj->n", gap.by_point, found.d_pixel, look.direction)
            jacobian[rows, : len(columns)] = np.einsum("ni,nip->np", gap.by_point, found.d_parameters[:, :, columns])
            jacobian[np.ix_(rows, own)] = gap.by_nuisance
            if look.of_stop in self.uncertain_stops:
                error = self.names.index(f"{look.of_stop}.{ERROR}")
                value[rows] -= values[error]
                jacobian[rows, error] = -1.0
        return value, jacobian, slope

    def start(self) -> Array:
        """Parameters (p,) of the rig as it is, and of references as the rig sees them."""
        values = np.zeros(len(self.names))
        for setting, reference in self.settings.items():
            points = [self._points(number) for number, look in enumerate(self.looks) if look.of_setting == setting]
            points = np.concatenate(points)
            points = points[np.isfinite(points[:, 0])]
            if len(points) > reference.nuisance_u.size:
                values[[self.names.index(name) for name in self.nuisances(setting)]] = reference.first_guess(points)
        return values

    def _points(self, number: int) -> Array:
        look = self.looks[number]
        branch = self.branches[number] if self.branches else 0
        return triangulate(self.rig, look.u, look.v, laser=look.laser, branch=branch).points


def nearest_branches(model: RigModel, values: Array) -> tuple[NDArray[np.intp], ...]:
    """For every look the meetings (n,) of its rays that lie nearest to its reference."""
    rig, chosen = model.moved_rig(values), []
    for look in model.looks:
        own = [model.names.index(name) for name in model.nuisances(look.of_setting)]
        distances = []
        for branch in range(meetings_of(rig, look.u[:1], look.v[:1], laser=look.laser).branches):
            points = triangulate(rig, look.u, look.v, laser=look.laser, branch=branch).points
            distance = np.abs(look.reference.gap(points, values[own]).value)
            distances.append(np.where(np.isfinite(distance), distance, np.inf))
        chosen.append(np.argmin(distances, axis=0))
    return tuple(chosen)
