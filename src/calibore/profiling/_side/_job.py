"""What all stops of a side-facing scan share, checked before the first picture is read."""

from dataclasses import dataclass

import numpy as np

from calibore.errors import InputError
from calibore.images import ImageSource
from calibore.lasers import Sheet
from calibore.profiling._job import Job
from calibore.profiling._placement import Placer, open_source
from calibore.profiling._side._clocks import ClockGrid
from calibore.rigs import Rig, SideFacing, lit_points, read_rig, triangulate
from calibore.scans import AngularMotion, AxialMotion, ScanSpec
from calibore.stripe import estimator_named
from calibore.uncertainty import Covariance

ROWS_PER_CELL = 6.0
"""Picture rows on a nominal wall that fall into one step of the axial grid, at least."""


@dataclass(frozen=True)
class SideJob(Job):
    """`colour`: the channel looked at; `angular`: where the head stops; `clocks` and `axial_step` [m]: the grid, whose
    rows lie at multiples of the step; `search`: least and largest radius [m] of the wall.
    """

    colour: str
    angular: AngularMotion
    clocks: ClockGrid
    axial_step: float
    search: tuple[float, float]

    @property
    def channel(self) -> str:
        return self.colour


def prepare_side(spec: ScanSpec, *, estimator: str) -> tuple[SideJob, ImageSource, Placer]:
    """The job, its pictures, and where the carriage stood; raises InputError for whatever is wrong with the files."""
    estimator_named(estimator)
    toml = spec.folder / "scan.toml"
    if spec.video is not None:
        raise InputError(
            f"{toml}: a film does not say where the head stood; give images.pattern with the fields {{station}} and "
            "{angular} instead of images.video."
        )
    if spec.angular is None:
        raise InputError(
            f"{toml}: images.pattern has the field {{angular}}, but nothing says where the head stops; add "
            'motion.angular = { origin = "0 deg", step = "0.9 deg" }.'
        )
    rig = _side_rig(spec)
    source, channel, place = open_source(spec, rig)
    rig = rig.with_default_uncertainty(spec.nominal_radius)
    job = SideJob(
        rig,
        rig.covariance or Covariance.independent({}),
        (),
        estimator,
        spec.nominal_radius,
        rig.lasers[0].channel or channel,
        spec.angular,
        ClockGrid.of(spec.angular),
        _axial_step(spec, rig),
        (spec.search_inner * spec.nominal_radius, spec.search_outer * spec.nominal_radius),
    )
    return job, source, place


def _side_rig(spec: ScanSpec) -> Rig:
    assert spec.rig_path is not None  # read_scan asks for one wherever there are images
    rig = read_rig(spec.rig_path)
    if not isinstance(rig.mount, SideFacing) or not isinstance(rig.lasers[0].surface, Sheet):
        raise InputError(
            f"{spec.rig_path} describes a {rig.configuration} rig, but {spec.folder / 'scan.toml'} has angular stops, "
            "as only a side-facing head makes them; name the head's rig file, or remove {angular} and motion.angular."
        )
    return rig


def _axial_step(spec: ScanSpec, rig: Rig) -> float:
    """Spacing [m] of the grid along the pipe: as said, or the motion's step in parts of some rows each."""
    rows = _between_rows(rig, spec.nominal_radius)
    said = spec.axial_step
    if said is not None and said < rows:
        raise InputError(
            f"{spec.folder / 'scan.toml'}: grid.axial_step = {1e3 * said:.4g} mm is finer than the rows of the "
            f"pictures, which lie {1e3 * rows:.4g} mm apart on the nominal wall; give at least that, or leave it out."
        )
    if said is not None:
        return said
    least = ROWS_PER_CELL * rows
    motion = abs(spec.motion.step) if isinstance(spec.motion, AxialMotion) else 10 ** np.ceil(np.log10(least))
    parts = np.floor(motion / least)
    return float(motion / parts if parts else motion * np.ceil(least / motion))


def _between_rows(rig: Rig, radius: float) -> float:
    """Distance [m] along the pipe of neighbouring rows on a wall of `radius` [m], about the camera's axis."""
    u, v = rig.project(lit_points(rig, 0.0, radius))
    low, high = triangulate(rig, np.repeat(u, 2), v + np.array([-0.5, 0.5])).axial
    if not (0 <= u[0] < rig.camera.width and np.isfinite(high - low)):
        raise InputError(
            f"The head's camera does not see a wall of radius {radius:g} m in the laser sheet; check nominal_radius, "
            "baseline, aim, lens and k."
        )
    return abs(float(high - low))
