"""M3C2 (Lague et al. 2013) and M3C2-EP (Winiwarter et al. 2021) of py4dgeo on two registered profiles.

`pip install -e .[peers]` brings py4dgeo. The peer gets every help that its own interface can take: clouds that our
registration has brought together, freed of calibration errors as ours estimates them where `freed`; what then is left
common as `registration_error` (M3C2), or the covariance of the motion (M3C2-EP). M3C2 sees the pipe unrolled, so that
the wall's curvature is no roughness; M3C2-EP sees it round, scanned from the axis at every station with the noise that
the profiles state. Both take normals from the earlier cloud.
"""

import logging
from dataclasses import dataclass
from multiprocessing.shared_memory import SharedMemory

import numpy as np
import py4dgeo
from py4dgeo.m3c2ep import process_corepoint_list, radius_search

from calibore.comparison import Difference
from calibore.geometry import xy_of
from calibore.scans import Profile

logging.getLogger("py4dgeo").setLevel(logging.ERROR)

REACH = 0.02
"""m; half the length of the cylinders."""
NORMALS = 0.012
"""m, radius within which a normal is taken."""
EVERY = (2, 6)
"""Rings and clock positions from one core point of M3C2-EP to the next: its time is that of Python loops."""
MOST = 40
"""Core points of M3C2-EP on wear."""
U_ANGLE = 6e-4
"""rad, of a point's direction as seen by the scanner, both ways; along the wall it counts for nothing."""
FEWEST = 5
"""Points in a cylinder, as in M3C2-EP."""


@dataclass(frozen=True, eq=False)
class Found:
    """At core points (p): `axial` [m], `clock` [rad]; `distance` [m], later minus earlier radius, and its `level` of
    detection [m] by the peer; NaN where too few points are near.
    """

    axial: np.ndarray
    clock: np.ndarray
    distance: np.ndarray
    level: np.ndarray


@dataclass(frozen=True, eq=False)
class Clouds:
    """Two registered clouds, before and after: `axial` [m], `clock` [rad], `radius` [m], its noise `u` [m], each (p,);
    `core`: which points of the later one are on the grid that M3C2-EP takes; `common` [m] root mean square of what is
    uncertain alike everywhere.
    """

    before: np.ndarray
    after: np.ndarray
    core: np.ndarray
    common: float
    difference: Difference

    @classmethod
    def of(cls, difference: Difference, reference: Profile, *, freed: bool) -> "Clouds":
        registration, gone = difference.registration, reference.measured
        cloud, left = registration.cloud, registration.gaps
        own = len(cloud.modes)
        radius, earlier = left.radius, reference.radius
        if freed:
            radius = radius + registration.motion.scale * registration.modes[:own] @ cloud.modes
            earlier = earlier + np.tensordot(registration.modes[own:], reference.common_mode, axes=1)
        ring, position = np.nonzero(gone)
        columns = (reference.axial_position, np.broadcast_to(reference.clock, gone.shape), earlier)
        before = np.stack([one[ring, position] for one in (*columns, reference.u_independent)])
        modes = difference.adjusted_modes if freed else difference.modes
        return cls(
            before,
            np.stack([left.axial, left.clock, radius, np.sqrt(cloud.variance)]),
            (cloud.ring % EVERY[0] == 0) & (cloud.position % EVERY[1] == 0),
            float(np.sqrt(np.nanmean(np.sum(modes**2, axis=0)))),
            difference,
        )


def plain(clouds: Clouds, *, cylinder: float, within: np.ndarray | None = None) -> Found:
    """M3C2 with cylinders of this radius [m] at every point of the later survey, or those `within` (p,)."""
    nominal = float(np.median(clouds.before[2]))
    earlier, later = (_unrolled(cloud, nominal, 2 * cylinder) for cloud in (clouds.before, clouds.after))
    chosen = clouds.after if within is None else clouds.after[:, within]
    core = _unrolled(chosen, nominal, 0.0)
    epochs = tuple(py4dgeo.Epoch(cloud) for cloud in (earlier, later))
    peer = py4dgeo.M3C2(
        epochs=epochs,
        corepoints=core,
        normal_radii=[NORMALS],
        cyl_radius=cylinder,
        max_distance=REACH,
        registration_error=clouds.common,
    )
    distance, u = peer.run()
    enough = np.minimum(u["num_samples1"], u["num_samples2"]) >= FEWEST
    return Found(*chosen[:2], np.where(enough, distance, np.nan), u["lodetection"])


def _unrolled(cloud: np.ndarray, nominal: float, margin: float) -> np.ndarray:
    """(p, 3): round the pipe, along it, and radius; `margin` [m] twice at the crown."""
    axial, clock, radius = cloud[0], np.mod(cloud[1], 2 * np.pi), cloud[2]
    flat = np.stack([nominal * clock, axial, radius], axis=1)
    turn = np.array([2 * np.pi * nominal, 0.0, 0.0])
    parts = [flat, flat[flat[:, 0] > turn[0] - margin] - turn, flat[flat[:, 0] < margin] + turn]
    return np.ascontiguousarray(np.concatenate(parts if margin > 0 else parts[:1]))


