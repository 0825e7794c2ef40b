"""The whole way from pixel to radius and axial position, and its slopes, against 40-digit arithmetic for every rig."""

from dataclasses import fields

import mpmath as mp
import numpy as np
import pytest
from random_rigs import NOMINAL, wall_points

from calibore.lasers import Beam, Cone, Plane
from calibore.optics import LENS_LAWS
from calibore.rigs import SideFacing, triangulate
from calibore.simulation import RIG_KINDS, draw_rig, random_rig
from calibore.status import Status

DIGITS = 40
POINTS = 2
LENSES = {
    "perspective": mp.atan,
    "stereographic": lambda ratio: 2 * mp.atan(ratio),
    "equidistant": lambda ratio: ratio,
    "sine-law": mp.asin,
    "equisolid-angle": lambda ratio: 2 * mp.asin(ratio),
}


def vector(*values):
    return mp.matrix(values)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def exact_ray(law, lens, camera, u, v):
    """Direction in the camera frame of the pixel; the residual c1, c2 is 0."""
    x, y = u - camera["principal_point_u"], (v - camera["principal_point_v"]) / camera["aspect"]
    radius = mp.sqrt(x * x + y * y)
    zenith = LENSES[law](radius / lens["k"])
    return vector(mp.sin(zenith) * x / radius, mp.sin(zenith) * y / radius, mp.cos(zenith))


def exact_mount(laser, ray, side_facing):
    """Origin and direction in the rig frame (formats.md, section 1)."""
    if not side_facing:
        return vector(0, 0, 0), ray
    sine, cosine = mp.sin(laser["aim"]), mp.cos(laser["aim"])
    turned = vector(cosine * ray[0] - sine * ray[2], sine * ray[0] + cosine * ray[2], -ray[1])
    return vector(laser["baseline"], 0, 0), turned


def flat(surface, laser):
    """Normal and level of a plane, sheet or beam."""
    if isinstance(surface, Plane):
        return vector(-laser["tilt_x"], -laser["tilt_y"], 1), laser["baseline"]
    if isinstance(surface, Beam):
        across = mp.sin(laser["zenith"])
        along = vector(across * mp.sin(laser["clock"]), -across * mp.cos(laser["clock"]), mp.cos(laser["zenith"]))
        start = vector(laser["x"], laser["y"], laser["z"])
        foot = start - dot(start, along) * along
        return foot, dot(foot, foot)
    return vector(1, -laser["skew"], -laser["lean"]), laser["offset"]


def exact_distance(surface, laser, origin, ray, near):
    """Along the ray to the surface, from the roots of its defining equation."""
    if not isinstance(surface, Cone):
        normal, level = flat(surface, laser)
        return (level - dot(normal, origin)) / dot(normal, ray)
    outwards = vector(mp.sin(laser["clock"]), -mp.cos(laser["clock"]), 0)
    ahead = vector(0, 0, 1)
    arm = origin - laser["baseline"] * outwards - laser["offset"] * ahead
    axis = mp.cos(laser["aim"]) * ahead - mp.sin(laser["aim"]) * outwards
    square = mp.cos(laser["half_angle"]) ** 2
    a = dot(axis, ray) ** 2 - square
    b = dot(axis, ray) * dot(axis, arm) - square * dot(ray, arm)
    c = dot(axis, arm) ** 2 - square * dot(arm, arm)
    root = mp.sqrt(b * b - a * c)
    return min(((-b + root) / a, (-b - root) / a), key=lambda t: abs(t - near))


def exact_point(rig, laser, near):
    """The function (parameters and pixel by name) -> (R, H) of this rig in exact arithmetic."""
    surface, table = rig.lasers[laser].surface, rig.laser_table(laser)

    def point(values):
        of = {part: within(values, part) for part in (table, "camera")}
        ray = exact_ray(rig.camera.lens.law, of["camera"], of["camera"], values["u"], values["v"])
        origin, ray = exact_mount(of[table], ray, isinstance(rig.mount, SideFacing))
        x, y, z = origin + exact_distance(surface, of[table], origin, ray, near) * ray
        return mp.sqrt(x * x + y * y), z

    return point


def within(values, part):
    """Those of the dotted paths that lie in `part`, by their last word."""
    return {name.removeprefix(f"{part}."): x for name, x in values.items() if name.startswith(f"{part}.")}


def value_of(rig, name, laser):
    key = name.rsplit(".", 1)[1]
    if key.startswith("principal_point"):
        return rig.camera.principal_point["uv".index(key[-1])]
    parts = (rig.camera, rig.camera.lens) if name.startswith("camera") else (rig.lasers[laser].surface, rig.mount)
    return next(getattr(p, key) for p in parts if key in {f.name for f in fields(p)})


@pytest.mark.parametrize("kind", RIG_KINDS)
@pytest.mark.parametrize("law", LENS_LAWS)
def test_radius_axial_position_and_every_slope_agree_with_forty_digits(kind, law):
    with mp.workdps(DIGITS):
        rng = np.random.default_rng([31, RIG_KINDS.index(kind), list(LENS_LAWS).index(law)])
        rig = draw_rig(random_rig(rng, NOMINAL, kind=kind, law=law), rng)
        laser = len(rig.lasers) - 1
        u, v = rig.project(wall_points(rig, rng, 20, laser=laser))
        found = triangulate(rig, u, v, laser=laser, prior_radius=NOMINAL)
        slopes = np.concatenate([*found.radius_sensitivities, *found.axial_sensitivities], axis=1)
        steep = np.abs(slopes[:, :2]).max(axis=1) > 0.05 * NOMINAL  # next to grazing digits are lost to the question
        places = np.flatnonzero((found.status == Status.OK) & ~steep)[:POINTS]
        assert places.size == POINTS
        for n in places:
            compare(rig, laser, found, n, {"u": u[n], "v": v[n]})


def compare(rig, laser, found, n, pixel):
    point = exact_point(rig, laser, mp.mpf(float(np.linalg.norm(found.points[n] - rig.mount.translation))))
    mine = [name for name in rig.parameter_names if name.startswith("camera.") or is_of(rig, name, laser)]
    values = {name: value_of(rig, name, laser) for name in mine if name[7:] not in ("c1", "c2")} | pixel
    values = {name: mp.mpf(float(value)) for name, value in values.items()}

    def coordinate(axis, name):
        """R or H as a function of one of the values."""
        return lambda x: point({**values, name: x})[axis]

    for axis, ours, by in (
        (0, found.radius[n], found.radius_sensitivities),
        (1, found.axial[n], found.axial_sensitivities),
    ):
        assert ours == pytest.approx(float(point(values)[axis]), rel=1e-12, abs=1e-13 * NOMINAL)
        slopes = dict(zip(found.parameter_names, by.parameters[n], strict=True))
        slopes |= dict(zip(("u", "v"), by.pixel[n], strict=True))
        for name, value in values.items():
            exact = float(mp.diff(coordinate(axis, name), value))
            assert abs(slopes[name] - exact) <= 1e-10 * max(abs(exact), 1e-3 * NOMINAL * scale_of(name)), name


def is_of(rig, name, laser):
    return len(rig.lasers) == 1 or name.startswith(f"{rig.laser_table(laser)}.")


def scale_of(name):
    """What a slope that happens to be 0 is small against: nominal radii per pixel, or per nominal radius or radian."""
    return 1e-3 if name in ("u", "v") or "principal" in name or name.endswith(".k") else 1 / NOMINAL
