"""A design to be studied: a configuration in numbers, from which its rig follows; and how its lengths may vary."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.design import _studies as rigs_of
from calibore.design._assumptions import HONEST, Assumptions
from calibore.design._cameras import Axis
from calibore.design._spots import spot_array_rig
from calibore.errors import InputError
from calibore.rigs import Rig


@dataclass(frozen=True)
class Kind:
    """A configuration: `baseline` and `projection` it starts from (None: it has none), what they are called, the
    baselines worth looking at, and whether its camera is made for a maximum radius.
    """

    baseline: float
    projection: float | None
    baseline_name: str
    least: float
    most: float
    for_maximum: bool = True


KINDS = {
    "perpendicular-plane": Kind(2.0, None, "baseline: laser plane ahead of the camera", 0.25, 5.0),
    "single-cone": Kind(0.5, 2.0, "baseline: laser beside the camera", 0.05, 0.95, for_maximum=False),
    "dual-cone": Kind(0.5, 2.0, "baseline: lasers beside the camera", 0.05, 0.95, for_maximum=False),
    "side-facing": Kind(0.4, None, "baseline: camera beside the sheet", 0.1, 0.9),
    "coaxial-cone": Kind(1.0, 1.0, "offset: apex ahead of the camera", 0.25, 5.0),
    "asymmetric-cone": Kind(0.5, 1.0, "baseline: laser beside the camera", 0.05, 0.9, for_maximum=False),
    "reversed-cone": Kind(3.0, 1.0, "offset: apex ahead of the camera", 0.25, 6.0),
    "rotating-spot": Kind(0.4, None, "baseline: sensor beside the spot", 0.1, 0.9),
    "spot-array": Kind(2.0, None, "baseline: beams ahead of the camera", 0.25, 5.0),
}
PROJECTIONS = (0.25, 5.0)
SECOND_CLOCK = -np.pi / 2  # Swanbom 2007, section 3.3.5


@dataclass(frozen=True)
class Study:
    """`configuration` of `KINDS` for a pipe of `nominal_radius` [m]; `baseline`, `projection`, `maximum_radius` in
    nominal radii (by default those of the kind); `across` the axis of the image that holds a cone's field of view.
    """

    configuration: str
    nominal_radius: float
    baseline: float | None = None
    projection: float | None = None
    second_clock: float = SECOND_CLOCK
    maximum_radius: float = 2.0
    beams: int = 8
    width: int = 1024
    height: int = 768
    lens: str = "equidistant"
    across: Axis = "short"
    inputs: Assumptions = HONEST

    def __post_init__(self) -> None:
        if self.configuration not in KINDS:
            raise InputError(f'Configuration "{self.configuration}" is not known; allowed: {", ".join(KINDS)}.')
        if not 0 < self.nominal_radius < np.inf:
            raise InputError(f"The nominal radius must be positive, got {self.nominal_radius} m.")
        kind = KINDS[self.configuration]
        if self.baseline is None:
            object.__setattr__(self, "baseline", kind.baseline)
        if self.projection is None:
            object.__setattr__(self, "projection", kind.projection)
        elif kind.projection is None:
            raise InputError(f"A {self.configuration} rig has no projection, got {self.projection:g}; leave it out.")

    @property
    def kind(self) -> Kind:
        return KINDS[self.configuration]

    def rig(self) -> Rig:
        """The rig; raises InputError where these numbers make none."""
        if self.configuration == "spot-array":
            return spot_array_rig(self._baseline, beams=self.beams, height=self.height, **self._all, **self._most)
        if self.configuration == "perpendicular-plane":
            return rigs_of.plane_rig(self._baseline, height=self.height, **self._all, **self._most)
        if self.configuration == "side-facing":
            return rigs_of.side_rig(self._baseline, height=max(self.height, 2), **self._all, **self._most)
        if self.configuration == "rotating-spot":
            return rigs_of.spot_rig(self._baseline, **self._all, **self._most)
        return self._cone()

    def _cone(self) -> Rig:
        lengths, size = (self._baseline, float(self.projection or 0.0)), {"height": self.height, **self._all}
        if self.configuration == "coaxial-cone":
            return rigs_of.coaxial_rig(*lengths, **size, **self._most)
        if self.configuration == "reversed-cone":
            return rigs_of.reversed_rig(*lengths, **size, **self._most)
        if self.configuration == "asymmetric-cone":
            return rigs_of.asymmetric_rig(*lengths, across=self.across, **size)
        second = self.second_clock if self.configuration == "dual-cone" else None
        return rigs_of.cone_rig(*lengths, second_clock=second, across=self.across, **size)

    def baselines(self, n: int) -> NDArray[np.float64]:
        """`n` baselines worth a look, this one's neighbourhood included."""
        least, most = self.kind.least, self.kind.most
        return np.geomspace(min(least, self._baseline), max(most, self._baseline), n)

    def projections(self, n: int) -> NDArray[np.float64]:
        """`n` projections worth a look; none where the configuration has no projection."""
        if self.projection is None:
            return np.zeros(0)
        return np.geomspace(min(PROJECTIONS[0], self.projection), max(PROJECTIONS[1], self.projection), n)

    def varied(self, name: str, values: Iterable[float]) -> "list[Rig | None]":
        """The rigs with `name` (baseline, projection) at each of `values`; None where they make no rig."""
        return [_rig_or_none(replace(self, **{name: float(value)})) for value in values]

    @property
    def _baseline(self) -> float:
        return float(self.baseline or 0.0)

    @property
    def _all(self) -> dict[str, Any]:
        return {"nominal_radius": self.nominal_radius, "width": self.width, "lens": self.lens, "inputs": self.inputs}

    @property
    def _most(self) -> dict[str, Any]:
        return {"maximum_radius": self.maximum_radius}


def _rig_or_none(study: Study) -> Rig | None:
    try:
        return study.rig()
    except InputError:
        return None
