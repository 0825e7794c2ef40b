"""Numbers that fuzzing has given to functions, reduced: each was a crash, a warning, or no number where one is due."""

from typing import Any

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import Beam, Cone, Plane, Sheet
from calibore.metrics import RingShape
from calibore.optics import Camera, Lens
from calibore.rigs import measure, monte_carlo, triangulate
from calibore.simulation import random_rig
from calibore.stripe import detect_ring
from calibore.uncertainty import Covariance

PLANE = random_rig(np.random.default_rng(1), 0.15).with_default_uncertainty(0.15)
CALLS = {
    "triangulate": lambda u, v, **how: triangulate(PLANE, u, v, **how),
    "measure": lambda u, v, **how: measure(PLANE, u, v, u_pixel=0.1, **how),
    "monte_carlo": lambda u, v, **how: monte_carlo(
        PLANE, u, v, u_pixel=0.1, draws=9, rng=np.random.default_rng(1), **how
    ),
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS.keys())
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"laser": 1}, "none of number 1"),
        ({"laser": -1}, "none of number -1"),
        ({"branch": [0, 0, 7]}, "numbers 0 to 0"),
        ({"prior_radius": 0.0}, "positive"),
        ({"prior_radius": 1e-320}, "positive"),  # radii over it overflowed
        ({"prior_radius": [0.1, 0.1, np.inf]}, "positive"),
        ({"v": [1.0, 2.0]}, "as many u as v"),
    ],
)
def test_what_cannot_be_asked_of_a_rig_is_told_in_a_sentence(call, arguments, said):
    pixels = {"u": [200.0, 250.0, 300.0], "v": [100.0, 200.0, 300.0]}
    with pytest.raises(InputError, match=said):
        call(**(pixels | arguments))


@pytest.mark.parametrize("kernel", ["native", "numpy"])
def test_noise_and_probabilities_that_cannot_be_are_told_in_a_sentence(kernel):
    for wrong in ({"u_pixel": -1.0}, {"u_pixel": np.inf}, {"probability": np.inf}, {"probability": 1.0}):
        how: dict[str, Any] = {"u_pixel": 0.1, "draws": 9, "rng": np.random.default_rng(1), "kernel": kernel} | wrong
        with pytest.raises(InputError):
            monte_carlo(PLANE, [200.0], [100.0], **how)


@pytest.mark.parametrize("kernel", ["native", "numpy"])
def test_pixels_at_infinity_are_outside_without_a_word(kernel):
    far = measure(PLANE, [np.inf, -np.inf, 1e300, 3.0], [0.0, np.inf, -1e300, np.nan], u_pixel=0.1, kernel=kernel)
    assert (far.status != 0).all()
    assert np.isnan(far.radius).all()


@pytest.mark.parametrize(
    "make",
    [
        lambda huge: Plane(0.15, huge),
        lambda huge: Plane(huge),
        lambda huge: Sheet(0.1, huge, 0.0),
        lambda huge: Beam(0.1, 0.0, -huge, 0.3, 0.0),
        lambda huge: Cone(0.0, 0.0, 0.7, 0.0, huge),
        lambda huge: Lens("equidistant", huge, 240.0),
        lambda huge: Lens("equidistant", 300.0, 240.0, c1=huge),
    ],
)
def test_no_light_and_no_lens_has_numbers_whose_products_are_none(make):
    make(0.2)
    for huge in (1e308, -1e200, np.inf, np.nan):
        with pytest.raises(InputError):
            make(huge)


@pytest.mark.parametrize(("key", "value"), [("principal_point", (-1e308, 3.0)), ("aspect", 1e-300), ("aspect", np.inf)])
def test_no_camera_has_its_principal_point_beyond_numbers(key, value):
    how: dict[str, Any] = {"principal_point": (320.0, 240.0), key: value}
    with pytest.raises(InputError):
        Camera(640, 480, Lens("equidistant", 300.0, 240.0), **how)


def test_a_covariance_whose_coefficients_overflow_is_refused():
    for huge, said in ((1e140, "correlat"), (1e308, "finite")):
        with pytest.raises(InputError, match=said):
            Covariance(("a", "b"), np.array([[2.5e-8, huge], [huge, 0.16]]))


@pytest.mark.parametrize(("what", "value"), [("radius", 1e300), ("u_independent", 1e300), ("common_mode", 1e300)])
def test_a_ring_as_large_as_no_pipe_is_refused(what, value):
    ring = {
        "clock": np.arange(40) * np.pi / 20,
        "radius": np.full(40, 0.15),
        "u_independent": np.full(40, 1e-4),
        "common_mode": np.zeros((1, 40)),
    }
    RingShape(**ring)
    ring[what][..., 7] = value
    with pytest.raises(InputError):
        RingShape(**ring)


@pytest.mark.parametrize("clock", [np.array([-1e308, 0.0, 1.0, 1e308]), np.linspace(1e7, 1e7 + 3, 4)])
def test_a_clock_beyond_any_turn_is_refused_before_it_overflows(clock):
    with pytest.raises(InputError, match="within one turn"):
        RingShape(clock, np.full(4, 0.15), np.full(4, 1e-4))


@pytest.mark.parametrize(("rays", "outer"), [(60_000, 40.0), (1500, 900_000.0)], ids=["many", "long"])
def test_the_numpy_kernel_refuses_more_samples_than_it_has_memory_for(rays, outer):
    """It keeps every sample of every ray at once; the compiled kernel keeps one ray."""
    row, column = np.mgrid[:90, :90]
    ring = 20 + 180 * np.exp(-((np.hypot(column - 45, row - 45) - 25) ** 2) / 8)
    how = {"inner": 5.0, "outer": outer, "rays": rays}
    before = peak_memory()
    with pytest.raises(InputError, match=f"got {rays} rays of .*native kernel"):
        detect_ring(ring.astype(np.uint8), (45.0, 45.0), kernel="numpy", **how)
    assert peak_memory() - before < 50_000_000  # it was gigabytes
    assert detect_ring(ring.astype(np.uint8), (45.0, 45.0), **how).found.any()


def test_a_ring_is_looked_for_on_no_more_rays_than_pixels_go_round_a_picture():
    """Each is compared with all within a few pixels: of a million on a small ring, minutes."""
    with pytest.raises(InputError, match="must be 16 to 65536"):
        detect_ring(np.zeros((90, 90), np.uint8), (45.0, 45.0), inner=5.0, outer=40.0, rays=70_000)


@pytest.mark.parametrize("sector", [(-1e308, 1e308), (0.0, 1e9), (np.nan, 1.0)])
def test_a_sector_beyond_any_turn_is_refused_before_it_overflows(sector):
    with pytest.raises(InputError, match="sector must be two azimuths"):
        detect_ring(np.zeros((90, 90), np.uint8), (45.0, 45.0), inner=5.0, outer=40.0, sectors=[(0.0, 6.0), sector])


def peak_memory() -> int:
    """Bytes of address space: what is set aside and never touched is not resident."""
    with open("/proc/self/status", encoding="ascii") as file:
        return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmPeak"))
