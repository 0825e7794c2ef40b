"""Two pins: their axes to a hundredth of a pixel, rows where one covers the other left out, sentences where one is
missing.
"""

from pathlib import Path

import numpy as np
import pytest
from pin_pictures import picture

from calibore.errors import ImageError, InputError
from calibore.images import read_image
from calibore.targets import find_pins

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated" / "pupil"


def axes_off(marks, near, far):
    """How far (n,) marks lie off the true axes (a, b): u = a + b v."""
    place, slope = np.where(marks.near[:, None], near, far).T
    return marks.u - place - slope * marks.v


def test_axes_are_found_to_a_hundredth_of_a_pixel_wherever_the_pins_stand():
    rng = np.random.default_rng(1)
    for _ in range(6):
        near, far = (rng.uniform(180, 260), rng.uniform(-0.05, 0.05)), (rng.uniform(60, 120), rng.uniform(-0.05, 0.05))
        marks = find_pins(picture(rng, near=near, far=far), near_half="lower", far_half="upper")
        off = axes_off(marks, near, far)
        for pin in (True, False):
            mine = off[marks.near == pin]
            assert mine.size >= 100
            assert abs(mine.mean()) < 0.012  # 0.03 px of noise and 0.07 px of pixel phase over 100 rows and more


def test_the_scatter_of_the_marks_is_what_sigma_says():
    rng = np.random.default_rng(2)
    ratios = []
    for _ in range(4):
        near, far = (rng.uniform(180, 260), 0.013), (rng.uniform(60, 120), -0.021)
        marks = find_pins(picture(rng, near=near, far=far, noise=4.0), near_half="lower", far_half="upper")
        off = axes_off(marks, near, far)
        ratios += [np.std(off[marks.near == pin]) / marks.sigma[marks.near == pin][0] for pin in (True, False)]
    assert 0.85 < np.mean(ratios) < 1.18


def test_the_width_of_each_pin_is_found():
    marks = find_pins(picture(np.random.default_rng(3)), near_half="lower", far_half="upper")
    assert abs(np.mean(marks.half_width[marks.near]) - 13) < 0.05
    assert abs(np.mean(marks.half_width[~marks.near]) - 8) < 0.05


@pytest.mark.parametrize("apart", [0.0, 4.0, 10.0, 20.0, 26.0])
def test_rows_where_one_pin_covers_the_other_are_left_out(apart):
    near, far = (200.0, 0.0), (200.0 - apart, 0.0)
    marks = find_pins(picture(np.random.default_rng(4), near=near, far=far), near_half="lower", far_half="upper")
    off = axes_off(marks, near, far)
    assert np.abs(off).max() < 0.5
    assert np.abs([off[marks.near].mean(), off[~marks.near].mean()]).max() < 0.06  # vertical edges keep one pixel phase


def test_the_pins_may_be_the_other_way_up_lighter_than_the_background_in_colour_and_in_16_bit():
    plain = picture(np.random.default_rng(5), levels=(1.4, 1.25))
    usual = find_pins(plain, near_half="lower", far_half="upper")
    turned = find_pins(plain[::-1], near_half="upper", far_half="lower")
    deep = find_pins(
        np.repeat(plain[..., None].astype(np.uint16) * 257, 3, axis=2), near_half="lower", far_half="upper"
    )
    assert np.array_equal(np.sort(turned.u[turned.near]), np.sort(usual.u[usual.near]))
    np.testing.assert_allclose(deep.u, usual.u, atol=1e-6)


def test_dust_beside_a_pin_takes_its_rows_and_no_more():
    rng = np.random.default_rng(6)
    image = picture(rng)
    image[40:60, 136:141] = 20
    clean, dusty = (
        find_pins(one, near_half="lower", far_half="upper") for one in (picture(np.random.default_rng(6)), image)
    )
    far = dusty.u[~dusty.near].mean() - 150 + 0.015 * dusty.v[~dusty.near].mean()
    assert abs(far) < 0.03
    assert dusty.u.size >= clean.u.size - 60


def test_a_picture_without_one_of_the_pins_says_which_half_is_empty():
    rng = np.random.default_rng(7)
    with pytest.raises(ImageError, match="of the upper half; set an upright pin"):
        find_pins(picture(rng, ends=(130, -1)), near_half="lower", far_half="upper")
    with pytest.raises(ImageError, match="of the lower half"):
        find_pins(picture(rng, ends=(400, 140)), near_half="lower", far_half="upper")
    with pytest.raises(ImageError, match="stands alone"):
        find_pins(np.full((300, 400), 128, np.uint8), near_half="lower", far_half="upper")


def test_both_pins_in_one_half_is_a_mistake():
    with pytest.raises(InputError, match='one must be "upper" and the other "lower"'):
        find_pins(np.zeros((300, 400), np.uint8), near_half="lower", far_half="lower")


@pytest.mark.skipif(not SHARED.exists(), reason="the shared two-pin pictures are not beside the repository")
def test_the_pins_of_the_shared_fixture_are_found_in_every_picture():
    for path in sorted(SHARED.glob("*.png"))[::4]:
        marks = find_pins(read_image(path), near_half="lower", far_half="upper")
        assert min(marks.near.sum(), (~marks.near).sum()) > 300
        assert marks.sigma.max() < 0.1
