"""What the calibration of a side-facing head says to people."""

import numpy as np

from calibore.calibration._rig._findings import contradictions, moved_sentences, stop_warnings, together
from calibore.calibration._rig._fit import RigFit
from calibore.calibration._rig._range_file import RangeTarget
from calibore.calibration._rig._range_pictures import LinePictures
from calibore.calibration._rig._references import FlatTarget
from calibore.calibration._rig._stops import Suspect
from calibore.rigs import triangulate

TOGETHER = 0.99


def range_findings(target: RangeTarget, pictures: LinePictures, found: RigFit) -> list[str]:
    unit, looks = target.unit, found.model.looks
    ranges = np.array([look.reference.distance for look in looks if isinstance(look.reference, FlatTarget)])
    middle = np.array([ranges.min(), np.sqrt(ranges.min() * ranges.max()), ranges.max()])
    known, apart = range_uncertainty(found, middle)
    said = [unit.said(place, 0.1 * unit.size) for place in middle]
    of_range = ", ".join(f"{unit.said(u, u)} at {place}" for u, place in zip(known, said, strict=True))
    scatter = (
        unit.said(found.stop_scatter, found.stop_scatter) if found.stop_scatter > 0 else "no more than their lines"
    )
    sentences = [
        f"{len(looks)} of {len(target.paths)} stops, {unit.said(ranges.min(), 0.1 * unit.size)} to "
        f"{unit.said(ranges.max(), 0.1 * unit.size)}, tell the range with u = {of_range}.",
        *moved_sentences(found, unit),
    ]
    correlations = np.abs(found.covariance.correlations)
    if (correlations - np.eye(len(correlations))).max() > TOGETHER:
        sentences.append(
            "These parameters are known together much better than one by one: without their covariance, u of the range "
            f"at {said[1]} would seem {unit.said(apart[1], apart[1])} instead of {unit.said(known[1], known[1])}."
        )
    if not found.model.stated:
        sentences.append(f"Whole stops scatter about the fit by {scatter}.")
    if "laser.lean" not in found.free:
        sentences.append("The lean of the sheet cannot be told from these pictures; it is taken as stated.")
    if "camera.principal_point_u" not in found.free:
        u, v = found.rig.camera.principal_point
        sentences.append(
            f"The aim is the angle of the ray through column {u:g}, row {v:g}, which was not looked for: a shift of "
            "the principal point along the rows is a change of the aim, and no range changes by it."
        )
    sentences += [f"Take {take} has room light (at {times} stops); it was not used." for take, times in _lit(pictures)]
    return sentences


def range_warnings(target: RangeTarget, pictures: LinePictures, found: RigFit, wrong: list[Suspect]) -> list[str]:
    warnings = stop_warnings(wrong, target.unit, what="The stop at")
    if target.said.u_range is not None and not found.model.stated:
        scatter, u_range = (target.unit.said(u, u) for u in (found.stop_scatter, target.said.u_range))
        warnings.append(
            f"Stops scatter by {scatter} about the head found, more than the stated u_range of {u_range}; what they "
            "scatter by was used. Check the caliper, and that the lens law is the camera's."
        )
    stated = target.said.room_light_takes
    seen = {take for take, _ in _lit(pictures)}
    dark = [take for take in stated or () if take not in seen]
    if dark:
        warnings.append(
            f"target.toml says that take {', '.join(map(str, dark))} has room light; its pictures are as dark as the "
            "others, and they were used."
        )
    unsaid = sorted(seen - set(stated)) if stated is not None else []
    if unsaid:
        warnings.append(f"Take {', '.join(map(str, unsaid))} has room light, which target.toml does not say.")
    warnings += [f"{one.name} was not used: {one.refused}." for one in pictures.files if one.refused]
    return [*warnings, *contradictions(found)]


def range_uncertainty(found: RigFit, ranges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Standard uncertainty (n,) [m] of `ranges` (n,) [m] in the middle of the picture, from the calibration alone, with
    the covariance of its parameters and as if they were independent.
    """
    places = np.zeros((len(ranges), 3))
    places[:, 1] = ranges
    points = triangulate(found.rig, *found.rig.project(places))
    return together(found, points, np.tile([0.0, 1.0, 0.0], (len(ranges), 1)))


def _lit(pictures: LinePictures) -> list[tuple[int, int]]:
    return sorted(pictures.light.items())
