"""The cone of light that a laser with a conical lens or mirror throws round the pipe (formats.md, section 1)."""

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers._cone_frontier import FOLDS, SECOND_ORDER, frontiers_of_cone
from calibore.lasers._cone_meetings import meetings_with_cone
from calibore.lasers._possible import MOST, possible
from calibore.lasers._ring_angles import ring_angles
from calibore.lasers._surface import Frontier, LaserSurface, Meetings

FLAT_WITHIN = 1e-6  # rad of 90 deg: there the cone is a plane
AHEAD = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Cone(LaserSurface):
    """F = axis . w - cos(half_angle) |w| with w = x - apex: one nappe only.

    `baseline` [m]: apex from the rig axis in the direction `clock` [rad] from the crown, 0 for a coaxial cone;
    `aim` [rad]: axis inclined towards the rig axis; `half_angle` [rad] from axis to light, above 90 deg for a reversed
    cone, whose light falls behind its apex; `offset` [m]: apex ahead of the pupil.
    """

    baseline: float
    aim: float
    half_angle: float
    clock: float = 0.0
    offset: float = 0.0

    parameter_names: ClassVar[tuple[str, ...]] = ("baseline", "aim", "half_angle", "clock", "offset")

    def __post_init__(self) -> None:
        self._refuse_lengths()
        self._refuse_angles()

    @classmethod
    def for_ring(cls, baseline: float, projection: float, nominal_radius: float, *, clock: float = 0.0) -> Self:
        """The cone whose light falls `projection` [m] ahead of the apex, all round a wall of `nominal_radius` [m]."""
        aim, half_angle, _ = ring_angles(baseline, projection, nominal_radius)
        return cls(float(baseline), float(aim), float(half_angle), float(clock))

    @property
    def apex(self) -> NDArray[Any]:
        """(3,) [m]."""
        return self.baseline * self._outwards + self.offset * AHEAD

    @property
    def axis(self) -> NDArray[Any]:
        """(3,) unit vector."""
        return np.cos(self.aim) * AHEAD - np.sin(self.aim) * self._outwards

    @property
    def apex_by_parameters(self) -> NDArray[Any]:
        """(3, 5): how the apex moves with each parameter."""
        still = 0 * AHEAD
        return np.stack([self._outwards, still, still, self.baseline * self._round, AHEAD], axis=1)

    @property
    def axis_by_parameters(self) -> NDArray[Any]:
        """(3, 5): how the axis turns."""
        still = 0 * AHEAD
        by_aim = -np.sin(self.aim) * AHEAD - np.cos(self.aim) * self._outwards
        return np.stack([still, by_aim, still, -np.sin(self.aim) * self._round, still], axis=1)

    def value(self, points: NDArray[Any]) -> NDArray[Any]:
        arms = points - self.apex
        return arms @ self.axis - np.cos(self.half_angle) * _length(arms)

    def gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        arms = points - self.apex
        return self.axis - np.cos(self.half_angle) * arms / _length(arms)[:, None]

    def parameter_gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        arms = points - self.apex
        by_parameters = -self.gradient(points) @ self.apex_by_parameters + arms @ self.axis_by_parameters
        by_parameters[:, 2] += np.sin(self.half_angle) * _length(arms)
        return by_parameters

    def meet(self, origins: NDArray[Any], directions: NDArray[Any]) -> Meetings:
        """Two rows: `NEAR`, where the ray enters the solid that the light bounds, and `FAR`, where it leaves it.

        That solid is convex: round the axis for half angles below 90 deg, round its opposite above.
        """
        arms = np.atleast_2d(origins) - self.apex
        return meetings_with_cone(arms, directions, axis=self.axis, half_angle=self.half_angle)

    def frontier(self, origins: NDArray[Any], directions: NDArray[Any]) -> Frontier:
        """Three rows: the ray touches the cone (both meetings), or runs along it: the far, the near one at infinity."""
        arms = np.broadcast_to(np.atleast_2d(origins) - self.apex, directions.shape)
        rows = frontiers_of_cone(arms, directions, axis=self.axis, half_angle=self.half_angle)
        by_parameters = rows.by_axis @ self.axis_by_parameters - rows.by_arm @ self.apex_by_parameters
        by_parameters[..., 2] += rows.by_half_angle
        return Frontier(rows.value, rows.by_arm, rows.by_direction, by_parameters, SECOND_ORDER, FOLDS)

    @property
    def _outwards(self) -> NDArray[Any]:
        return np.array([np.sin(self.clock), -np.cos(self.clock), 0.0])

    @property
    def _round(self) -> NDArray[Any]:
        """How `_outwards` turns with the clock."""
        return np.array([np.cos(self.clock), np.sin(self.clock), 0.0])

    def _refuse_lengths(self) -> None:
        if not 0 <= self.baseline <= MOST:
            raise InputError(
                f"The baseline of a cone must be 0 (coaxial) or positive, got {self.baseline} m; "
                "turn the clock by 180 deg instead."
            )
        if not possible([self.clock, self.offset]):
            raise InputError(
                f"Clock and offset are finite, got {self.clock} rad and {self.offset} m; leave out what is 0."
            )
        if self.baseline == 0 and self.offset == 0:
            raise InputError(
                "The apex of the cone stands in the camera's pupil, got baseline 0 m and offset 0 m: "
                "no pixel would tell a distance; give it an offset or a baseline."
            )

    def _refuse_angles(self) -> None:
        aim, half_angle = np.degrees([self.aim, self.half_angle])
        if not abs(aim) < 90:
            raise InputError(
                f"The aim must lie between -90 and 90 deg, got {aim:.6g} deg; it is measured from the rig axis."
            )
        if not 0 < half_angle < 180:
            raise InputError(
                f"The half angle must lie between 0 and 180 deg, got {half_angle:.6g} deg; measure it from the axis."
            )
        if abs(self.half_angle - np.pi / 2) < FLAT_WITHIN:
            raise InputError(f"A cone of half angle {half_angle:.6g} deg is flat; describe it as a plane.")
        if half_angle < 90 <= abs(aim) + half_angle:
            raise InputError(
                f"|aim| + half_angle must be below 90 deg, got {abs(aim):.6g} + {half_angle:.6g} deg: "
                "the light would not meet the wall ahead; reduce one."
            )
        if half_angle > 90 >= half_angle - abs(aim):
            raise InputError(
                f"half_angle - |aim| of a reversed cone must be above 90 deg, got {half_angle:.6g} - {abs(aim):.6g} "
                "deg: the light would not meet the wall behind; reduce the aim or open the cone."
            )


def _length(vectors: NDArray[Any]) -> NDArray[Any]:
    return np.sqrt(np.einsum("ni,ni->n", vectors, vectors))
