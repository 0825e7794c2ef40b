"""Tables of a tactile probe with known slope and intercept."""

import numpy as np

from calibore.calibration._in_words import Unit
from calibore.calibration._probe._calibrate import probe_of
from calibore.calibration._probe._line import fit_line
from calibore.calibration._probe._tables import ProbeTables, ProbeTarget

INCH = 0.0254
SLOPE, INTERCEPT, ORIGIN = 5.2405 * INCH, 4.5706 * INCH, 7.07 * INCH


def target(**more):
    return ProbeTarget(
        format="calibore-target/1", kind="probe", probe_calibration="lengths.csv", diameters="diameters.csv", **more
    )


def tables(rng, *, lengths=34, diameters=3, noise=1.5e-4, wrong=0.0, bend=0.0, drift=0.0, order=None):
    """Noise [ratio] of a reading, caliper and contacts as uncertain as target.toml assumes; the first diameter is
    `wrong` [m]; the line bends by `bend` [m] and drifts by `drift` [m] in all; lengths in this `order`.
    """
    said = target()
    ratio = np.linspace(0.02, 0.65, lengths)
    ratio = ratio if order is None else ratio[order]
    off = bend * (1 - ((ratio - 0.335) / 0.315) ** 2) + drift * np.linspace(0, 1, lengths)
    length = SLOPE * ratio + ORIGIN + off + rng.uniform(-1, 1, lengths) * np.sqrt(3) * said.u_caliper
    true = rng.uniform(0.2, 0.35, (diameters, 2))
    contact = rng.normal(0, said.u_contact, (diameters, 2)).sum(axis=1)
    caliper = rng.uniform(-1, 1, diameters) * np.sqrt(3) * said.u_caliper
    diameter = SLOPE * true.sum(axis=1) + 2 * INTERCEPT + contact + caliper
    diameter[0] += wrong
    raw = true + rng.normal(0, noise, true.shape)
    stops = np.arange(2 * diameters).reshape(diameters, 2)
    read = ratio + rng.normal(0, noise, lengths)
    return ProbeTables(said, read, length, stops, raw, diameter, Unit("in", INCH), ())


def found_in(made):
    """Probe, intercept and line that tables give."""
    line = fit_line(made.ratio, made.length)
    return (*probe_of(made, line), line)


def write(folder, made, *, more=""):
    """The same as a folder with target.toml."""
    rows = np.column_stack([made.ratio, made.length / INCH])
    np.savetxt(folder / "lengths.csv", rows, delimiter=",", header="raw_ratio,caliper_length_in (origin anywhere)")
    rows = np.column_stack([made.stops, made.raw, made.diameter / INCH])
    np.savetxt(folder / "diameters.csv", rows, delimiter=",", header="stop_1,stop_2,raw_1,raw_2,caliper_diameter_in")
    text = (
        'format = "calibore-target/1"\nkind = "probe"\nprobe_calibration = "lengths.csv"\ndiameters = "diameters.csv"\n'
    )
    (folder / "target.toml").write_text(text + more)
    return folder
