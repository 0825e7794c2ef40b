"""What a calibration of a rig says to people, and the result it becomes."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Observations
from calibore.calibration._evidence import of_fit
from calibore.calibration._in_words import Unit, unit_of, word_of
from calibore.calibration._rig._fit import RigFit
from calibore.calibration._rig._stops import Suspect
from calibore.rigs import Triangulation, value_of
from calibore.uncertainty import Covariance, propagate

Array = NDArray[np.float64]
FAR_MOVED = 3.0
"""A parameter this many standard uncertainties off what was known of it contradicts it."""


def moved_sentences(found: RigFit, unit: Unit) -> list[str]:
    """One sentence per parameter: what was found, what it was to be (the table Swanbom 2007, 7.1)."""
    sentences = []
    for name, u in zip(found.free, found.covariance.u.tolist(), strict=True):
        one, before, after = unit_of(name, unit), value_of(found.model.rig, name), value_of(found.rig, name)
        change = after - before
        word = word_of(name)
        word = word if len(word) == 1 else f"{word[0].upper()}{word[1:]}"
        sentences.append(
            f"{word}: found {one.said(after, u)} (u = {one.said(u, u)}), stated {one.said(before, u)}: "
            f"moved by {one.said(change, u, sign=True)}, {abs(change) / u:.1f} u."
        )
    return sentences


def contradictions(found: RigFit) -> list[str]:
    """Warnings where what was known before (`found.prior`) and the pictures disagree."""
    known = found.prior
    result = []
    for name in found.free if known is not None else ():
        if known is None or name not in known.names:
            continue
        u_before, u_after = float(known.restricted([name]).u[0]), float(found.covariance.restricted([name]).u[0])
        change = value_of(found.rig, name) - value_of(found.model.rig, name)
        spread = np.sqrt(max(u_before**2 - u_after**2, 0.0))
        if abs(change) > FAR_MOVED * max(spread, 0.1 * u_before):
            result.append(
                f"The pictures move {word_of(name)} by {change:+.3g}, {abs(change) / u_before:.1f} times its stated "
                f"uncertainty ({u_before:.2g}): what is known of it does not hold here (has zoom, focus or mounting "
                "changed since?)."
            )
    return result


def stop_warnings(wrong: Iterable[Suspect], unit: Unit, *, what: str) -> list[str]:
    """What was left out, and by how much it is off."""
    return [
        f"{what} {one.stop} was left out: by the other pictures it is off by {unit.said(one.off, 0.01 * unit.size)} "
        f"({abs(one.t):.1f} times what they scatter by); check its reading, or that its picture belongs to it."
        for one in wrong
    ]


def together(found: RigFit, points: Triangulation, by: Array) -> tuple[Array, Array]:
    """Standard uncertainty (n,) [m] of `points` along the unit vectors `by` (n, 3), with the covariance of the
    parameters and as if they were independent.
    """
    sensitivities = np.einsum("ni,nip->np", by, points.d_parameters)
    known = found.covariance
    apart = Covariance.independent(dict(zip(known.names, known.u.tolist(), strict=True)))
    return (
        propagate(sensitivities, known, names=points.parameter_names).u,
        propagate(sensitivities, apart, names=points.parameter_names).u,
    )


def observations_of(found: RigFit) -> Observations:
    """The evidence, in pixels along the marks' directions."""
    looks = found.model.looks
    return Observations(
        file=np.array([look.file for look in looks], dtype=np.intp)[found.model.look_of],
        u=np.concatenate([look.u for look in looks]),
        v=np.concatenate([look.v for look in looks]),
        **of_fit(found.fit),
    )


def scatter_of(found: RigFit) -> tuple[float, float]:
    """Typical standard deviations [px] of a mark, and of what the marks of one stop share."""
    return float(np.median(found.fit.sigma)), found.stop_scatter / float(np.median(np.abs(found.slope)))


def zeniths_of(found: RigFit) -> tuple[float, float]:
    """From the axis, about which every lens is symmetric and to which it interpolates, to the greatest zenith [rad] of
    the camera rays of all marks.
    """
    looks = found.model.looks
    u, v = (np.concatenate([getattr(look, name) for look in looks]) for name in "uv")
    direction = found.rig.camera.unproject(u, v).direction
    return 0.0, float(np.arccos(np.clip(direction[:, 2].min(), -1, 1)))
