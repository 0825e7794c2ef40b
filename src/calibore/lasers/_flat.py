"""What all flat surfaces share: F = normal . x - level, one meeting per ray."""

from abc import abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.lasers._surface import GRAZING_SINE, Frontier, LaserSurface, MeetingFlag, Meetings

RECEDING = 4.0  # distance = height / slope: its relative second-order term is u(slope) / slope = 1 / (4 margin)
RECEDES, NO_FOLD = np.array([[RECEDING]]), np.array([False])


class FlatSurface(LaserSurface):
    """A surface is flat by telling its normal and level, and how both move with its parameters."""

    @property
    @abstractmethod
    def normal(self) -> NDArray[Any]:
        """(3,), of any length: the gradient of F."""

    @property
    @abstractmethod
    def level(self) -> Any:
        """`normal` . x on the surface."""

    @property
    @abstractmethod
    def normal_by_parameters(self) -> NDArray[Any]:
        """(3, q)."""

    @property
    @abstractmethod
    def level_by_parameters(self) -> NDArray[Any]:
        """(q,)."""

    def value(self, points: NDArray[Any]) -> NDArray[Any]:
        return points @ self.normal - self.level

    def gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        return np.broadcast_to(self.normal, points.shape)

    def parameter_gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        return points @ self.normal_by_parameters - self.level_by_parameters

    def meet(self, origins: NDArray[Any], directions: NDArray[Any]) -> Meetings:
        """One meeting per ray, at infinity where the ray runs along the surface."""
        normal = self.normal
        slope = directions @ normal
        parallel = slope == 0
        distance = np.where(parallel, np.inf, -self.value(np.atleast_2d(origins)) / np.where(parallel, 1, slope))
        grazing = np.abs(slope) < GRAZING_SINE * np.linalg.norm(np.real(normal))
        flags = np.where(np.isnan(slope), MeetingFlag.NONE, MeetingFlag.NEAR).astype(np.uint8)
        flags |= np.where(grazing, MeetingFlag.GRAZING, MeetingFlag.NONE).astype(np.uint8)
        flags |= np.where(np.real(distance) <= 0, MeetingFlag.BEHIND, MeetingFlag.NONE).astype(np.uint8)
        return Meetings(distance[None], flags[None])

    def frontier(self, origins: NDArray[Any], directions: NDArray[Any]) -> Frontier:
        """One row: normal . u towards the surface, thus positive where the meeting is ahead of the ray's origin."""
        side = np.where(np.real(self.value(np.atleast_2d(origins))) > 0, -1.0, 1.0)
        side = np.broadcast_to(side, directions.shape[:1])
        by_direction = side[:, None] * self.normal
        by_parameters = side[:, None] * (directions @ self.normal_by_parameters)
        value = side * (directions @ self.normal)
        none = np.zeros_like(by_direction)
        return Frontier(value[None], none[None], by_direction[None], by_parameters[None], RECEDES, NO_FOLD)
