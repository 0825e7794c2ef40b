"""The same for a side-facing head, whose camera is aimed so that its view ends at the pipe's largest radius."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.design._appraisal import COVERAGE_FACTOR, RANGE
from calibore.design._candidates import EDGE, aim_by_lengths, head_view, inputs_of
from calibore.design._requirement import CameraChoice, Requirement
from calibore.design._scales import image_of, scales_of
from calibore.design._wall_map import RADIAN, SMALLER, Outlook, radii_of
from calibore.lasers import Sheet
from calibore.optics import Lens
from calibore.rigs import Laser, Rig, SideFacing, lit_points, triangulate

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class HeadMap:
    """Of a head with this `baseline` [m]: at each radius (r,) the `angle` [rad] from the baseline to the ray, and the
    derivatives of the radius by that angle (`slope`), by the baseline and by the aim.
    """

    baseline: float
    angle: Array
    slope: Array
    by_baseline: Array
    by_aim: Array


def head_map(baseline: float, wanted: Requirement) -> HeadMap:
    rig = Rig("side-facing", RADIAN, (Laser(Sheet()),), mount=SideFacing(baseline, 0.0))
    u, v = rig.project(lit_points(rig, 0.0, radii_of(wanted)))
    found = triangulate(rig, u, v)
    pixel, parameters = found.radius_sensitivities
    moved = {name: parameters[:, found.parameter_names.index(f"laser.{name}")] for name in ("baseline", "aim")}
    return HeadMap(baseline, u + np.pi / 2, np.abs(pixel[:, 0]), moved["baseline"], moved["aim"])


def head_outlook(one: HeadMap, camera: CameraChoice, lens: str, wanted: Requirement) -> tuple[Outlook, Array] | None:
    """What it achieves, and the aim [rad] of the camera, at the scales with which its view begins at each radius."""
    half_image = camera.width / 2 - EDGE
    wished = half_image / Lens(lens, 1.0, 1.0).image_radius((one.angle[-1] - one.angle[: SMALLER + 1]) / 2)
    k = scales_of(camera, lens).among(wished)
    half_angle = Lens(lens, 1.0, 1.0).zenith(half_image / k)
    aim = np.asarray(head_view(one.baseline, wanted.radii[1], half_angle))
    possible = (aim >= 0) & (aim < np.pi / 2)
    k, aim, half_angle = k[possible], aim[possible], half_angle[possible]
    if not k.size:
        return None
    off_axis = np.abs(one.angle - (one.angle[-1] - half_angle)[:, None])
    image_radius, slope = image_of(lens, off_axis)
    noise = one.slope * wanted.noise.stripe / (k[:, None] * slope)
    by_baseline, by_range = aim_by_lengths(one.baseline, aim)[..., None]
    common = np.hypot(one.by_baseline + one.by_aim * by_baseline, one.by_aim * by_range)
    u = np.hypot(noise, common * inputs_of(wanted).length * wanted.nominal_radius)
    seen = k[:, None] * image_radius <= half_image * (1 + 1e-9)
    covered = seen[:, -RANGE:].all(axis=1)
    unbroken = np.cumprod(np.flip(seen[:, :SMALLER], axis=1), axis=1).sum(axis=1)
    smallest = np.where(unbroken == SMALLER, 0.0, radii_of(wanted)[SMALLER - unbroken])
    occlusion = np.full(k.shape, one.angle[SMALLER + RANGE // 2])
    return Outlook(k, COVERAGE_FACTOR * u[:, -RANGE:].max(axis=1), smallest, occlusion, covered.astype(float)), aim
