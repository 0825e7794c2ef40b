"""Calibrations made without pictures: least squares on simulated marks, every number of which is known."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from calibore.calibration import Calibration, Comparison, InputFile, Observations
from calibore.geometry import Pose
from calibore.lasers import Cone, Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Rig, SideFacing, ValidRegion, moved, triangulate
from calibore.uncertainty import Covariance

INCH = 0.0254
RADIUS = 6 * INCH
LENS = ("camera.k", "camera.c1", "camera.c2", "camera.principal_point_u", "camera.principal_point_v")


def fisheye(law="equidistant", *, c1=-0.02, c2=0.0):
    return Camera(1024, 768, Lens(law, 430.0, 384.0, c1, c2), (515.0, 380.0))


def plane_rig(camera=None):
    return Rig("perpendicular-plane", camera or fisheye(), (Laser(Plane(RADIUS, 0.004, -0.003)),))


def cone_rig(camera=None, lasers=1):
    surfaces = [Cone.for_ring(0.5 * RADIUS, 1.2 * RADIUS, RADIUS, clock=clock) for clock in (0.0, 2.5)[:lasers]]
    name = "single-cone" if lasers == 1 else "dual-cone"
    return Rig(name, camera or fisheye(), tuple(Laser(surface) for surface in surfaces))


def known(rig, *, size=1.0, seed=5):
    """`rig` with a correlated covariance of everything that a calibration finds, `size` times a careful workshop's."""
    u = {"k": 0.8, "c1": 2e-3, "c2": 1e-3, "principal_point_u": 0.5, "principal_point_v": 0.5, "aspect": 2e-4}
    u |= {"baseline": 1e-4, "offset": 1e-4} | dict.fromkeys(("tilt_x", "tilt_y", "aim", "half_angle", "clock"), 1e-3)
    u |= dict.fromkeys(("skew", "lean"), 1e-3)
    names = rig.parameter_names
    scale = size * np.array([u[name.split(".")[-1]] for name in names])
    factor = np.random.default_rng(seed).normal(size=(len(names), 3)) + 2 * np.eye(len(names), 3)
    factor = np.hstack([factor, 0.5 * np.eye(len(names))])
    factor *= scale[:, None] / np.linalg.norm(factor, axis=1, keepdims=True)
    return rig.knowing(Covariance(names, factor @ factor.T))


def drawn(rig, rng, count):
    """`count` rigs with parameters drawn from the covariance of `rig`."""
    for change in rig.covariance.draw(rng, count).tolist():
        yield moved(rig, dict(zip(rig.covariance.names, change, strict=True)))


def published_head():
    """The source's side-facing head with the covariance of its own fit: 79 stops of 0.1 in, 0.0102 in of scatter."""
    camera = Camera(1024, 768, Lens("equidistant", 3183.099, 384.0), (512.0, 384.0))
    rig = Rig("side-facing", camera, (Laser(Sheet()),), mount=SideFacing(2.4 * INCH, np.radians(20.5)))
    ranges = np.linspace(4.2, 12.0, 79) * INCH
    u, v = rig.project(np.stack([0 * ranges, ranges, 0 * ranges], axis=1))
    slopes = triangulate(rig, u, v).radius_sensitivities.parameters
    names = ("laser.baseline", "laser.aim", "camera.k")
    jacobian = slopes[:, [rig.parameter_names.index(name) for name in names]]
    return rig.knowing(Covariance(names, np.linalg.inv(jacobian.T @ jacobian) * (0.0102 * INCH) ** 2), 76.0)


@lru_cache(maxsize=8)
def board_calibration(seed=1, *, law="equidistant", fitted="equidistant", boards=14, noise=0.15, bent=0.0):
    """Of a camera from `boards` pictures of 9 x 7 marks: least squares with exact Jacobians, poses fitted beside.

    `bent` [px]: waves of the true lens that no model has.
    """
    rng = np.random.default_rng(seed)
    truth = fisheye(law)
    poses = [_pose(rng) for _ in range(boards)]
    x, y = (a.ravel() for a in np.meshgrid(np.arange(9) - 4.0, np.arange(7) - 3.0))
    board = np.stack([x, y, 0 * x], axis=1) * 0.02
    marks = [np.stack(truth.project(pose.apply(board)), axis=1) for pose in poses]
    marks = [_bent(one, truth, bent) + rng.normal(scale=noise, size=one.shape) for one in marks]
    camera = replace(truth, lens=Lens(fitted, 430.0, 384.0, -0.01))
    for _ in range(6):
        residual, jacobian, step = _step(camera, poses, board, marks)
        camera = moved(plane_rig(camera), dict(zip(LENS, step[: len(LENS)].tolist(), strict=True))).camera
        poses = [_turned(pose, part) for pose, part in zip(poses, step[len(LENS) :].reshape(-1, 6), strict=True)]
    count = residual.size
    freedom = count - jacobian.shape[1]
    scatter = float(np.sqrt(residual @ residual / freedom))
    covariance = Covariance(LENS, np.linalg.inv(jacobian.T @ jacobian)[: len(LENS), : len(LENS)] * scatter**2)
    pixels = np.concatenate(marks)
    names = (*LENS, *(f"board.{i}.{part}" for i in range(boards) for part in ("rx", "ry", "rz", "x", "y", "z")))
    file = np.repeat(np.arange(boards), 2 * x.size)
    observations = Observations(
        file, *np.repeat(pixels, 2, axis=0).T, residual, np.full(count, scatter), np.ones(count), file, jacobian, names
    )
    zenith = np.arccos(camera.unproject(*pixels.T).direction[:, 2])
    values = [getattr(camera.lens, name.split(".")[1]) for name in LENS[:3]] + list(camera.principal_point)
    return Calibration(
        "chessboard",
        None,
        camera,
        dict(zip(LENS, map(float, values), strict=True)),
        covariance,
        float(freedom),
        scatter,
        0.0,
        tuple(InputFile(f"board {i:02d}.png", "0" * 64) for i in range(boards)),
        observations,
        ValidRegion(zenith=(0.0, float(zenith.max()))),
        (
            Comparison(f"{fitted} + c1, c2", 5, scatter, 0.0, 0.0, 1.04 * scatter),
            Comparison("stereographic", 3, 2.3 * scatter, 410.0, 395.0, 2.5 * scatter, remark="a pattern is left"),
            Comparison("perspective", 3, 40 * scatter, 9000.0, 8990.0, 44 * scatter, remark="cannot be"),
        ),
        findings=(f"The {fitted} law with c1, c2 describes this lens best.",),
    )


