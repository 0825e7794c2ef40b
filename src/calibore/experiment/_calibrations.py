"""The rig files of an experiment: exact, calibrated on the day, calibrated before the rig changed."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from calibore.calibration import Calibration, calibrate, write_calibration
from calibore.experiment._instruments import Instrument, head_of
from calibore.experiment._plan import Plan
from calibore.experiment._published import DESIGNED, INCH
from calibore.experiment._scans import DRIFTED, EXACT
from calibore.experiment._workshop import Workshop
from calibore.lasers import Cone, Plane
from calibore.rigs import Rig, write_rig
from calibore.simulation import Gauge, GaugeTarget, RangeTarget, RingTarget, Target, simulate_target
from calibore.uncertainty import Covariance

RINGS, SPOKES = 12, 8
U_RING, U_FLAT = 0.0005 * INCH, 0.003 * INCH
"""m; printing of the rings, and the slide that carries the flat: our assumptions."""
NEAREST, FARTHEST = 46, 120
"""Of the flat's stops, 0.1 in apart; Table 7.1 begins at 42, which the head as it is at the scan does not see."""
GAUGES = (10.5, 11.5, 12.5, 13.5)
"""in; diameters round the pipe's."""
VERBS = {"plane": "lens", "side": "rig", "cone": "rig"}


def prepared(instrument: Instrument, variant: str, workshop: Workshop) -> None:
    """Makes the target that a rig file is calibrated from, or the exact rig file."""
    place = workshop.calibration(variant, instrument.name)
    if variant == EXACT:
        workshop.made(place, partial(_write_exact, instrument.rig))
        return
    rig = instrument.before if variant == DRIFTED and instrument.before else instrument.rig
    target = target_of(instrument, rig, workshop.plan)
    seed = instrument.seed(workshop.plan) + (50 if variant == DRIFTED else 0)
    workshop.made(place.with_suffix(""), lambda out: simulate_target(out, target, seed=seed, workers=workshop.crew))


def calibrated(instrument: Instrument, variant: str, workshop: Workshop) -> None:
    """Makes the rig file that a target gives, once that is prepared."""
    if variant == EXACT:
        return
    place = workshop.calibration(variant, instrument.name)
    drift = instrument.drift if variant == DRIFTED else {}
    workshop.made(place, partial(_write_calibrated, place.with_suffix(""), VERBS[instrument.kind], drift), worth=0)


def target_of(instrument: Instrument, rig: Rig, plan: Plan) -> Target:
    """What calibrates `rig`, an instrument as it is on that day."""
    surface = rig.lasers[0].surface
    if isinstance(surface, Plane):
        said = {"u_ring": f"{1e3 * U_RING:.9g} mm"}
        return RingTarget(rig.camera, surface, INCH, RINGS, SPOKES, u_ring=U_RING, takes=plan.target_takes, stated=said)
    if isinstance(surface, Cone):
        cone = replace(surface, baseline=1.02 * surface.baseline, aim=surface.aim + np.radians(0.3))
        design = replace(rig, lasers=(replace(rig.lasers[0], surface=cone),))
        gauges = tuple(Gauge(size * INCH, (0.02 * INCH * number, 0.01 * INCH)) for number, size in enumerate(GAUGES))
        return GaugeTarget(rig, gauges, design=design, takes=plan.target_takes)
    indices = tuple(range(NEAREST, FARTHEST + 1, plan.flat_every))
    return RangeTarget(
        rig, indices, 0.1 * INCH, head_of(*DESIGNED), u_range=U_FLAT, takes=2, room_takes=(0,), line=instrument.line
    )


def _write_exact(rig: Rig, place: Path) -> None:
    """A rig file that says it knows everything exactly."""
    known = Covariance.independent({name: 0.0 for name in rig.parameter_names if name.startswith("laser")})
    write_rig(replace(rig, covariance=known), place)


def _write_calibrated(folder: Path, verb: str, drift: Mapping[str, str], place: Path) -> None:
    found: Calibration = calibrate(verb, folder)
    write_calibration(found, place)
    if drift:
        text = place.read_text(encoding="utf-8")
        lines = "".join(f"{key} = {_toml(value)}\n" for key, value in drift.items())
        place.write_text(f"{text}\n[drift]\n{lines}", encoding="utf-8")


def _toml(value: str) -> str:
    return f'"{value}"' if " " in value else value
