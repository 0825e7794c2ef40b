"""What all stations of a scan share."""

from dataclasses import dataclass

from calibore.profiling._lasers import Look, looks_of
from calibore.rigs import Rig
from calibore.scans import ScanSpec
from calibore.uncertainty import Covariance


@dataclass(frozen=True)
class Job:
    """What all stations share. `covariance` is the rig's, of parameters common to the scan; `looks` one per laser."""

    rig: Rig
    covariance: Covariance
    looks: tuple[Look, ...]
    estimator: str
    nominal_radius: float

    @classmethod
    def of(
        cls,
        rig: Rig,
        nominal_radius: float,
        *,
        channel: str = "red",
        estimator: str = "zero-crossing",
        inner: float = ScanSpec.search_inner,
        outer: float = ScanSpec.search_outer,
    ) -> "Job":
        """For pictures taken with `rig` in a pipe of `nominal_radius` [m], searched from `inner` to `outer` times that;
        `channel` for the lasers of which the rig file does not say one.
        """
        rig = rig.with_default_uncertainty(nominal_radius)
        channels = [laser.channel or channel for laser in rig.lasers]
        looks = looks_of(rig, nominal_radius, inner=inner, outer=outer, channels=channels)
        return cls(rig, rig.covariance or Covariance.independent({}), looks, estimator, nominal_radius)

    @property
    def channel(self) -> str:
        """The colour channels that are looked at."""
        return ", ".join(dict.fromkeys(look.channel for look in self.looks))
