"""What a laser surface is, what a meeting of a camera ray with it looks like, and where meetings cease to exist."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import IntFlag
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

GRAZING_SINE = 0.01  # sine of the angle between ray and surface; there a pixel of 0.1 deg moves the meeting by 17 %


class MeetingFlag(IntFlag):
    """`NONE`: the ray has no such meeting. `NEAR`, `FAR`: which root; a plane has the near one only."""

    NONE = 0
    NEAR = 1
    FAR = 2
    GRAZING = 4
    BEHIND = 8


@dataclass(frozen=True, eq=False)
class Meetings:
    """`distance` (m, n) along each of n rays to its m possible meetings, and their `flags` (m, n) uint8.

    A meeting is admissible, that is lit and seen, when it exists and is neither grazing nor behind. Where there is
    none, the distance is NaN or infinite.
    """

    distance: NDArray[Any]
    flags: NDArray[np.uint8]

    @property
    def admissible(self) -> NDArray[np.bool_]:
        return (self.flags != MeetingFlag.NONE) & (self.flags & (MeetingFlag.GRAZING | MeetingFlag.BEHIND) == 0)


@dataclass(frozen=True, eq=False)
class Frontier:
    """Functions of n rays that fall to 0 where a meeting ceases to exist, with their derivatives.

    `value` (k, n); `by_origin`, `by_direction` (k, n, 3); `by_parameters` (k, n, q). `second_order` (k, m): the sum
    over k of second_order[k, j] u(value_k) / value_k is four times the relative second-order term of meeting j, signs
    included; 0 where a row does not concern a meeting. `folds` (k,): whether two meetings become one there, so that the
    distance to it, value_k / u(value_k), counts by itself. A value is infinite, and its derivatives are 0, where that
    frontier does not concern the ray.
    """

    value: NDArray[Any]
    by_origin: NDArray[Any]
    by_direction: NDArray[Any]
    by_parameters: NDArray[Any]
    second_order: NDArray[np.float64]
    folds: NDArray[np.bool_]


class LaserSurface(ABC):
    """F(x; q) = 0 in the rig frame. `parameter_names`: the q, in the order of `parameter_gradient`."""

    parameter_names: ClassVar[tuple[str, ...]]

    @abstractmethod
    def value(self, points: NDArray[Any]) -> NDArray[Any]:
        """F (n,) at `points` (n, 3)."""

    @abstractmethod
    def gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        """dF/dx (n, 3) at `points` (n, 3)."""

    @abstractmethod
    def parameter_gradient(self, points: NDArray[Any]) -> NDArray[Any]:
        """dF/dq (n, q) at `points` (n, 3)."""

    @abstractmethod
    def meet(self, origins: NDArray[Any], directions: NDArray[Any]) -> Meetings:
        """All meetings of the rays `origins` (n, 3) or (3,) + distance x unit `directions` (n, 3)."""

    @abstractmethod
    def frontier(self, origins: NDArray[Any], directions: NDArray[Any]) -> Frontier:
        """How far the meetings of the same rays are from ceasing to exist."""
