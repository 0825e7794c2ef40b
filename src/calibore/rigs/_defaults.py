"""How well a laser's parameters are known where nobody says: lengths within +-0.1 % of the nominal radius.

The dissertation's assumption (sections 3.3.2, 4.3.2), taken as the limits of a rectangular distribution (JCGM 100,
4.3.7). Angles are not assumed apart: they are known through the lengths that set them, so they come correlated.
"""

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.lasers import Beam, Cone, LaserSurface, Plane
from calibore.rigs._mount import Mount, SideFacing
from calibore.uncertainty import Covariance

DEFAULT_LENGTH_LIMIT = 0.001  # of the nominal radius
Array = NDArray[np.float64]


def default_inputs(surface: LaserSurface, mount: Mount, nominal_radius: float, *, table: str) -> Covariance:
    """The default covariance of the parameters of one laser, named `table`.parameter."""
    u = DEFAULT_LENGTH_LIMIT * nominal_radius / np.sqrt(3)
    if isinstance(mount, SideFacing):
        return _through_lengths(("baseline", "aim"), _by_reach(mount), u, table=table)
    if isinstance(surface, Cone):
        return _through_lengths(
            ("baseline", "aim", "half_angle"), _by_projection(surface, nominal_radius), u, table=table
        )
    if isinstance(surface, Beam):
        angle = DEFAULT_LENGTH_LIMIT / np.sqrt(3)
        lengths = {f"{table}.{name}": u for name in ("x", "y", "z")}
        return Covariance.independent({**lengths, f"{table}.zenith": angle, f"{table}.clock": angle})
    if isinstance(surface, Plane):
        return Covariance.independent({f"{table}.baseline": u})
    raise InputError(f"There is no default uncertainty for a {type(surface).__name__}; state it in [uncertainty].")


def _through_lengths(names: tuple[str, ...], jacobian: Array, u: float, *, table: str) -> Covariance:
    return Covariance(tuple(f"{table}.{name}" for name in names), u**2 * (jacobian @ jacobian.T))


def _by_projection(cone: Cone, nominal_radius: float) -> Array:
    """(3, 2) derivatives of baseline, aim and half angle by the baseline and by the projection at which the cone's
    upper and lower rays fall on the nominal wall (Swanbom 2007, eqs. 3-46 to 3-51, for any cone).
    """
    upper, lower = cone.half_angle - cone.aim, cone.half_angle + cone.aim
    above, below = nominal_radius - cone.baseline, nominal_radius + cone.baseline
    by_upper = np.array([-np.sin(upper) * np.cos(upper), -(np.sin(upper) ** 2)]) / above
    by_lower = np.array([np.sin(lower) * np.cos(lower), -(np.sin(lower) ** 2)]) / below
    return np.stack([np.array([1.0, 0.0]), (by_lower - by_upper) / 2, (by_lower + by_upper) / 2])


def _by_reach(mount: SideFacing) -> Array:
    """(2, 2) derivatives of baseline and aim by the baseline and by the range at which the camera's axis meets the
    sheet: tan(aim) = baseline / range.
    """
    sine, cosine = np.sin(mount.aim), np.cos(mount.aim)
    return np.array([[1.0, 0.0], [sine * cosine / mount.baseline, -(sine**2) / mount.baseline]])
