"""Simulated surveys with known truth: pipe walls, pictures of the laser line, whole scan folders.

`PipeWall` and its parts (`Ovality`, `Harmonic`, `Dent`, `Rail`, `LateralOpening`, `OffsetJoint`, `Roughness`,
                 `ConicalProtrusion`, `Crack`, `Corrugation`, or a `MeasuredWall`)
`render_ring`    one picture; `lit_line` and `photograph` are its two halves, `true_ring` or `true_rows` what it shows;
                 `photograph_all` several lasers at once
`simulate_scan`  a `Survey` of `Station`s written as a scan folder with truth.npz; `head_pose` of a side-facing head
`read_survey`    a `Survey` from a specification file; `Wander`: how its carriage strays
`simulate_target`  the folder of a calibration: a `RingTarget`, `RangeTarget`, `GaugeTarget`, `PinTarget`, `BoardTarget`
                 or `ProbeTarget`
`simulate_tactile`  a `TactileSurvey` (with `Sticking`, `Shank`, `Diameters`) written as a scan by touch
`read_subject`   any of these three from a specification file; `simulate` writes its folder
`demo_scan`      the demonstration pipe
`photograph_board`  a chessboard, ChArUco board or dots; `unknown_fisheye`: a camera whose lens no law fits
`photograph_flat`   a flat target before a side-facing head; a ring gauge is a `PipeWall`
`photograph_rings`  a target of concentric rings in a `TargetLight`
`photograph_pins`   upright `Pin`s seen from a `turntable_pose`
`random_wall`, `random_rig` of `RIG_KINDS`, `random_pose`, `draw_rig`   for studies over many rigs

What pictures suffer from, all of it off unless asked for: the wall's `Finish` with stains (`Patch`, `Band`, `Specks`;
a `Deposit` stands up from the wall), `Water`; a `Window` with `Smudge`s, `Ghost`s and halo; `Lamp`s and `Overlay`s; and
how pictures are stored (`Still`, `Film`).

Simple on purpose: planes, cones and sheets of light, light reflected once by the wall and perhaps once more by water or
window, Gaussian blur; no light from wall to wall, nothing seen through water, no Bayer pattern, no rolling shutter.
"""

from calibore.simulation._board_target import photograph_board, unknown_fisheye
from calibore.simulation._chance import draw_rig, random_pose, random_wall
from calibore.simulation._damage import ConicalProtrusion, Corrugation, Crack, MeasuredWall
from calibore.simulation._demo import demo_rig, demo_scan, demo_survey, demo_wall
from calibore.simulation._encoding import Film, Still
from calibore.simulation._finish import Finish
from calibore.simulation._known_surfaces import FlatFace, lit_flat, photograph_flat
from calibore.simulation._laboratory import Subject, read_subject, simulate
from calibore.simulation._lamp import Lamp, Overlay
from calibore.simulation._light import LineLight, LitLine, Stray, lit_line
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
from calibore.simulation._picture import line_image, photograph, photograph_all, render_ring
from calibore.simulation._pin_target import Pin, photograph_pins, turntable_pose
from calibore.simulation._random_rigs import RIG_KINDS, random_rig
from calibore.simulation._ring_target import photograph_rings
from calibore.simulation._sensor import Sensor
from calibore.simulation._soft_edges import TargetLight
from calibore.simulation._soiling import Band, Deposit, Patch, Specks, Stain
from calibore.simulation._spec import read_survey
from calibore.simulation._speckle import speckle_field
from calibore.simulation._stray import seen_through
from calibore.simulation._survey import Station, Survey, head_pose, simulate_scan
from calibore.simulation._tactile import Diameters, Shank, Sticking, TactileSurvey, simulate_tactile
from calibore.simulation._targets import (
    BoardTarget,
    Gauge,
    GaugeTarget,
    PinTarget,
    ProbeTarget,
    RangeTarget,
    RingTarget,
    Target,
    held_boards,
    simulate_target,
)
from calibore.simulation._truth import TrueRing, TrueRows, true_quantities, true_ring, true_rows
from calibore.simulation._wall import PipeWall
from calibore.simulation._wander import Wander
from calibore.simulation._water import Water
from calibore.simulation._window import Ghost, Smudge, Window

__all__ = [
    "RIG_KINDS",
    "Band",
    "BoardTarget",
    "ConicalProtrusion",
    "Corrugation",
    "Crack",
    "Dent",
    "Deposit",
    "Diameters",
    "Film",
    "Finish",
    "FlatFace",
    "Gauge",
    "GaugeTarget",
    "Ghost",
    "Harmonic",
    "Lamp",
    "LateralOpening",
    "LineLight",
    "LitLine",
    "MeasuredWall",
    "OffsetJoint",
    "Ovality",
    "Overlay",
    "Patch",
    "Pin",
    "PinTarget",
    "PipeWall",
    "ProbeTarget",
    "Rail",
    "RangeTarget",
    "RingTarget",
    "Roughness",
    "Sensor",
    "Shank",
    "Smudge",
    "Specks",
    "Stain",
    "Station",
    "Sticking",
    "Still",
    "Stray",
    "Subject",
    "Survey",
    "TactileSurvey",
    "Target",
    "TargetLight",
    "TrueRing",
    "TrueRows",
    "WallPart",
    "Wander",
    "Water",
    "Window",
    "demo_rig",
    "demo_scan",
    "demo_survey",
    "demo_wall",
    "draw_rig",
    "head_pose",
    "held_boards",
    "line_image",
    "lit_flat",
    "lit_line",
    "photograph",
    "photograph_all",
    "photograph_board",
    "photograph_flat",
    "photograph_pins",
    "photograph_rings",
    "random_pose",
    "random_rig",
    "random_wall",
    "read_subject",
    "read_survey",
    "render_ring",
    "seen_through",
    "simulate",
    "simulate_scan",
    "simulate_tactile",
    "simulate_target",
    "speckle_field",
    "true_quantities",
    "true_ring",
    "true_rows",
    "turntable_pose",
    "unknown_fisheye",
]
