"""Cameras and laser surfaces that move together, and the heart: a camera ray meets a laser surface.

`Rig`, `Laser`   what a rig file describes; `CONFIGURATIONS` it may name
`Mount`          where the camera stands in the rig: `FORWARD`, or `SideFacing` on a rotating head
`ValidRegion`    where a calibration had points
`read_rig`, `write_rig`   rig.toml (formats.md, section 3); `parts_toml` what a calibration found of one, as text
`read_camera`    -> `KnownCamera`, with a rig or without; `read_rig_or_camera`
`Probe`, `read_probe`   a tactile probe: ratio of voltages to radius
`triangulate`    pixels to wall points, with sensitivities to pixel and parameters
`meetings_of`, `follow_stripe`   all meetings of the rays, and which of them a stripe is made of
`margin`         how far a meeting is from where first-order uncertainty, or the meeting itself, ceases to be
`measure`        -> `Measured`: millions of pixels to wall points with uncertainty, by the compiled engine
`monte_carlo`    -> `Drawn`: the same by random draws of pixels and rig, near frontiers too
                 `adaptive_monte_carlo` -> `Settled`: until what it says no longer changes
`moved`          the same rig with other values of its parameters; `value_of`, `values_of`, `camera_value`: those it has
`lit_points`     what a laser lights on a round wall
`project_ring`   where a round wall would appear in the image
"""

from calibore.rigs._candidates import Candidates, follow_stripe, meetings_of
from calibore.rigs._configurations import CONFIGURATIONS, Configuration
from calibore.rigs._defaults import DEFAULT_LENGTH_LIMIT
from calibore.rigs._drawing import Drawn, DrawnQuantity, monte_carlo
from calibore.rigs._engine import engine_form
from calibore.rigs._known_camera import KnownCamera, read_camera, read_rig_or_camera
from calibore.rigs._lit import lit_points
from calibore.rigs._margin import margin
from calibore.rigs._measuring import Measured, measure
from calibore.rigs._mount import FORWARD, Forward, Mount, SideFacing
from calibore.rigs._moving import moved
from calibore.rigs._probe import Probe, read_probe
from calibore.rigs._reading import read_rig
from calibore.rigs._rig import CHANNELS, Laser, Rig
from calibore.rigs._ring import project_ring
from calibore.rigs._settling import Settled, adaptive_monte_carlo
from calibore.rigs._triangulation import Sensitivities, Triangulation, triangulate
from calibore.rigs._valid import ValidRegion
from calibore.rigs._values import camera_value, value_of, values_of
from calibore.rigs._writing import parts_toml, write_rig

__all__ = [
    "CHANNELS",
    "CONFIGURATIONS",
    "DEFAULT_LENGTH_LIMIT",
    "FORWARD",
    "Candidates",
    "Configuration",
    "Drawn",
    "DrawnQuantity",
    "Forward",
    "KnownCamera",
    "Laser",
    "Measured",
    "Mount",
    "Probe",
    "Rig",
    "Sensitivities",
    "Settled",
    "SideFacing",
    "Triangulation",
    "ValidRegion",
    "adaptive_monte_carlo",
    "camera_value",
    "engine_form",
    "follow_stripe",
    "lit_points",
    "margin",
    "measure",
    "meetings_of",
    "monte_carlo",
    "moved",
    "parts_toml",
    "project_ring",
    "read_camera",
    "read_probe",
    "read_rig",
    "read_rig_or_camera",
    "triangulate",
    "value_of",
    "values_of",
    "write_rig",
]
