"""The entrance pupil by two pins: found as well as stated, from either side, and not from evidence that lacks."""

from pathlib import Path

import numpy as np
import pytest
from calibration_pupil_fixtures import INCH, NOISE, PUPIL, SIZE, fitted, marks, with_columns
from PIL import Image

from calibore.calibration import calibrate_pupil, recomputed_covariance, write_calibration
from calibore.calibration._pupil._model import PinModel, camera_rotation
from calibore.calibration._pupil._start import start_values
from calibore.errors import InputError
from calibore.units import parse_quantity

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "pupil"
needs_shared = pytest.mark.skipif(
    not SHARED.exists(), reason="the shared two-pin pictures are not beside the repository"
)
TARGET = """format = "calibore-target/1"
kind = "two-pin"
images = "pin {slide} {turn}.png"
slides = ["0.6 in", "0.9 in"]
turntable = ["-6.5 deg", "6.5 deg"]
near_pin = "lower"
far_pin = "upper"
"""


def test_predictions_have_exact_derivatives():
    rng = np.random.default_rng(1)
    read, seen = marks(rng, rows=3)
    model = PinModel("stereographic", *SIZE, read, np.unique(seen.picture))
    start = start_values(model, seen).values
    values = np.concatenate([start + rng.normal(0, 1e-3, start.size), rng.normal(0, 1e-3, 9)])
    values[1], values[7] = 6500.0, 0.13
    u, by_values = model.predicted(values, with_columns(seen, half_width=0 * seen.u))
    seen = with_columns(seen, u=u, half_width=0 * u)
    for column, name in enumerate(model.names):
        step = np.zeros(values.size)
        step[column] = 1e-6 * max(abs(values[column]), 0.1)
        rise = (model.predicted(values + step, seen)[0] - model.predicted(values - step, seen)[0]) / (2 * step[column])
        assert np.abs(rise - by_values[:, column]).max() <= 1e-5 * np.abs(rise).max() + 1e-6, name


def test_a_camera_turns_right_up_and_clockwise():
    for angles, ahead in (((0.1, 0, 0), [0.0998, 0, 0.995]), ((0, 0.1, 0), [0, -0.0998, 0.995])):
        np.testing.assert_allclose(camera_rotation(*angles)[0] @ [0, 0, 1], ahead, atol=1e-3)
    np.testing.assert_allclose(camera_rotation(0, 0, 0.1)[0] @ [1, 0, 0], [0.995, 0.0998, 0], atol=1e-3)


def test_the_pupil_is_found_as_well_as_stated():
    rng = np.random.default_rng(2)
    found = [fitted(*marks(rng)).pupil for _ in range(8)]
    error = np.array([(one.value - PUPIL) / one.u for one in found])
    assert np.abs(error).max() < 3.5
    assert 0.4 < np.sqrt(np.mean(error**2)) < 1.65  # chi of 8: within 2.5 of its standard deviations
    assert max(one.u for one in found) < 0.003 * INCH


def test_scales_that_count_the_other_way_give_the_same_pupil():
    read, seen = marks(np.random.default_rng(3))
    usual = fitted(read, seen)
    turned = fitted(read, with_columns(seen, turn=-seen.turn))
    assert turned.pupil.value == pytest.approx(usual.pupil.value, abs=0.02 * usual.pupil.u)
    backwards = fitted(2 * INCH - read, seen)
    assert (usual.model.forwards, backwards.model.forwards) == (1, -1)
    assert 2 * INCH - backwards.pupil.value == pytest.approx(usual.pupil.value, abs=0.02 * usual.pupil.u)


def test_the_lens_law_is_told_by_how_the_pins_bend():
    read, seen = marks(np.random.default_rng(4), law="perspective", rows=20)
    found = fitted(read, seen, laws=("equidistant", "perspective", "sine-law"))
    assert found.comparisons[0].model == "perspective"
    assert abs(found.pupil.value - PUPIL) < 3.5 * found.pupil.u
    assert found.comparisons[0].rmse < 1.3 * np.hypot(NOISE, 0.02)


def test_one_angle_one_slide_or_pins_at_one_distance_are_refused():
    rng = np.random.default_rng(5)
    read, seen = marks(rng, turns=(3.0, 3.1))
    with pytest.raises(InputError, match="one turntable angle"):
        fitted(read, seen)
    read, seen = marks(rng, slides=(0.6,))
    with pytest.raises(InputError, match="one slide reading"):
        fitted(read, seen)
    read, seen = marks(rng, distances=(10.0, 10.02))
    with pytest.raises(InputError, match="move alike at every slide reading"):
        fitted(read, seen)


def test_near_and_far_interchanged_is_told():
    read, seen = marks(np.random.default_rng(6))
    with pytest.raises(InputError, match="interchange near_pin and far_pin"):
        fitted(read, with_columns(seen, near=~seen.near))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (('"upper"', '"lower"'), 'near_pin and far_pin are both "lower"'),
        (("pin {slide} {turn}.png", "pin {slide}.png"), "fields {slide} and {turn}"),
        (('"0.6 in"', '"0.6"'), "slides"),
        (('lens = "fisheye"', ""), "no picture shows both pins. The first: pin 0 0.png: no pin stands alone"),
    ],
)
def test_a_target_that_cannot_be_used_says_why(tmp_path, wrong, said):
    for name in ("pin 0 0", "pin 0 1", "pin 1 0", "pin 1 1"):
        Image.fromarray(np.full((100, 120), 128, np.uint8)).save(tmp_path / f"{name}.png")
    (tmp_path / "target.toml").write_text(TARGET.replace(*wrong))
    with pytest.raises(InputError, match=said.replace("{", r"\{").replace("}", r"\}")):
        calibrate_pupil(tmp_path)


@pytest.fixture(scope="module")
def shared_pupil():
    return calibrate_pupil(SHARED)


@pytest.mark.slow
@needs_shared
def test_the_shared_fixture_has_its_pupil_where_it_was_put(shared_pupil):
    (value,), (u,) = shared_pupil.values.values(), shared_pupil.covariance.u
    assert abs(value - PUPIL) < min(0.02 * INCH, 2.5 * u)
    assert shared_pupil.models[0].model == "equidistant"
    said = {name: parse_quantity(text, "length") for name, text in shared_pupil.settings["pupil"].items()}
    assert said == pytest.approx({"slide": value, "first_slide": 0.6 * INCH, "last_slide": 1.2 * INCH})


@pytest.mark.slow
@needs_shared
def test_the_shared_fixture_is_told_in_sentences(shared_pupil):
    said = " ".join(shared_pupil.findings)
    assert "The entrance pupil stands over the pivot at a slide reading of 1.23" in said
    assert "beyond the readings photographed" in said
    assert said.count("ahead of the pivot (more than 99.9 % sure): the near pin moves more") == 4
    assert not shared_pupil.warnings


@pytest.mark.slow
@needs_shared
def test_the_evidence_of_the_shared_fixture_gives_its_uncertainty_again(shared_pupil, tmp_path):
    write_calibration(shared_pupil, tmp_path / "pupil.toml")
    again = recomputed_covariance(tmp_path / "pupil.toml")
    assert again.u[0] == pytest.approx(shared_pupil.covariance.u[0], rel=0.02)
