"""Tables that calibrate a tactile probe: lengths under a caliper, diameters in a pipe."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.rigs import Probe
from calibore.simulation._targets._target import Layout, Said, Target
from calibore.simulation._targets._toml import metres

Array = NDArray[np.float64]

CALIPER = 0.0005 * 0.0254 / np.sqrt(3)
"""m; limits of 0.0005 in (Swanbom 2007, 8.2.3), anywhere between them."""
CONTACT = 0.001 * 0.0254
"""m; how far the spots that ball and caliper touch differ (Swanbom 2007, 8.2)."""
ROUNDS = 4


@dataclass(frozen=True, eq=False)
class ProbeTarget(Target):
    """`probe` as it truly is, with the noise of a reading. Its `lengths`, evenly over its stroke, are measured by a
    caliper that counts from `origin` [m]; diameters in the pipe at pairs of opposite `stops`, where it truly reaches
    `contacts` (m pairs) [m]. `bend` [m]: amplitude of the second Legendre polynomial over the stroke by which the probe
    is not straight; `wrong` [m]: by how much each diameter was misread.

    `u_caliper`, `u_contact` [m]: of a reading of the caliper (anywhere within its limits) and of one contact.
    """

    probe: Probe
    contacts: tuple[tuple[float, float], ...]
    stops: tuple[tuple[int, int], ...] = ()
    lengths: int = 34
    origin: float = 0.0635
    bend: float = 0.0
    wrong: tuple[float, ...] = ()
    u_caliper: float = float(CALIPER)
    u_contact: float = CONTACT
    stated: Said = field(default_factory=dict)

    verb: ClassVar[str] = "probe"

    def __post_init__(self) -> None:
        if not self.contacts or self.lengths < 2 or min(self.u_caliper, self.u_contact) < 0:
            raise InputError("A probe target needs a diameter, two lengths, and uncertainties that are not negative.")
        if any(part and len(part) != len(self.contacts) for part in (self.stops, self.wrong)):
            raise InputError(
                f"A probe target has as many stops and wrong as contacts: {len(self.contacts)}, got {len(self.stops)} "
                f"and {len(self.wrong)}; leave them empty or complete them."
            )

    def laid_out(self, rng: np.random.Generator) -> Layout:
        """Tables with the errors of caliper, contacts and readings."""
        ratio = np.linspace(*self.probe.stroke, self.lengths)
        length = true_reach(self.probe, ratio, bend=self.bend) - self.probe.intercept + self.origin
        contact = np.array(self.contacts, dtype=float)
        diameter = (contact + self.u_contact * rng.standard_normal(contact.shape)).sum(axis=1)
        diameter += np.array(self.wrong) if self.wrong else 0.0
        read = ratio_of(self.probe, contact, bend=self.bend)
        noise = self.probe.noise / abs(self.probe.slope)
        ratio, read = (part + noise * rng.standard_normal(part.shape) for part in (ratio, read))
        length, diameter = (part + self._caliper(part.size, rng) for part in (length, diameter))
        stops = np.array(self.stops or [(n, n + len(contact)) for n in range(len(contact))])
        return Layout(
            said={
                "kind": "probe",
                "probe_calibration": "probe_calibration.csv",
                "diameters": "diameters.csv",
                "u_caliper": metres(self.u_caliper),
                "u_contact": metres(self.u_contact),
            },
            truth={
                "probe.slope": self.probe.slope,
                "probe.intercept": self.probe.intercept,
                "probe.bend": self.bend,
                "contacts": contact,
                "wrong": np.array(self.wrong or [0.0] * len(contact)),
            },
            files={
                "probe_calibration.csv": _table("raw_ratio,caliper_length_m (arbitrary origin)", ratio, length),
                "diameters.csv": _table(
                    "angular_index_1,angular_index_2,raw_1,raw_2,caliper_diameter_m", stops, read, diameter
                ),
            },
        )

    def _caliper(self, count: int, rng: np.random.Generator) -> Array:
        return np.sqrt(3) * self.u_caliper * rng.uniform(-1, 1, count)


def true_reach(probe: Probe, ratio: Array, *, bend: float) -> Array:
    """Radius [m] at each ratio of a probe that is bent."""
    low, high = probe.stroke
    place = (2 * ratio - low - high) / (high - low)
    return probe.radius(ratio) + bend * (3 * place**2 - 1) / 2


def ratio_of(probe: Probe, radius: Array, *, bend: float) -> Array:
    """The ratio at which a bent probe reaches each radius [m]; the bend is small against the stroke."""
    ratio = (radius - probe.intercept) / probe.slope
    for _ in range(ROUNDS if bend else 0):
        ratio = ratio - (true_reach(probe, ratio, bend=bend) - radius) / probe.slope
    return ratio


def _table(header: str, *columns: Array) -> str:
    rows = np.column_stack(columns)
    return f"# {header}\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows.tolist())
