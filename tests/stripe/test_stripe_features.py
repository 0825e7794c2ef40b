"""Features of the wall are no noise: what they do to a line does not make the rest of it uncertain."""

import numpy as np
import pytest

from calibore.stripe import NoiseModel, Stripe
from calibore.stripe._features import freed_of_features
from calibore.stripe._scatter import observe_scatter

RAYS, WIDTH, REACH = 1500, 1.5, 9
CASES = 24


def line(rng, *, shape=None, closed=True, tails=None):
    """A stripe as a kernel leaves it: peaks of unequal noise, shared by neighbours, on a line of this `shape` [px]; and
    the true standard uncertainty of each.
    """
    angle = np.arange(RAYS) * 2 * np.pi / RAYS
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1) if closed else np.tile([1.0, 0.0], (RAYS, 1))
    white = rng.standard_normal(RAYS + 2) if tails is None else rng.standard_t(tails, RAYS + 2) * np.sqrt(1 - 2 / tails)
    noise = (white[:-2] + white[1:-1] + white[2:]) / np.sqrt(3)
    sigma = 0.16 * rng.uniform(0.8, 1.25, RAYS)
    position = (240.0 if closed else 500.0) + (0.0 if shape is None else shape(angle)) + sigma * noise
    model = sigma / 1.5
    seen = observe_scatter(position, model, width=WIDTH, spacing=1.0, closed=closed)
    u, v = (400.0 + position * direction[:, 0], 300.0 + position * direction[:, 1]) if closed else (position, angle)
    status, height = np.zeros(RAYS, dtype=np.uint8), np.full(RAYS, 100.0)
    centre = (400.0, 300.0) if closed else None
    found = model * seen.scale
    return Stripe(u, v, direction, found, status, height, seen.correlation, NoiseModel(), seen.scale, centre), sigma


def features(angle):
    """A rail, a bevelled opening, a dent and a crack: a quarter of the ring is bent."""
    rail = -20.0 * (np.abs(angle - 3.1) < 0.1)
    opening = 12.0 * np.clip((0.5 - np.abs(angle - 1.2)) / 0.12, 0, 1)
    dent = -14.0 * np.exp(-0.5 * ((angle - 4.7) / 0.08) ** 2)
    return rail + opening + dent + 3.0 * (np.abs(angle - 2.2) < 0.006) + 4.0 * np.cos(2 * angle)


def sizes(case, seeds=CASES, **options):
    """(stated over true u before, and after) of many lines, and their correlation at lag 1 after."""
    rows = []
    for seed in range(seeds):
        stripe, sigma = line(np.random.default_rng([case, seed]), **options)
        freed = freed_of_features(stripe)
        sizes = [np.sqrt(np.mean(one.u_position**2) / np.mean(sigma**2)) for one in (stripe, freed)]
        rows.append([*sizes, freed.correlation[0], freed.scale / stripe.scale])
    return np.array(rows)


@pytest.mark.parametrize("closed", [True, False])
def test_the_noise_of_a_smooth_line_stays_what_it_is(closed):
    before, after, shared, _ = sizes(1, closed=closed).T
    # one ring tells its scale to 3 %, 24 of them to 0.6 %
    assert after.mean() == pytest.approx(1.0, abs=0.02)
    assert after.mean() == pytest.approx(before.mean(), abs=0.02)
    assert shared.mean() == pytest.approx(2 / 3, abs=0.03)


def test_features_on_a_quarter_of_the_line_do_not_make_the_rest_uncertain():
    before, after, shared, ratio = sizes(2, shape=features).T
    assert before.mean() > 1.15  # a median of squares is moved by them
    assert after.mean() - 1 < (before.mean() - 1) / 3
    assert shared.mean() == pytest.approx(2 / 3, abs=0.04)
    assert np.all(ratio < 1)


def test_noise_with_heavier_tails_than_normal_is_not_cut_to_less_than_nine_tenths():
    _, after, _, _ = sizes(3, tails=6).T
    assert 0.9 <= after.mean() <= 1.02


def test_a_line_whose_scatter_tells_nothing_is_left_as_it_is():
    stripe, _ = line(np.random.default_rng(4))
    gone = np.full(RAYS, np.nan)
    gone[:30] = 0.0
    few = Stripe(*(getattr(stripe, n) + gone if n in "uv" else getattr(stripe, n) for n in stripe.__dataclass_fields__))
    assert freed_of_features(few) is few
