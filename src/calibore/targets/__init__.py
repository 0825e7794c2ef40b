"""Marks of calibration targets found in pictures, to sub-pixel and with uncertainty. Knows no camera.

`RingMarks`   points on the rings and spokes of a concentric-ring target
`BoardMarks`  corners or dots of a flat board
`PinMarks`    the edges of two pins
"""

from calibore.targets._marks import BoardMarks, PinMarks, RingMarks

__all__ = ["BoardMarks", "PinMarks", "RingMarks"]
