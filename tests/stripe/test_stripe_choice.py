"""Which candidate is the line, and what is said where nobody can tell."""

import numpy as np
import pytest
from stripe_scenes import exposed, line_image, red, ring_brightness

from calibore.errors import ImageError
from calibore.status import Status
from calibore.stripe import Stripe, detect_line, detect_ring
from calibore.stripe._chain import choose, link

SHAPE, CENTRE, RADIUS = (300, 330), (163.4, 151.7), 80.0


def seen(image: np.ndarray, **options: object) -> Stripe:
    arguments: dict = {"inner": 40, "outer": 130, "channel": "red", "rays": 900} | options
    return detect_ring(image, (160, 150), **arguments)


def on_ring(stripe: Stripe, radius: float = RADIUS) -> np.ndarray:
    return np.abs(np.hypot(stripe.u - CENTRE[0], stripe.v - CENTRE[1]) - radius) < 1.0


def test_spatter_brighter_than_the_line_is_not_the_line() -> None:
    rng = np.random.default_rng(0)
    brightness = 110 * ring_brightness(SHAPE, CENTRE, RADIUS)
    row, column = np.indices(SHAPE)
    for azimuth in np.arange(12) * np.pi / 6:
        spot = CENTRE[0] + 100 * np.cos(azimuth), CENTRE[1] + 100 * np.sin(azimuth)
        brightness += 140 * np.exp(-((column - spot[0]) ** 2 + (row - spot[1]) ** 2) / (2 * 1.2**2))
    stripe = seen(red(brightness, rng))
    assert stripe.found.mean() > 0.99
    assert on_ring(stripe)[stripe.found].all()
    assert np.any(stripe.status == Status.RESOLVED), "that there was a choice is said"


def test_of_two_equal_rings_none_is_preferred() -> None:
    brightness = 120 * (ring_brightness(SHAPE, CENTRE, RADIUS) + ring_brightness(SHAPE, CENTRE, 105.0))
    with pytest.raises(ImageError, match="too few connected peaks"):
        seen(red(brightness, np.random.default_rng(1)))


def test_where_a_second_line_runs_beside_the_first_there_is_no_number() -> None:
    image, _ = line_image(np.random.default_rng(2), columns=600, slope=0.0, peak=120.0)
    twin = np.vstack([image, image])
    stripe = detect_line(twin)
    assert np.all(stripe.status == Status.MULTIPLE)
    assert np.isnan(stripe.v).all()
    assert np.isnan(stripe.u_position).all()


def test_a_gap_stays_a_gap() -> None:
    row, column = np.indices(SHAPE)
    azimuth = np.arctan2(row - CENTRE[1], column - CENTRE[0])
    dark = np.abs(azimuth - 1.0) < 0.25
    stripe = seen(red(np.where(dark, 0.0, 150 * ring_brightness(SHAPE, CENTRE, RADIUS)), np.random.default_rng(3)))
    of_ray = np.arctan2(stripe.direction[:, 1], stripe.direction[:, 0])
    assert not stripe.found[np.abs(of_ray - 1.0) < 0.23].any()
    assert stripe.found[np.abs(of_ray - 1.0) > 0.28].all()
    assert np.isnan(stripe.u[~stripe.found]).all()


def test_white_glare_on_a_red_ring_is_not_measured() -> None:
    rng = np.random.default_rng(4)
    row, column = np.indices(SHAPE)
    brightness = 140 * ring_brightness(SHAPE, CENTRE, RADIUS)
    azimuth, radius = np.arctan2(row - CENTRE[1], column - CENTRE[0]), np.hypot(column - CENTRE[0], row - CENTRE[1])
    crescent = 150 * np.exp(-((radius - 100) ** 2) / (2 * 1.6**2)) * (np.abs(azimuth) < 0.6)
    brightness[(np.abs(azimuth) < 0.5) & (radius < 90)] = 0
    image = np.clip(red(brightness, rng).astype(int) + exposed(crescent, rng)[:, :, None], 0, 255).astype(np.uint8)
    stripe = seen(image)
    glare = np.abs(np.arctan2(stripe.direction[:, 1], stripe.direction[:, 0])) < 0.45
    assert np.all(stripe.status[glare] == Status.NOT_LASER)
    assert stripe.found[~glare].mean() > 0.9
    assert on_ring(stripe)[stripe.found].all()


def test_a_saturated_line_is_flagged_and_stays_in_place() -> None:
    image, row = line_image(np.random.default_rng(5), columns=800, peak=700.0)
    stripe = detect_line(image)
    assert np.all(stripe.status == Status.SATURATED)
    assert np.sqrt(np.nanmean((stripe.v - row) ** 2)) < 0.2
    assert np.isfinite(stripe.u_position).all()


def test_ripples_that_continue_nothing_are_no_rivals() -> None:
    rng, rays = np.random.default_rng(6), 400
    line = 50 + np.cumsum(rng.normal(0, 0.1, rays))
    stray = np.where(rng.random(rays) < 0.3, rng.uniform(0, 200, rays), np.nan)
    length = link(np.stack([line, stray], axis=1), spacing=1.0, closed=False)
    laser = length > 0
    for share, expected in ((0.1, Status.OK), (0.3, Status.RESOLVED)):
        height = np.stack([np.full(rays, 100.0), np.full(rays, 100.0 * share)], axis=1)
        pick, status = choose(length, laser, height)
        assert np.all(pick == 0)
        assert np.all(status[laser[:, 1]] == expected)
        assert np.all(status[~laser[:, 1]] == Status.OK)


def test_a_faint_line_that_continues_is_a_rival_however_faint() -> None:
    rays = 400
    position = np.stack([np.full(rays, 50.0), np.where(np.arange(rays) < 60, 90.0, np.nan)], axis=1)
    length = link(position, spacing=1.0, closed=False)
    height = np.stack([np.full(rays, 100.0), np.full(rays, 5.0)], axis=1)
    _, status = choose(length, length > 0, height)
    assert np.all(status[:60] == Status.RESOLVED)
    assert np.all(status[60:] == Status.OK)


def test_nine_rays_are_no_line_and_ten_are() -> None:
    for count, expected in ((9, Status.OFF_RING), (10, Status.OK)):
        position = np.full((50, 1), np.nan)
        position[20 : 20 + count] = 7.0
        length = link(position, spacing=1.0, closed=False)
        _, status = choose(length, length > 0, np.ones((50, 1)))
        assert np.all(status[20 : 20 + count] == expected)
        assert np.all(status[:20] == Status.NO_PEAK)


def test_a_closed_chain_is_one_chain_wherever_it_begins() -> None:
    position = np.full((60, 1), np.nan)
    position[5:35] = 3.0
    for turn in range(60):
        length = link(np.roll(position, turn, axis=0), spacing=1.0, closed=True)
        assert set(np.unique(length)) == {0, 30}
