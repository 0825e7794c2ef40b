"""Simulated surveys with known truth: pipe walls, pictures of the laser line, whole scan folders.

`PipeWall` and its parts (`Ovality`, `Harmonic`, `Dent`, `Rail`, `LateralOpening`, `OffsetJoint`, `Roughness`)
`render_ring`    one picture; `lit_line` and `photograph` are its two halves, `true_ring` what it shows
`simulate_scan`  a `Survey` of `Station`s written as a scan folder with truth.npz
`demo_scan`      the demonstration pipe
`random_wall`, `random_rig`, `random_pose`, `draw_rig`   for studies over many rigs

Simple on purpose: laser planes, matt walls, light reflected once, Gaussian blur; no halo, no glare, no Bayer pattern.
"""

from calibore.simulation._chance import draw_rig, random_pose, random_rig, random_wall
from calibore.simulation._demo import demo_rig, demo_scan, demo_survey, demo_wall
from calibore.simulation._light import LineLight, LitLine, lit_line
from calibore.simulation._parts import (
    Dent,
    Harmonic,
    LateralOpening,
    OffsetJoint,
    Ovality,
    Rail,
    Roughness,
    WallPart,
)
from calibore.simulation._picture import line_image, photograph, render_ring
from calibore.simulation._sensor import Sensor
from calibore.simulation._speckle import speckle_field
from calibore.simulation._survey import Station, Survey, simulate_scan
from calibore.simulation._truth import TrueRing, true_quantities, true_ring
from calibore.simulation._wall import PipeWall

__all__ = [
    "Dent",
    "Harmonic",
    "LateralOpening",
    "LineLight",
    "LitLine",
    "OffsetJoint",
    "Ovality",
    "PipeWall",
    "Rail",
    "Roughness",
    "Sensor",
    "Station",
    "Survey",
    "TrueRing",
    "WallPart",
    "demo_rig",
    "demo_scan",
    "demo_survey",
    "demo_wall",
    "draw_rig",
    "line_image",
    "lit_line",
    "photograph",
    "random_pose",
    "random_rig",
    "random_wall",
    "render_ring",
    "simulate_scan",
    "speckle_field",
    "true_quantities",
    "true_ring",
]
