"""What the geometry alone says of a wall, so that many cameras are judged by one look at it.

The noise of a camera enters a radius through the zenith of its ray only: u^2 = common^2 + (dR/dzenith du/(k f'))^2.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from calibore.design._appraisal import COVERAGE_FACTOR, RANGE
from calibore.design._candidates import EDGE, ON_AXIS, reference_rig
from calibore.design._occlusion import occlusion
from calibore.design._requirement import CameraChoice, Requirement
from calibore.design._scales import image_of, scales_of
from calibore.optics import Camera, Lens
from calibore.rigs import Rig, lit_points, margin, triangulate
from calibore.status import Status
from calibore.uncertainty import FIRST_ORDER_FROM, MEASURABLE_ABOVE, propagate

Array = NDArray[np.float64]
CLOCKS = 36
SMALLER, LEAST = 10, 0.35
"""Clock positions; radii below the pipe's range, down to this share of its least radius."""
LOOSER = np.array([1.0, 1.25, 1.6])
"""Scales beyond those with which every laser sees everything: the other laser may see it."""
BETWEEN = 0.995
"""Of a scale: between the clocks of a map, rays may reach that much further out."""
RADIAN = Camera(1, 1, Lens("equidistant", 1.0, 0.5), (0.0, 0.0))
"""A camera whose pixel is a radian."""


