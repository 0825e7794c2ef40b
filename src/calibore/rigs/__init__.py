"""Cameras and laser surfaces that move together, and the heart: a camera ray meets a laser surface.

`Rig`, `Laser`   what a rig file describes
`read_rig`       rig.toml (formats.md, section 3)
`triangulate`    pixels to wall points, with sensitivities to pixel and parameters
`project_ring`   where a round wall would appear in the image
"""

from calibore.rigs._reading import read_rig
from calibore.rigs._rig import CHANNELS, DEFAULT_BASELINE_LIMIT, Laser, Rig
from calibore.rigs._ring import project_ring
from calibore.rigs._triangulation import Sensitivities, Triangulation, triangulate

__all__ = [
    "CHANNELS",
    "DEFAULT_BASELINE_LIMIT",
    "Laser",
    "Rig",
    "Sensitivities",
    "Triangulation",
    "project_ring",
    "read_rig",
    "triangulate",
]
