"""The sheet of light of a side-facing head: x = offset + skew y + lean z in the head frame (formats.md, section 1)."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers._flat import FlatSurface
from calibore.lasers._possible import possible


@dataclass(frozen=True)
class Sheet(FlatSurface):
    """`offset` [m] from the rotation axis; `skew`, `lean`: slopes, 0 when the sheet contains the axis and the range.

    Swanbom 2007, eq. 5-1 and 5-2, whose sheet is x = 0.
    """

    offset: float = 0.0
    skew: float = 0.0
    lean: float = 0.0

    parameter_names: ClassVar[tuple[str, ...]] = ("offset", "skew", "lean")

    def __post_init__(self) -> None:
        if not possible([self.offset, self.skew, self.lean]):
            raise InputError(
                f"A sheet's offset, skew and lean are finite, got {self.offset} m, {self.skew} and {self.lean}; "
                "0 means through the rotation axis."
            )

    @property
    def normal(self) -> NDArray[Any]:
        return np.array([1.0, -self.skew, -self.lean])

    @property
    def level(self) -> Any:
        return self.offset

    @property
    def normal_by_parameters(self) -> NDArray[Any]:
        return np.array([[0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])

    @property
    def level_by_parameters(self) -> NDArray[Any]:
        return np.array([1.0, 0.0, 0.0])
