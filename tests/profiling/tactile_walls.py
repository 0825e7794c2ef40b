"""A simulated probe in a simulated pipe, independent of the program: the ball is pushed out until it touches."""

from dataclasses import dataclass

import numpy as np

INCH = 0.0254
NOMINAL = 6 * INCH
TURN = 2 * np.pi


def bump(clock, axial, *, at, z, depth, width, length):
    """A smooth dent (depth > 0: inwards), `width` and `length` [m]."""
    across = (np.mod(clock - at + np.pi, TURN) - np.pi) * NOMINAL
    return -depth * np.exp(-0.5 * ((across / width) ** 2 + ((axial - z) / length) ** 2))


def cone(clock, axial, *, at, z, height, foot):
    """A protrusion with straight flanks."""
    across = (np.mod(clock - at + np.pi, TURN) - np.pi) * NOMINAL
    return -height * np.clip(1 - np.hypot(across, axial - z) / foot, 0, 1)


def rail(clock, axial, *, at, height, width):
    """A bar along the pipe with upright sides."""
    across = (np.mod(clock - at + np.pi, TURN) - np.pi) * NOMINAL
    return -height * (np.abs(across) < width / 2) + 0 * axial


def opening(clock, axial, *, at, z, radius, depth, edge):
    """A round opening whose edge falls off over `edge` [m]."""
    across = (np.mod(clock - at + np.pi, TURN) - np.pi) * NOMINAL
    share = np.clip((radius - np.hypot(across, axial - z)) / edge + 0.5, 0, 1)
    return depth * share**2 * (3 - 2 * share)


PARTS = {"bump": bump, "cone": cone, "rail": rail, "opening": opening}


@dataclass(frozen=True)
class Pipe:
    """Out of round, out of centre, with `parts` (name, numbers)."""

    waves: tuple = ()
    parts: tuple = ()
    slope: float = 0.0

    def radius(self, clock, axial):
        found = NOMINAL + self.slope * axial + 0 * clock
        for order, size, phase in self.waves:
            found = found + size * np.cos(order * (clock - phase))
        for name, numbers in self.parts:
            found = found + PARTS[name](clock, axial, **numbers)
        return found


def random_pipe(rng, *, sharp=True):
    """Waves and a dent; with `sharp`, a rail, an opening and a cone somewhere."""
    waves = tuple((n, rng.uniform(0, 0.015) * INCH / n, rng.uniform(0, TURN)) for n in (1, 2, 3, 5))
    start = rng.uniform(0, TURN)
    where = start + np.arange(4) * TURN / 4
    parts = [("bump", {"at": where[0], "z": rng.uniform(1, 3) * INCH, "depth": rng.uniform(-0.4, 0.4) * INCH,
                       "width": rng.uniform(0.8, 1.5) * INCH, "length": rng.uniform(0.8, 2) * INCH})]  # fmt: skip
    if sharp:
        parts += [
            ("rail", {"at": where[1], "height": rng.uniform(0.3, 0.9) * INCH, "width": rng.uniform(0.7, 2) * INCH}),
            ("opening", {"at": where[2], "z": rng.uniform(1, 3) * INCH, "radius": rng.uniform(0.7, 1.2) * INCH,
                         "depth": rng.uniform(0.4, 0.8) * INCH, "edge": rng.uniform(0.1, 0.4) * INCH}),
            ("cone", {"at": where[3], "z": rng.uniform(1, 3) * INCH, "height": rng.uniform(0.5, 1) * INCH,
                      "foot": rng.uniform(1.3, 2) * INCH}),
        ]  # fmt: skip
    return Pipe(waves, tuple(parts), rng.uniform(-0.003, 0.003))


def touched(pipe, clock, axial, *, tip_radius, fine=17):
    """Radius (n, m) to the end of the ball where it first touches, pushed out at each clock (m,) and axial (n,)."""
    turned, along = np.meshgrid(clock, axial)
    reading = pipe.radius(turned, along)
    reach = tip_radius / (0.7 * NOMINAL)
    for angle in np.linspace(-reach, reach, fine):
        for shift in np.linspace(-tip_radius, tip_radius, fine):
            wall = pipe.radius(turned + angle, along + shift)
            inside = tip_radius**2 - (wall * np.sin(angle)) ** 2 - shift**2
            stop = wall * np.cos(angle) - np.sqrt(np.maximum(inside, 0)) + tip_radius
            reading = np.where(inside > 0, np.minimum(reading, stop), reading)
    return reading


@dataclass(frozen=True)
class Touched:
    """`wall` (n, m) [m] where the pin points; `reading` [m] with noise; which are `stuck`, which `off_tip`."""

    clock: np.ndarray
    axial: np.ndarray
    wall: np.ndarray
    contact: np.ndarray
    reading: np.ndarray
    stuck: np.ndarray
    off_tip: np.ndarray

    @property
    def bad(self):
        return self.stuck | self.off_tip


def scanned(pipe, rng, *, rings=40, stops=400, step=0.1 * INCH, tip_radius=INCH / 16, noise=0.0006 * INCH, stick=0.3,
            rough=0.0):  # fmt: skip
    """Where the contact jumps by more than a tip's diameter, the pin sticks too far out beside it, now and then."""
    clock, axial = np.arange(stops) * TURN / stops, np.arange(rings) * step
    wall = pipe.radius(*np.meshgrid(clock, axial))
    contact = touched(pipe, clock, axial, tip_radius=tip_radius)
    texture = rough * rng.standard_normal(wall.shape)
    jump = np.abs(np.roll(contact, -1, 1) - contact) > 2 * tip_radius
    stuck = (jump | np.roll(jump, 1, 1)) & (rng.random(wall.shape) < stick)
    reading = contact + texture + noise * rng.standard_normal(wall.shape)
    reading = reading + stuck * rng.uniform(0.08, 0.7, wall.shape) * INCH
    return Touched(clock, axial, wall + texture, contact, reading, stuck, wall - contact > 1.2 * tip_radius)


SLOPE, INTERCEPT = 5.24 * INCH, 4.57 * INCH
PROBE = f"""format = "calibore-rig/1"
configuration = "tactile-probe"
[probe]
slope = "{SLOPE} m"
intercept = "{INTERCEPT} m"
noise = "0.0006 in"
stroke = [0.02, 0.66]
[calibration]
parameters = ["probe.slope", "probe.intercept"]
covariance = [[2.0e-10, 0.0], [0.0, 1.0e-10]]
"""
SCAN = """format = "calibore-scan/1"
name = "by touch"
[pipe]
nominal_radius = "6 in"
[tactile]
signal = "signal.csv"
bias = "bias.csv"
tip_radius = "0.0625 in"
probe = "probe.toml"
drift = "0 in"
[motion]
axial = { origin = "0 in", step = "0.1 in" }
angular = { origin = "0 deg", step = "0.9 deg" }
"""


def written(folder, reading, *, scan=SCAN, bias=5.0):
    """A scan folder with the voltages of the readings (n, m) [m]."""
    folder.mkdir(parents=True, exist_ok=True)
    ratio = (reading - INTERCEPT) / SLOPE
    np.savetxt(folder / "signal.csv", ratio * bias, delimiter=",", fmt="%.9f")
    np.savetxt(folder / "bias.csv", np.full(ratio.shape, bias), delimiter=",", fmt="%.6f")
    (folder / "probe.toml").write_text(PROBE)
    (folder / "scan.toml").write_text(scan)
    return folder
