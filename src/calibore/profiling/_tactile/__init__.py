"""Profiles by touch: a pin with a ball at its end, turned and pushed against the wall.

`tactile_measurement`   what `profile_scan` does with a tactile scan
"""

from calibore.profiling._tactile._measurement import tactile_measurement

__all__ = ["tactile_measurement"]
