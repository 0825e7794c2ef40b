"""The folder of a simulated scan by touch: voltages, scan.toml, what the probe's calibration is made of, truth.npz.

truth.npz has the keys of the other simulated scan by touch: `R_contact` (ring, stop) the end of the ball, `R_geometric`
the wall where the pin points, both from the probe's axis, `wall_R` the wall from the pipe's, in inches, as are `H` and
`pose_t`; `phi` [rad] the clocks; `stuck`, `off_tip` which readings are not the wall. Dotted names are SI.
"""

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.crews import Workers, in_order
from calibore.folders import whole_folder
from calibore.rigs import Probe
from calibore.simulation._files import earlier_simulation, tactile_toml, write_truth
from calibore.simulation._tactile._contact import Touch, touched
from calibore.simulation._tactile._survey import TactileSurvey
from calibore.simulation._targets._probe import ProbeTarget, ratio_of
from calibore.simulation._targets._toml import metres, toml_text
from calibore.units import parse_quantity

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Progress = Callable[[int, int], None]
READINGS, CALIBRATION = 0, 1  # streams of chance


def simulate_tactile(
    folder: Path | str,
    touch: TactileSurvey,
    *,
    seed: int,
    workers: Workers | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write the tactile scan `folder` (formats.md, section 2) with truth.npz beside it; returns the folder.

    The same survey and seed give the same bytes. `progress(done, total)` counts rings. The folder appears when it is
    complete; an earlier one is replaced only if it holds nothing but an earlier simulation. Raises OutputError.
    """
    folder = Path(folder).absolute()
    crew = workers or os.cpu_count() or 1
    with whole_folder(folder, earlier_simulation, what="simulated scan") as staging:
        rings: list[Touch] = []
        for ring in in_order(range(touch.stations), partial(_ring, touch), workers=crew):
            rings.append(ring)
            if progress is not None:
                progress(len(rings), touch.stations)
        contact, wall = (np.stack([getattr(ring, key) for ring in rings]) for key in ("reading", "wall"))
        shank = np.stack([ring.shank for ring in rings])
        rng = np.random.default_rng([seed, READINGS])
        stuck, reading = _read(touch, contact, rng)
        raw = ratio_of(touch.probe, reading, bend=touch.bend)
        raw = raw + touch.probe.noise / abs(touch.probe.slope) * rng.standard_normal(raw.shape)
        bias = touch.bias[0] + touch.bias[1] * rng.standard_normal(raw.shape)
        np.savetxt(staging / "signal.csv", raw * bias, delimiter=",", fmt="%.6f")
        np.savetxt(staging / "bias.csv", bias, delimiter=",", fmt="%.6f")
        (staging / "scan.toml").write_text(_scan_toml(touch), encoding="utf-8")
        _write_probe(staging, touch, contact, seed)
        off_tip = shank | (wall - contact > touch.tip_radius)
        truth = {"signal": raw * bias, "bias": bias, "raw": raw, "stuck": stuck, "off_tip": off_tip}
        write_truth(staging, truth | _places(touch, contact, wall))
    return folder


def _ring(touch: TactileSurvey, station: int) -> Touch:
    return touched(touch.wall, touch.pose_at(station), touch.clocks, tip_radius=touch.tip_radius, shank=touch.shank)


def _read(touch: TactileSurvey, contact: Array, rng: np.random.Generator) -> tuple[Mask, Array]:
    """Which readings (n, m) are stuck, and all of them [m] with what sticking and drift do, but without noise."""
    after = np.abs(np.roll(contact, -1, axis=1) - contact) > 2 * touch.tip_radius
    stuck = (after | np.roll(after, 1, axis=1)) & (rng.random(contact.shape) < touch.sticking.probability)
    time = np.pi / 2 * np.linspace(0.0, 1.0, touch.stations)[:, None]
    cosine, sine = touch.drift * rng.standard_normal(2)
    reading = contact + cosine * np.cos(time) + sine * np.sin(time)
    return stuck, reading + stuck * rng.uniform(*touch.sticking.reach, contact.shape)


def _places(touch: TactileSurvey, contact: Array, wall: Array) -> dict[str, object]:
    inch = parse_quantity("1 in", "length")
    return {
        "R_contact": contact / inch,
        "R_geometric": wall / inch,
        "wall_R": touch.wall.radius(touch.axials[:, None], touch.clocks) / inch,
        "H": touch.axials / inch,
        "phi": touch.clocks,
        "pose_R": touch.pose.rotation,
        "pose_t": touch.pose.translation / inch,
        "probe.slope": touch.probe.slope,
        "probe.intercept": touch.probe.intercept,
        "probe.bend": touch.bend,
        "tip_radius": touch.tip_radius,
    }


def _scan_toml(touch: TactileSurvey) -> str:
    step = 2 * np.pi / touch.stops
    return tactile_toml(
        name=touch.name,
        nominal_radius=touch.wall.nominal_radius,
        tip_radius=touch.tip_radius,
        axial=(touch.origin, touch.step),
        angular=(touch.clock, step),
        probe=None if touch.stated is None else "probe.toml",
        drift=touch.stated_drift,
    )


def _write_probe(staging: Path, touch: TactileSurvey, contact: Array, seed: int) -> None:
    """The probe's file, or the tables that calibrate it."""
    if touch.stated is not None:
        (staging / "probe.toml").write_text(_probe_toml(touch.stated), encoding="utf-8")
        return
    known = touch.diameters
    target = ProbeTarget(
        touch.probe,
        tuple((float(contact[known.ring, one]), float(contact[known.ring, other])) for one, other in touch.opposite),
        touch.opposite,
        lengths=known.lengths,
        bend=touch.bend,
        wrong=known.wrong,
        u_caliper=known.u_caliper,
        u_contact=known.u_contact,
    )
    layout = target.laid_out(np.random.default_rng([seed, CALIBRATION]))
    for name, text in layout.files.items():
        (staging / name).write_text(text, encoding="utf-8")
    text = toml_text({"format": "calibore-target/1", **layout.said})
    (staging / "target.toml").write_text(text, encoding="utf-8")


def _probe_toml(probe: Probe) -> str:
    lengths = {key: metres(getattr(probe, key)) for key in ("slope", "intercept", "noise", "linearity")}
    text = toml_text({"format": "calibore-rig/1", "configuration": "tactile-probe"})
    text += "\n[probe]\n" + toml_text({**lengths, "stroke": list(probe.stroke)})
    if not probe.covariance.u.any():
        return text
    freedom = probe.degrees_of_freedom if np.isfinite(probe.degrees_of_freedom) else None
    known = {"parameters": probe.covariance.names, "covariance": probe.covariance.matrix.tolist()}
    return text + "\n[calibration]\n" + toml_text({**known, "degrees_of_freedom": freedom})
