"""Marks of calibration targets found in pictures, to sub-pixel and with uncertainty. Knows no camera.

`RingMarks`   points on the rings and spokes of a concentric-ring target, by `find_rings`
`BoardMarks`  corners or dots of a flat `Board`, by `find_board`; `charuco_drawing`: a board to print
`PinMarks`    the axes of two pins, by `find_pins`
"""

from calibore.targets._boards import Board
from calibore.targets._boards_find import find_board
from calibore.targets._boards_opencv import charuco_drawing
from calibore.targets._marks import BoardMarks, PinMarks, RingMarks
from calibore.targets._pins import find_pins
from calibore.targets._rings import find_rings

__all__ = ["Board", "BoardMarks", "PinMarks", "RingMarks", "charuco_drawing", "find_board", "find_pins", "find_rings"]