def told_before(calibration, *, size, seed=1):
    """The board calibration fitted once more with what somebody else knew of the camera before, `size` times what its
    boards tell: a truth of 430 px and so on, drawn with a correlated covariance.
    """
    seen, count = calibration.observations, len(LENS)
    truth = np.array([430.0, -0.02, 0.0, 515.0, 380.0])
    spread = size * np.linalg.cholesky(calibration.covariance.matrix) @ np.diag([1.0, 1.5, 0.7, 1.0, 0.8])
    told = truth + spread @ np.random.default_rng([2, seed]).normal(size=count)
    rows = np.linalg.inv(spread) @ np.eye(count, len(seen.names))
    before = np.array([calibration.values[name] for name in LENS])
    table = np.concatenate([seen.jacobian / calibration.noise, rows])
    aims = np.concatenate([seen.residual / calibration.noise, np.linalg.solve(spread, told - before)])
    change = np.linalg.lstsq(table, aims)[0]
    values = before + change[:count]
    prior = np.column_stack([rows, np.linalg.solve(spread, told - values)])
    return replace(
        calibration,
        values=dict(zip(LENS, values.tolist(), strict=True)),
        covariance=Covariance(LENS, np.linalg.inv(table.T @ table)[:count, :count]),
        observations=replace(seen, residual=seen.residual - seen.jacobian @ change, prior=prior),
    )


def rig_calibration(seed=1):
    """The board calibration's camera in a plane rig, whose light a target stood in: one covariance of both."""
    from calibore.calibration._planning._plan import plan
    from calibore.calibration._planning._shots import Shot
    from calibore.calibration._planning._targets import PlannedRings

    lens = board_calibration(seed)
    rough = Covariance.independent({"laser.baseline": 5e-3, "laser.tilt_x": 0.02, "laser.tilt_y": 0.02}).joined(
        lens.covariance
    )
    rig = plane_rig(lens.camera).knowing(rough)
    found = plan(
        rig, PlannedRings(INCH, 12), nominal_radius=RADIUS, candidates=(Shot(in_light=True),), count=1
    ).covariance
    valid = ValidRegion(lens.valid.zenith, (0.7 * RADIUS, 1.25 * RADIUS))
    rig = replace(rig.knowing(found, lens.degrees_of_freedom), valid=valid)
    values = lens.values | {"laser.baseline": RADIUS, "laser.tilt_x": 0.004, "laser.tilt_y": -0.003}
    return replace(
        lens, kind="concentric-rings", rig=rig, camera=None, covariance=found, valid=valid,
        values={name: values[name] for name in found.names},
    )  # fmt: skip


def _pose(rng):
    """camera_from_board, the board somewhere in view, up to 35 deg oblique."""
    tilts = rng.uniform(-0.6, 0.6, 2)
    distance = rng.uniform(0.12, 0.25)
    x, y = rng.uniform(-0.7, 0.7, 2) * distance
    return Pose.from_roll_pitch_yaw(rng.uniform(-0.3, 0.3), *tilts, translation=(x, 0.7 * y, distance))


def _bent(pixels, camera, amplitude):
    away = pixels - np.array(camera.principal_point)
    radius = np.linalg.norm(away, axis=1, keepdims=True)
    return pixels + amplitude * np.sin(radius / 25.0) * away / radius


def _turned(pose, change):
    x, y, z = change[:3]
    turn = np.linalg.qr(np.eye(3) + np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))
    rotation = turn[0] * np.sign(np.diag(turn[1])) @ pose.rotation
    return Pose(rotation, pose.translation + change[3:])


def _step(camera, poses, board, marks):
    """Residuals, Jacobian of the predictions, and the Gauss-Newton step."""
    columns = [camera.parameter_names.index(name) for name in LENS]
    size = 2 * len(board)
    jacobian = np.zeros((size * len(poses), len(LENS) + 6 * len(poses)))
    residual = np.zeros(size * len(poses))
    for number, pose in enumerate(poses):
        rows, own = slice(number * size, (number + 1) * size), len(LENS) + 6 * number
        found = camera.project_with_sensitivities(pose.apply(board))
        residual[rows] = (marks[number] - np.stack([found.u, found.v], axis=1)).ravel()
        jacobian[rows, : len(LENS)] = found.by_parameters[:, :, columns].reshape(size, -1)
        arms = (board @ pose.rotation.T)[:, None, :]
        jacobian[rows, own : own + 3] = np.cross(arms, found.by_point).reshape(size, 3)
        jacobian[rows, own + 3 : own + 6] = found.by_point.reshape(size, 3)
    return residual, jacobian, np.linalg.solve(jacobian.T @ jacobian, jacobian.T @ residual)
