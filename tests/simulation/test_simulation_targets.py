"""Simulated targets go through the program's own calibration, which finds the truth that lies beside them."""

from dataclasses import replace

import numpy as np
import pytest

from calibore.calibration import calibrate
from calibore.errors import InputError, OutputError
from calibore.images import read_image
from calibore.lasers import Cone, Plane, Sheet
from calibore.optics import Camera, Lens
from calibore.rigs import Laser, Probe, Rig, SideFacing, moved
from calibore.simulation import (
    BoardTarget,
    Gauge,
    GaugeTarget,
    Pin,
    PinTarget,
    ProbeTarget,
    RangeTarget,
    RingTarget,
    Sensor,
    held_boards,
    simulate_target,
)
from calibore.targets import Board
from calibore.uncertainty import Covariance

INCH = 0.0254
LIKELY = 3.5
"""Standard uncertainties within which one case lies: with the 6 degrees of freedom of few rings or stops, 98.7 %."""
CAMERA = Camera(320, 240, Lens("equidistant", 127.0, 120.0), (162.0, 118.0))
RINGS = RingTarget(
    CAMERA,
    Plane(0.09, 0.01, -0.02),
    ring_spacing=0.02,
    rings=6,
    centre=(0.001, 0.002),
    roll=0.3,
    u_ring=2e-5,
    nominal_baseline=0.085,
    stated={"lens": "equidistant"},
)
HEAD = Rig(
    "side-facing",
    Camera(320, 192, Lens("equidistant", 800.0, 96.0), (160.0, 96.0)),
    (Laser(Sheet(lean=0.002), "red"),),
    mount=SideFacing(0.06, np.radians(20)),
)
RANGES = RangeTarget(
    HEAD,
    (11, 13, 15, 18, 21, 24),
    step=0.01,
    design=moved(HEAD, {"laser.baseline": 0.001, "laser.aim": 0.007, "camera.k": -10.0}),
    u_range=1e-5,
)
SMALL = Camera(360, 280, Lens("equidistant", 150.0, 140.0), (180.0, 140.0))
PLANE = Rig("perpendicular-plane", SMALL, (Laser(Plane(0.12, 0.01, -0.006), "red"),))
CONE = Rig("single-cone", SMALL, (Laser(Cone.for_ring(0.04, 0.13, 0.1), "red"),))
QUIET = Sensor(speckle_contrast=0.2)
GAUGES = GaugeTarget(
    PLANE,
    (Gauge(0.16, (0.004, 0.002)), Gauge(0.2, (-0.012, 0.008)), Gauge(0.24, (0.012, -0.006))),
    design=moved(PLANE, {"laser.baseline": 0.004, "laser.tilt_x": -0.01, "laser.tilt_y": 0.006}),
    u=2e-5,
    sensor=QUIET,
)
PINS = PinTarget(
    Camera(640, 480, Lens("equidistant", 2000.0, 240.0), (322.0, 238.0)),
    pupil=1.237 * INCH,
    slides=(0.6 * INCH, 0.9 * INCH, 1.2 * INCH),
    turns=tuple(np.radians([-6.5, 0.0, 6.5])),
    near=Pin(0.0005, 5 * INCH, 0.03 * INCH, -0.05 * INCH, 3 * INCH, 0.25),
    far=Pin(-0.0008, 22 * INCH, 0.09 * INCH, -3.5 * INCH, 0.25 * INCH, 0.45),
    stated={"lens": "equidistant"},
)
BOARD = Board("chessboard", (7, 5))
PROBE = Probe(
    5.2405 * INCH,
    4.5706 * INCH,
    Covariance(("probe.slope", "probe.intercept"), np.zeros((2, 2))),
    noise=0.0006 * INCH,
    stroke=(0.02, 0.65),
)
TOUCHED = ProbeTarget(PROBE, ((5.98 * INCH, 5.66 * INCH), (5.97 * INCH, 5.55 * INCH), (5.49 * INCH, 6.0 * INCH)))


def found_and_true(folder, verb, target, *, seed):
    simulate_target(folder, target, seed=seed)
    with np.load(folder / "truth.npz") as truth:
        return calibrate(verb, folder), {name: truth[name] for name in truth}


def away(found, truth):
    """Errors of what was found, in standard uncertainties, by name."""
    u = dict(zip(found.covariance.names, found.covariance.u.tolist(), strict=True))
    return {name: (value - float(truth[name])) / u[name] for name, value in found.values.items()}


