"""Quantities as people write them: read exactly, or refused with a sentence; never read as something else."""

import math

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.units import DIMENSIONS, USUAL, _registry, parse_quantity

WRITTEN = {
    ("6 in", "length"): 0.1524,
    ("13.10 in", "length"): 13.1 * 0.0254,
    ("150mm", "length"): 0.15,
    (" 150 mm ", "length"): 0.15,
    ("-.5 mm", "length"): -0.0005,
    ("+1e-3 m", "length"): 0.001,
    ("1E2 cm", "length"): 1.0,
    ("20 um", "length"): 20e-6,
    ("20 \N{MICRO SIGN}m", "length"): 20e-6,
    ("20 \N{GREEK SMALL LETTER MU}m", "length"): 20e-6,
    ("2 feet", "length"): 0.6096,
    ("19.9 deg", "angle"): math.radians(19.9),
    ("19.9\N{DEGREE SIGN}", "angle"): math.radians(19.9),
    ("26 mrad", "angle"): 0.026,
    ("200 ms", "time"): 0.2,
}
UNREADABLE = [
    "",
    "m",
    "1,5 mm",
    "1 000 mm",
    "1 1/2 in",
    "1/2 in",
    "5 ft 6 in",
    "6 in 3",
    "6 in^2",
    "6 m * 2",
    "9**9**9 m",
    '6"',
    "six in",
    "6 kg",
    "6 furlongz",
    "6 IN",
    "__import__('os')",
    "0x10 m",
    "5 - 3 m",
    "(6 m)",
]


@pytest.mark.parametrize(("written", "value"), WRITTEN.items(), ids=[text for text, _ in WRITTEN])
def test_a_number_with_a_unit_is_read(written, value):
    assert parse_quantity(*written) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("text", UNREADABLE)
def test_whatever_else_is_refused_by_its_text_with_an_example(text):
    with pytest.raises(InputError) as refused:
        parse_quantity(text, "length")
    assert str(refused.value).startswith(f'"{text}" is not a length such as "150 mm"')


def test_a_number_without_a_unit_is_asked_for_one():
    with pytest.raises(InputError, match='"6" has no unit; write a length such as "150 mm"'):
        parse_quantity("6", "length")


def test_a_length_is_no_angle():
    with pytest.raises(InputError, match=r'"6 in" is not an angle such as "1.5 deg"'):
        parse_quantity("6 in", "angle")


@pytest.mark.parametrize("dimension", USUAL)
def test_usual_units_are_what_the_unit_library_says_to_the_last_digit(dimension):
    rng, unit = np.random.default_rng(1), DIMENSIONS[dimension][0]
    for symbol in USUAL[dimension]:
        for value in np.round(rng.uniform(-50, 500, 50), 3):
            expected = float(_registry().Quantity(float(value), symbol).to(unit).magnitude)
            assert parse_quantity(f"{value} {symbol}", dimension) == expected