def propagated(clouds: Clouds, *, cylinder: float, within: np.ndarray | None = None) -> Found:
    """M3C2-EP at the core points, or at `MOST` of those `within` (p,).

    `M3C2EP.run` hands blocks of core points to processes and sleeps a second after each; here its own function for a
    block is called, so that a study of many pairs can be made. The numbers are the same.
    """
    places = np.flatnonzero(clouds.core if within is None else within)
    chosen = places if within is None else places[:: max(1, places.size // MOST)]
    earlier, later = (scanned(cloud) for cloud in (clouds.before, clouds.after))
    core = _round(clouds.after[:, chosen])
    trees = [py4dgeo.Epoch(cloud) for cloud, _, _ in (earlier, later)]
    normals = _normals(trees, core)
    for tree in trees:
        tree.build_kdtree()
    near = [radius_search(tree, core, float(np.hypot(REACH, cylinder))) for tree in trees]
    motion, pivot = alignment(clouds.difference)
    meta = {"searchrad": cylinder, "maxdist": REACH, "minneigh": FEWEST, "maxneigh": 100000}
    meta |= {"spInfos": [earlier[2], later[2]], "tfM": np.eye(3, 4), "Cxx": motion, "redPoint": pivot}
    result: dict = {}
    with _Shared(earlier[0]) as one, _Shared(later[0]) as other:
        given = (near[0], one.name, one.shape, earlier[1], near[1], other.name, other.shape, later[1])
        process_corepoint_list(core, normals, *given, meta, 0, result, _Silent())
    distance, level = -result[0]["val"], result[0]["lod_new"]
    return Found(*clouds.after[:2, chosen], distance, level)


def scanned(cloud: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[dict]]:
    """A cloud (p, 3) as M3C2-EP takes it, the scanner's place (p,) of each point, and the places, one per station."""
    numbers = np.round((cloud[0] - cloud[0].min()) / np.median(np.diff(np.unique(np.round(cloud[0], 4))))).astype(int)
    kept, place = np.unique(numbers, return_inverse=True)
    infos = []
    for number in range(kept.size):
        ours = place == number
        noise = float(np.sqrt(np.mean(cloud[3, ours] ** 2)))
        origin = [0.0, 0.0, float(np.mean(cloud[0, ours]))]
        infos.append({"origin": origin, "sigma_range": noise, "sigma_scan": U_ANGLE, "sigma_yaw": U_ANGLE})
    return np.ascontiguousarray(_round(cloud)), place + 1, infos


def alignment(difference: Difference) -> tuple[np.ndarray, np.ndarray]:
    """Covariance (12, 12) of the affine motion row by row, then its shift, and the point (3,) about which it turns."""
    registration = difference.registration
    slopes = np.zeros((12, len(registration.names)))
    places = {"roll": {1: -1, 3: 1}, "tilt_x": {2: 1, 6: -1}, "tilt_y": {5: 1, 7: -1}}
    places |= {"shift_x": {9: 1}, "shift_y": {10: 1}, "axial": {11: 1}}
    for column, name in enumerate(registration.names):
        for row, sign in places[name].items():
            slopes[row, column] = sign
    return slopes @ registration.covariance.matrix @ slopes.T, np.array([0.0, 0.0, registration.motion.pivot])


def _round(cloud: np.ndarray) -> np.ndarray:
    return np.stack([*xy_of(cloud[1], cloud[2]), cloud[0]], axis=1)


def _normals(epochs: list[py4dgeo.Epoch], core: np.ndarray) -> np.ndarray:
    """(p, 3) of the wall, outwards."""
    found = py4dgeo.M3C2(epochs=tuple(epochs), corepoints=core, normal_radii=[NORMALS], cyl_radius=NORMALS).directions()
    return found * np.sign(np.sum(found[:, :2] * core[:, :2], axis=1))[:, None]


class _Silent:
    """In the place of the queue that draws M3C2-EP's progress bar."""

    def put(self, _: object) -> None: ...


class _Shared:
    """A cloud in shared memory, where M3C2-EP looks for it."""

    def __init__(self, cloud: np.ndarray) -> None:
        self.shape, self._cloud = cloud.shape, cloud

    def __enter__(self) -> "_Shared":
        self._memory = SharedMemory(create=True, size=self._cloud.nbytes)
        self.name = self._memory.name
        np.ndarray(self.shape, dtype=float, buffer=self._memory.buf)[:] = self._cloud
        return self

    def __exit__(self, *_: object) -> None:
        self._memory.close()
        self._memory.unlink()
