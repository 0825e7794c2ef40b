"""Side-facing heads: every picture a strip of the wall, all strips one grid R(axial, clock).

`side_measurement`   the measurement of a side-facing scan, ready to run
"""

from calibore.profiling._side._survey import side_measurement

__all__ = ["side_measurement"]
