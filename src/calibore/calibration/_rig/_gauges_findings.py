"""What the calibration by gauges and flats says to people."""

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._in_words import word_of
from calibore.calibration._rig._findings import contradictions, moved_sentences, stop_warnings, together
from calibore.calibration._rig._fit import RigFit
from calibore.calibration._rig._gauges_file import GaugesTarget
from calibore.calibration._rig._gauges_pictures import RingPictures
from calibore.calibration._rig._references import RingGauge
from calibore.calibration._rig._stops import Suspect
from calibore.rigs import triangulate

Array = NDArray[np.float64]
TOGETHER = 0.99


def gauges_findings(target: GaugesTarget, found: RigFit, held: tuple[str, ...], stated: tuple[str, ...]) -> list[str]:
    unit, sentences = target.unit, []
    known, apart = radius_uncertainty(found)
    worst = int(np.argmax(known))
    names = [look.name for look in found.model.looks]
    sentences.append(
        f"{len(names)} looks tell the radius with u = {unit.said(float(known.min()), float(known.min()))} to "
        f"{unit.said(known[worst], known[worst])} (the latter in {names[worst]}), from this calibration alone."
    )
    sentences += moved_sentences(found, unit)
    correlations = np.abs(found.covariance.correlations)
    if correlations.size > 1 and (correlations - np.eye(len(correlations))).max() > TOGETHER:
        sentences.append(
            "These parameters are known together much better than one by one: without their covariance, u of the "
            f"radius in {names[worst]} would seem {unit.said(apart[worst], apart[worst])} instead of "
            f"{unit.said(known[worst], known[worst])}."
        )
    if held:
        sentences.append(
            f"These looks do not tell {_listed(held)}: held at what the rig file says, as if exact. More gauges of "
            "other diameters, off the middle of the picture, or flats at other stand-offs would tell more; or state "
            "the uncertainty in the rig file."
        )
    if stated:
        sentences.append(f"These looks do not tell {_listed(stated)}: what the rig file states was used.")
    return sentences


def gauges_warnings(target: GaugesTarget, pictures: RingPictures, found: RigFit, wrong: list[Suspect]) -> list[str]:
    warnings = stop_warnings(wrong, target.unit, what="The")
    sizes = {look.reference.diameter for look in found.model.looks if isinstance(look.reference, RingGauge)}
    flats = sum(not isinstance(look.reference, RingGauge) for look in found.model.looks)
    if "camera.k" not in found.free:
        warnings.append(
            "k of the lens is taken as exact: the pictures tell the ratio of the laser's lengths to k, not both, and "
            "an error of 1 % in k goes unseen into them. Give lens_file, a calibration of the lens with its covariance."
        )
    if len(sizes) + flats == 1:
        warnings.append(
            "There is one reference only: the radius is right at its size; what it does elsewhere rests on the rig "
            "file and the lens. Photograph gauges over the whole range of radii."
        )
    if not found.model.stated:
        scatter = target.unit.said(found.stop_scatter, found.stop_scatter)
        warnings.append(
            f"The references scatter by {scatter} about the rig found, more than was stated of them; what they scatter "
            "by was used. Check their sizes, and that the lens law is the camera's."
        )
    warnings += [f"{one.name} was not used: {one.refused}." for one in pictures.files if one.refused]
    return [*warnings, *contradictions(found)]


def radius_uncertainty(found: RigFit) -> tuple[Array, Array]:
    """Root mean square over the marks of each look of the standard uncertainty [m] of their radius, from the
    calibration alone: with the covariance of its parameters, and as if they were independent.
    """
    known, apart = [], []
    for look, branch in zip(found.model.looks, found.model.branches, strict=True):
        points = triangulate(found.rig, look.u, look.v, laser=look.laser, branch=branch)
        outwards = np.zeros((look.u.size, 3))
        outwards[:, :2] = points.points[:, :2] / points.radius[:, None]
        both = together(found, points, outwards)
        known.append(np.sqrt(np.nanmean(both[0] ** 2)))
        apart.append(np.sqrt(np.nanmean(both[1] ** 2)))
    return np.array(known), np.array(apart)


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(map(word_of, names))
