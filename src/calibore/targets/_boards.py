"""Flat boards: what is printed on them, and where."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError

Array = NDArray[np.float64]

BOARD_KINDS = ("chessboard", "charuco", "circle-grid", "asymmetric-circle-grid")
DICTIONARY = "4x4_50"
FEWEST = 3  # marks along a side; fewer carry no shape
MOST = 100
LEAST_MARKER = 0.01
"""Of a square: the marker's side, and what it leaves of the square."""


@dataclass(frozen=True)
class Board:
    """`kind` of `BOARD_KINDS`; `corners` (columns, rows) of inner corners or dots. Lengths in squares, or pitches:
    `marker` the side of a ChArUco marker, from OpenCV's `dictionary`; `dot` the diameter of a dot.

    Asymmetric grids as OpenCV counts them: every second row is shifted by one pitch, dots of a row lie two pitches
    apart. A ChArUco board is that of OpenCV 4.6 and later.
    """

    kind: str
    corners: tuple[int, int]
    marker: float = 0.75
    dictionary: str = DICTIONARY
    dot: float = 0.5

    def __post_init__(self) -> None:
        if self.kind not in BOARD_KINDS:
            raise InputError(f'Board kind "{self.kind}" is not known; allowed: {", ".join(BOARD_KINDS)}.')
        if len(self.corners) != 2 or not all(FEWEST <= count <= MOST for count in self.corners):
            raise InputError(
                f"A board has {FEWEST} to {MOST} corners (or dots) along each side, got {list(self.corners)}; "
                "count inner corners, where four squares meet."
            )
        if not LEAST_MARKER <= self.marker <= 1 - LEAST_MARKER:
            raise InputError(
                f"A ChArUco marker is smaller than its square, got {self.marker:g} squares; measure its black side."
            )
        if not 0 < self.dot < (np.sqrt(2) if self.kind.startswith("asym") else 1):
            raise InputError(f"Dots must not touch each other, got a diameter of {self.dot:g} pitches.")

    @property
    def has_dots(self) -> bool:
        return self.kind.endswith("circle-grid")

    @cached_property
    def places(self) -> Array:
        """Places (n, 2) of all marks, row by row, in squares from the first: x along a row, y down the rows."""
        columns, rows = self.corners
        row, column = np.divmod(np.arange(columns * rows), columns)
        x = 2 * column + row % 2 if self.kind.startswith("asym") else column
        return np.stack([x, row], axis=1).astype(float)

    @property
    def mark(self) -> str:
        """What its marks are called, in the plural."""
        return "dots" if self.has_dots else "corners"
