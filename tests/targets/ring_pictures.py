"""Photographs of ring targets with known marks."""

import numpy as np

from calibore.geometry import Pose
from calibore.optics import Camera, Lens
from calibore.simulation import Sensor, TargetLight, photograph_rings

INCH = 0.0254
LAWS = {
    "sine-law": np.sin,
    "equidistant": np.asarray,
    "equisolid-angle": lambda zenith: np.sin(zenith / 2),
    "stereographic": lambda zenith: np.tan(zenith / 2),
    "perspective": np.tan,
}


def target_pose(camera, *, centre, distance, tilt=0.0, towards=0.0, turn=0.0):
    """`target_from_camera`: the target's centre at the pixel `centre` and `distance` [m] ahead, its plane tilted."""
    ahead = camera.unproject([centre[0]], [centre[1]]).direction[0]
    lean = np.array([[0, 0, np.cos(towards)], [0, 0, np.sin(towards)], [-np.cos(towards), -np.sin(towards), 0]])
    leaning = np.eye(3) + np.sin(tilt) * lean + (1 - np.cos(tilt)) * lean @ lean
    camera_from_target = Pose(leaning, ahead * distance / ahead[2]) @ Pose.from_roll_pitch_yaw(turn)
    return camera_from_target.inverse()


class Photograph:
    """A picture and what is printed on the target: inch rings, 0.06 in ink, unless told otherwise."""

    def __init__(self, camera, pose, *, sensor, rng, rings=12, spokes=8, errors=0.0, light=None, spacing=INCH):
        self.camera, self.pose, self.spacing, self.ink = camera, pose, spacing, 0.06 * spacing
        self.rings, self.spokes, self.errors = rings, spokes, np.broadcast_to(errors, rings)
        self.image = photograph_rings(
            camera, pose, ring_spacing=spacing, rings=rings, spokes=spokes, ink_width=self.ink, sensor=sensor, rng=rng,
            radius_errors=errors, light=light or TargetLight(), paper_radius=(rings + 0.6) * spacing,
        )  # fmt: skip

    def errors_of(self, marks):
        """How far (n,) [px] marks lie, along their directions, beyond the midpoint of the two edges of the ink."""
        edges = [self._edge(marks, side * self.ink / 2) for side in (-1, 1)]
        return -np.mean(edges, axis=0)

    def _edge(self, marks, offset):
        step = np.zeros(marks.u.size)
        for _ in range(8):
            here, beyond = (self._beside(marks, step + ahead) - offset for ahead in (0.0, 1e-3))
            step = step - 1e-3 * here / (beyond - here)
        return step

    def _beside(self, marks, step):
        """Distance (n,) [m] on the target from the midlines of the marks' lines, `step` [px] along their directions."""
        place = np.stack([marks.u, marks.v], axis=1) + step[:, None] * marks.direction
        rays = self.camera.unproject(*place.T)
        origin, direction = self.pose.apply(rays.origin), rays.direction @ self.pose.rotation.T
        x, y = (origin - origin[:, 2:] / direction[:, 2:] * direction)[:, :2].T
        spoke = 2 * np.pi / self.spokes * np.rint(np.arctan2(y, x) * self.spokes / (2 * np.pi))
        radii = self.spacing * np.arange(self.rings + 1) + np.append(0.0, self.errors)
        return np.where(marks.ring > 0, np.hypot(x, y) - radii[marks.ring], y * np.cos(spoke) - x * np.sin(spoke))


def random_photograph(rng, *, width=720):
    """Any lens, target up to 25 % off the middle, tilted up to 10 deg, turned anyhow, unevenly lit."""
    height = 3 * width // 4
    law = str(rng.choice(list(LAWS)))
    distance = rng.uniform(6, 30) * INCH
    scale = height / 2 * rng.uniform(0.9, 1.05) / LAWS[law](np.arctan(12.3 * INCH / distance))
    middle = np.array([width, height]) / 2
    camera = Camera(width, height, Lens(law, float(scale), height / 2), tuple(middle + rng.uniform(-9, 9, 2)))
    centre = middle + rng.uniform(-0.25, 0.25, 2) * (width, height)
    tilt, towards, turn = rng.uniform(0, np.deg2rad(10)), *rng.uniform(0, 2 * np.pi, 2)
    pose = target_pose(camera, centre=centre, distance=distance, tilt=tilt, towards=towards, turn=turn)
    rings = int(rng.integers(8, 13))
    spacing = 12 * INCH / rings
    sensor = Sensor(psf_sigma=rng.uniform(0.6, 1.2), full_well=rng.uniform(6e3, 2e4), bits=int(rng.choice([8, 16])))
    light = TargetLight(rng.uniform(0.45, 0.8), rng.uniform(0, 0.5), rng.uniform(0, 0.4), rng.uniform(0, 2 * np.pi))
    return Photograph(
        camera, pose, sensor=sensor, rng=rng, rings=rings, spokes=int(rng.choice([4, 6, 8])), spacing=spacing,
        errors=rng.normal(0, 5e-4 * INCH, rings), light=light,
    )  # fmt: skip