@pytest.mark.parametrize(
    ("verb", "target", "tells"),
    [
        pytest.param("lens", RINGS, {"camera.k", "laser.baseline"}, marks=pytest.mark.slow),
        ("rig", RANGES, {"laser.baseline", "laser.aim", "camera.k"}),
        ("rig", GAUGES, {"laser.baseline", "laser.tilt_x", "laser.tilt_y"}),
        ("pupil", PINS, {"pupil.slide"}),
        ("probe", TOUCHED, {"probe.slope", "probe.intercept"}),
    ],
    ids=["rings", "range", "gauges", "pins", "probe"],
)
def test_a_calibration_on_a_simulated_target_finds_the_truth(tmp_path, verb, target, tells):
    found, truth = found_and_true(tmp_path / "target", verb, target, seed=4)
    assert tells <= set(found.values)
    errors = away(found, truth)
    assert max(map(abs, errors.values())) < LIKELY, errors


def test_a_lens_is_found_on_boards_held_by_chance(tmp_path):
    pytest.importorskip("cv2")
    camera = Camera(640, 480, Lens("equidistant", 300.0, 240.0), (325.0, 236.0))
    poses = held_boards(camera, BOARD, square=0.024, count=8, rng=np.random.default_rng(1))
    target = BoardTarget(camera, BOARD, square=0.024, poses=poses, stated={"lens": "equidistant"})
    found, truth = found_and_true(tmp_path / "boards", "lens", target, seed=1)
    errors = away(found, truth)
    assert max(map(abs, errors.values())) < 5, errors  # the finder's own error, 0.003 px, is no chance


def test_a_head_whose_stops_are_off_by_more_is_found_less_well(tmp_path):
    """What the slide is off by is in the pictures, in truth.npz, and so in what is stated of the head."""
    u = []
    for name, u_range in (("well", 1e-5), ("badly", 3e-4)):
        target = replace(RANGES, u_range=u_range, takes=1, room_takes=())
        found, truth = found_and_true(tmp_path / name, "rig", target, seed=5)
        off = truth["range_true"] - truth["range_nominal"]
        assert 0.3 * u_range < np.std(off) < 2 * u_range
        u.append(found.covariance.u[found.covariance.names.index("laser.baseline")])
    assert u[1] > 3 * u[0]  # speckle has its part in the first


def test_a_stop_that_the_camera_does_not_see_is_dark(tmp_path):
    folder = simulate_target(tmp_path, replace(RANGES, indices=(4, 18), takes=1, room_takes=()), seed=1)
    dark, lit = (read_image(folder / f"range {index:03d} 0.png")[..., 0] for index in (4, 18))
    assert dark.max() < 20
    assert lit.max() > 100


def test_what_is_stated_replaces_what_follows_from_the_design(tmp_path):
    folder = simulate_target(
        tmp_path, replace(TOUCHED, stated={"u_contact": None, "adc_bits": 12, "adc_range": 5.0}), seed=1
    )
    text = (folder / "target.toml").read_text()
    assert "u_contact" not in text
    assert "adc_bits = 12\nadc_range = 5.0\n" in text


def test_the_same_seed_gives_the_same_bytes_and_another_seed_other_pictures_and_errors(tmp_path):
    one, same, other = (simulate_target(tmp_path / n, RINGS, seed=s) for n, s in (("a", 1), ("b", 1), ("c", 2)))
    names = {path.name for path in one.iterdir()}
    assert names == {"rings 0.png", "target.toml", "truth.npz"}
    assert all((one / name).read_bytes() == (same / name).read_bytes() for name in names)
    assert (one / "rings 0.png").read_bytes() != (other / "rings 0.png").read_bytes()
    assert (one / "target.toml").read_bytes() == (other / "target.toml").read_bytes()
    radii = [np.load(folder / "truth.npz")["ring_radius"] for folder in (one, other)]
    assert not np.allclose(*radii, atol=1e-9)


def test_an_earlier_target_is_replaced_but_no_other_folder(tmp_path):
    simulate_target(tmp_path / "probe", TOUCHED, seed=1)
    simulate_target(tmp_path / "probe", TOUCHED, seed=2)
    (tmp_path / "probe" / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"notes\.txt.*no simulated target"):
        simulate_target(tmp_path / "probe", TOUCHED, seed=1)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: replace(RINGS, ink_width=0.03), "thinner than their spacing"),
        (lambda: replace(RANGES, rig=PLANE), "calibrates a side-facing head"),
        (lambda: replace(RANGES, indices=(-3, 4, 5)), "positive range"),
        (lambda: replace(GAUGES, rig=HEAD), "on a flat at ranges"),
        (lambda: Gauge(0.1, (0.06, 0.0)), "inside its gauge"),
        (lambda: replace(PINS, slides=()), "needs readings of slide"),
        (lambda: replace(TOUCHED, wrong=(0.0,)), "as many stops and wrong as contacts"),
    ],
)
def test_a_target_that_cannot_be_says_why(make, said):
    with pytest.raises(InputError, match=said):
        make()