@dataclass(frozen=True, eq=False)
class WallMap:
    """At clocks x radii (c, r) of a laser at the crown: `zenith` of the ray, `slope` [m/rad] of the radius by it,
    `common` u [m], the margin `by_common` and `by_radian` of noise; `occlusion` (c,) at the nominal radius.
    """

    zenith: Array
    slope: Array
    common: Array
    by_common: Array
    by_radian: Array
    occlusion: Array

    def turned(self, clock: float) -> "WallMap":
        """Of a laser at `clock` [rad], a whole number of steps round."""
        steps = round(clock / (2 * np.pi / len(self.zenith)))
        return WallMap(*(np.roll(getattr(self, name), steps, axis=0) for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Outlook:
    """Of n scales `k` of a camera: `u95`, `smallest` radius [m], `occlusion` [rad], `coverage`, each (n,)."""

    k: Array
    u95: Array
    smallest: Array
    occlusion: Array
    coverage: Array


def radii_of(wanted: Requirement) -> Array:
    """(r,) [m] ascending, the last `RANGE` in the pipe's range."""
    least, most = wanted.radii
    return np.concatenate(
        [np.geomspace(LEAST * least, least, SMALLER, endpoint=False), np.linspace(least, most, RANGE)]
    )


def wall_map(
    configuration: str, baseline: float, projection: float, wanted: Requirement, *, clocks: int = CLOCKS
) -> WallMap:
    """Computed on one half of the wall, or at one clock where all are alike; InputError for impossible geometry."""
    rig = replace(reference_rig(configuration, baseline, projection, wanted), camera=RADIAN)
    alike = configuration in ("perpendicular-plane", *ON_AXIS)
    clock = np.linspace(0.0, np.pi, clocks // 2 + 1)[: 1 if alike else None]
    zenith, slope, common, by_common, by_radian = _look(rig, clock, radii_of(wanted))
    whole = np.zeros(clocks, dtype=int) if alike else np.minimum(np.arange(clocks), clocks - np.arange(clocks))
    angle = occlusion(rig, nominal_radius=wanted.nominal_radius)[0]
    each = len(angle.clock) // clocks
    shadow = np.minimum(angle.camera, angle.light)[::each]
    return WallMap(zenith[whole], slope[whole], common[whole], by_common[whole], by_radian[whole], shadow)


def _look(rig: Rig, clock: Array, radii: Array) -> tuple[Array, ...]:
    at, radius = (a.ravel() for a in np.meshgrid(clock, radii, indexing="ij"))
    u, v = rig.project(lit_points(rig, at, radius))
    found = triangulate(rig, u, v, prior_radius=radius)
    zenith = np.hypot(u, v)
    along = np.stack([u, v], axis=1) / np.where(zenith > 0, zenith, 1.0)[:, None]
    slopes = found.radius_sensitivities
    assert rig.covariance is not None
    common = propagate(slopes.parameters, rig.covariance, names=found.parameter_names).u
    sight = {"branch": found.branch, "direction": along}
    margins = margin(rig, u, v, u_pixel=0.0, **sight), margin(rig.knowing(None), u, v, u_pixel=1.0, **sight)
    ok = found.status == Status.OK
    arrays = zenith, np.abs(np.einsum("nk,nk->n", slopes.pixel, along)), common, *margins
    return tuple(np.where(ok, a, np.nan).reshape(clock.size, radii.size) for a in arrays)


def outlook(maps: list[WallMap], camera: CameraChoice, lens: str, wanted: Requirement) -> Outlook | None:
    """Of the lasers of one rig together, with the scales at which just another radius comes into the image."""
    sights = [(one, *image_of(lens, one.zenith)) for one in maps]
    edges = [_widest_scale(radius, camera) for _, radius, _ in sights]
    k = scales_of(camera, lens).among(_wished(edges, [one for one, *_ in sights]))
    if not k.size:
        return None
    weights, sure, steady = [], [], []
    for (one, _, slope), edge in zip(sights, edges, strict=True):
        noise = wanted.noise.stripe / (k[:, None, None] * slope)
        safety = 1 / np.hypot(1 / one.by_common, noise / one.by_radian)
        usable = (k[:, None, None] <= edge) & (safety > MEASURABLE_ABOVE)
        weights.append(np.where(usable, 1 / (one.common**2 + (one.slope * noise) ** 2), 0.0))
        sure.append(safety >= FIRST_ORDER_FROM)
        steady.append(one.occlusion)
    return _summed(k, np.stack(weights), np.stack(sure), np.stack(steady), wanted)


def _summed(k: Array, weights: Array, sure: NDArray[np.bool_], angles: Array, wanted: Requirement) -> Outlook:
    """From `weights` 1/u^2 (laser, k, c, r): lasers built apart share nothing, so that weights add."""
    total = weights.sum(axis=0)
    heaviest = np.argmax(weights, axis=0)[None]
    good = (total > 0) & np.take_along_axis(sure, heaviest, axis=0)[0]
    covered = good[..., -RANGE:].all(axis=2)
    worst = np.where(covered[..., None] & (total[..., -RANGE:] > 0), total[..., -RANGE:], np.inf).min(axis=(1, 2))
    smaller = (good[..., :-RANGE] | ~covered[..., None]).all(axis=1)
    unbroken = np.flip(np.cumprod(np.flip(smaller, axis=1), axis=1), axis=1).sum(axis=1)
    radii = radii_of(wanted)
    smallest = np.where(unbroken == SMALLER, 0.0, radii[SMALLER - unbroken])
    sees = ((weights > 0) & sure)[..., -1 - RANGE // 2]
    angle = np.where(sees, angles[:, None, :], -np.inf).max(axis=0)
    least = np.where(covered, angle, np.inf).min(axis=1)
    with np.errstate(divide="ignore"):
        u95 = COVERAGE_FACTOR / np.sqrt(worst)
    return Outlook(k, u95, smallest, least, covered.mean(axis=1))


def _widest_scale(radius: Array, camera: CameraChoice) -> Array:
    """(c, r) [px] the largest k at which a point is in the image; `radius`: its image radius for k = 1."""
    clock = np.arange(len(radius))[:, None] * (2 * np.pi / len(radius))
    across, along = radius * np.abs(np.sin(clock)), radius * np.abs(np.cos(clock))
    sides = (camera.width / 2 - EDGE, camera.height / 2 - EDGE)
    with np.errstate(divide="ignore"):
        return np.fmin(*(side / np.maximum(part, 1e-12) for side, part in zip(sides, (across, along), strict=True)))


def _wished(edges: list[Array], maps: list[WallMap]) -> Array:
    """Scales at which all from one radius on is in the image, at every clock far enough from the frontier."""
    least = [np.where(one.by_common >= FIRST_ORDER_FROM, edge, np.inf) for edge, one in zip(edges, maps, strict=True)]
    by_radius = np.nanmin(np.min(least, axis=0), axis=0)
    onwards = np.minimum.accumulate(by_radius[::-1])[::-1][: SMALLER + 1]
    alike = all(np.ptp(one.zenith, axis=0).max() == 0 for one in maps)
    looser = LOOSER if len(maps) > 1 else LOOSER[:1]
    return np.unique(np.outer(onwards, looser)) * (1.0 if alike else BETWEEN)
