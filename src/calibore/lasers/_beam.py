"""One laser beam, as the plane through it that best tells where a camera ray passes it."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers._flat import FlatSurface
from calibore.lasers._possible import possible
from calibore.lasers._surface import MeetingFlag, Meetings

NEAREST_TO_PUPIL = 1e-6  # m; a beam that passes closer lies along one camera ray, where no pixel tells the distance


@dataclass(frozen=True)
class Beam(FlatSurface):
    """From the point `x`, `y`, `z` [m] in the direction `zenith` from +z at `clock` [rad]; lit ahead of that point.

    The plane contains the beam and stands at right angles to the plane of beam and pupil (the rig origin). Its unit
    normal thus points from the pupil to the beam's nearest point, whose distance is the level.
    """

    x: float
    y: float
    z: float
    zenith: float
    clock: float

    parameter_names: ClassVar[tuple[str, ...]] = ("x", "y", "z", "zenith", "clock")

    def __post_init__(self) -> None:
        given = [self.x, self.y, self.z, self.zenith, self.clock]
        if not possible(given):
            raise InputError(f"A beam's point [m] and angles [rad] are finite, got {given}; give all five as numbers.")
        if self.level < NEAREST_TO_PUPIL:
            raise InputError(
                f"A beam must pass the pupil at {NEAREST_TO_PUPIL} m or more, got {self.level:.3g} m: it would "
                "look the same at every distance; move the laser off the pupil or turn it."
            )

    @property
    def source(self) -> NDArray[Any]:
        """(3,) [m]."""
        return np.array([self.x, self.y, self.z])

    @property
    def direction(self) -> NDArray[Any]:
        """(3,) unit vector of the light."""
        across = np.sin(self.zenith)
        return np.array([across * np.sin(self.clock), -across * np.cos(self.clock), np.cos(self.zenith)])

    def beam_distance(self, points: NDArray[Any]) -> NDArray[Any]:
        """(n,) [m] from `points` (n, 3) to the beam; to its source where a point lies behind that."""
        arms = points - self.source
        along = arms @ self.direction
        across = arms - np.where(np.real(along) > 0, along, 0)[:, None] * self.direction
        return np.sqrt(np.einsum("ni,ni->n", across, across))

    def meet(self, origins: NDArray[Any], directions: NDArray[Any]) -> Meetings:
        """One meeting per ray; none behind the laser, where there is no light."""
        meetings = super().meet(origins, directions)
        reach = (np.atleast_2d(origins) - self.source) @ self.direction
        infinite = ~np.isfinite(meetings.distance)
        along = reach + np.where(infinite, 0, meetings.distance) * (directions @ self.direction)
        unlit = ~infinite & (np.real(along) < 0)
        return Meetings(meetings.distance, np.where(unlit, MeetingFlag.NONE, meetings.flags).astype(np.uint8))

    @property
    def normal(self) -> NDArray[Any]:
        return self._foot / self.level

    @property
    def level(self) -> Any:
        return np.sqrt(self._foot @ self._foot)

    @property
    def normal_by_parameters(self) -> NDArray[Any]:
        """A unit vector turns by the part of its arrow's motion across it."""
        normal, motion = self.normal, self._foot_by_parameters
        return (motion - np.outer(normal, normal @ motion)) / self.level

    @property
    def level_by_parameters(self) -> NDArray[Any]:
        return self.normal @ self._foot_by_parameters

    @property
    def _foot(self) -> NDArray[Any]:
        """(3,) [m]: the beam's point nearest to the pupil."""
        return self.source - self.direction * (self.source @ self.direction)

    @property
    def _foot_by_parameters(self) -> NDArray[Any]:
        """(3, 5)."""
        source, direction = self.source, self.direction
        along, across = np.cos(self.zenith), np.sin(self.zenith)
        sine, cosine = np.sin(self.clock), np.cos(self.clock)
        turns = np.array([[along * sine, across * cosine], [-along * cosine, across * sine], [-across, 0.0]])
        by_turns = -turns * (source @ direction) - np.outer(direction, source @ turns)
        return np.hstack([np.eye(3) - np.outer(direction, direction), by_turns])
