"""Through the manhole: against the ladder's closed form and against turning a body in small steps."""

import numpy as np
import pytest

from calibore.design import deployment, longest_body, plane_rig, rig_length
from calibore.errors import InputError


def _passes(length, manhole, pipe, height):
    """Whether a body kept against floor and rear wall turns by 90 deg without touching the edge of shaft and pipe."""
    for tilt in np.linspace(0, np.pi / 2, 721):
        top = np.array([0.0, length * np.sin(tilt)])
        along, across = np.array([np.cos(tilt), -np.sin(tilt)]), np.array([np.sin(tilt), np.cos(tilt)])
        sides = np.linspace(0, 1, 121)[:, None]
        outline = np.vstack(
            [
                top + height * across + sides * length * along,
                top + sides * height * across,
                top + length * along + sides * height * across,
            ]
        )
        if ((outline[:, 0] > manhole + 1e-9) & (outline[:, 1] > pipe + 1e-9)).any():
            return False
    return True


def test_a_thin_body_is_the_ladder_round_the_corner():
    rng = np.random.default_rng(9)
    for manhole, pipe in rng.uniform(0.1, 3, (200, 2)):
        ladder = (manhole ** (2 / 3) + pipe ** (2 / 3)) ** 1.5
        assert longest_body(manhole, pipe, 1e-12) == pytest.approx(ladder, rel=1e-6)


def test_the_longest_body_just_passes_when_turned_in_small_steps():
    rng = np.random.default_rng(10)
    for _ in range(12):
        manhole, pipe = rng.uniform(0.4, 1.5, 2)
        height = rng.uniform(0.05, 0.5) * min(manhole, pipe)
        longest = longest_body(manhole, pipe, height)
        if longest <= 1.001 * max(manhole, np.sqrt(pipe**2 - height**2)):
            continue
        assert _passes(0.998 * longest, manhole, pipe, height)
        assert not _passes(1.01 * longest, manhole, pipe, height)


def test_more_room_never_hurts_and_a_higher_body_never_helps():
    rng = np.random.default_rng(11)
    for manhole, pipe, height in rng.uniform([0.4, 0.4, 0.01], [2.0, 2.0, 0.39], (300, 3)):
        base = longest_body(manhole, pipe, height)
        assert longest_body(1.1 * manhole, pipe, height) >= base
        assert longest_body(manhole, 1.1 * pipe, height) >= base
        assert longest_body(manhole, pipe, 1.1 * height) <= base
        assert longest_body(2 * manhole, 2 * pipe, 2 * height) == pytest.approx(2 * base, rel=1e-9)


def test_a_body_too_high_for_shaft_or_pipe_does_not_enter_and_a_short_one_goes_down_level():
    assert longest_body(0.6, 0.3, 0.31) == 0
    assert longest_body(0.2, 0.3, 0.21) == 0
    assert longest_body(1.0, 1.0, 1.0) == pytest.approx(1.0)


def test_the_verdict_counts_the_rig_and_its_crawler():
    rig = plane_rig(2.0, nominal_radius=0.15)
    assert rig_length(rig) == pytest.approx(0.3)
    limit = longest_body(0.6, 0.3, 0.1)
    for spare, fits in ((1e-6, True), (-1e-6, False)):
        found = deployment(rig, nominal_radius=0.15, manhole=0.6, body_length=limit - 0.3 - spare, body_height=0.1)
        assert found.fits is fits
    with pytest.raises(InputError, match="manhole must have a positive size"):
        deployment(rig, nominal_radius=0.15, manhole=0.0, body_length=0.3, body_height=0.1)
