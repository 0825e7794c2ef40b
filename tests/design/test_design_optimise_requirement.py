"""Requirement files: what they say, and what they are told when they are wrong."""

from pathlib import Path

import pytest

from calibore.design import read_requirement
from calibore.errors import InputError

EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "design").glob("*.toml"))
GOOD = """
format = "calibore-design/1"
[pipe]
radius = ["5 in", "7 in"]
[requirement]
u95 = "1 %"
deflection = "5 %"
[crawler]
length = "24 in"
diameter = "8 in"
[laser]
length = "50 mm"
diameter = "20 mm"
[noise]
stripe = 0.5
length = "0.1 mm"
[[camera]]
name = "HD"
width = 1920
height = 1080
body_length = "80 mm"
body_diameter = "50 mm"
lenses = ["perspective"]
"""


def _read(tmp_path, text):
    path = tmp_path / "spec.toml"
    path.write_text(text, encoding="utf-8")
    return read_requirement(path)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_valid(path):
    assert read_requirement(path).camera


def test_lengths_and_shares_become_metres(tmp_path):
    wanted = _read(tmp_path, GOOD)
    assert wanted.nominal_radius == pytest.approx(6 * 0.0254)
    assert wanted.budget == pytest.approx(0.01 * 6 * 0.0254)
    assert wanted.smallest_wanted == pytest.approx(5 * 0.0254)
    assert wanted.noise.length.at(wanted.nominal_radius) == pytest.approx(1e-4)
    nominal = GOOD.replace('radius = ["5 in", "7 in"]', 'nominal_radius = "150 mm"\ntolerance = "10 %"')
    nominal = _read(tmp_path, nominal.replace('"5 %"', '"20 %"'))
    assert nominal.radii == pytest.approx((0.135, 0.165))
    assert nominal.smallest_wanted == pytest.approx(0.12)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('u95 = "1 %"', "u95 = 0.01", "requirement.u95 = 0.01 is wrong: it must be a length"),
        ('u95 = "1 %"', 'u95 = "-1 %"', "it must be greater than 0"),
        ('u95 = "1 %"', 'u95 = "1 kg"', "is not a length"),
        ('deflection = "5 %"', "deflection = 5", "it must be text in per cent"),
        ('deflection = "5 %"', 'deflection = "five %"', "one number with a decimal point and the sign %"),
        ('deflection = "5 %"', 'deflection = "120 %"', "less than 1"),
        ('["5 in", "7 in"]', '["7 in", "5 in"]', "the least first"),
        ('radius = ["5 in", "7 in"]', 'tolerance = "5 %"', "either radius"),
        ('diameter = "8 in"', 'diameter = "8 m"', "does not pass a pipe of radius 0.1778 m"),
        ("stripe = 0.5", "stripe = -1", "noise.stripe = -1 is wrong"),
        ('["perspective"]', '["pinhole"]', "perspective"),
        ('["perspective"]', '["perspective"]\nk = [500.0]\nk_range = [1.0, 2.0]', "k and k_range say the same thing"),
        ('["perspective"]', '["perspective"]\nk_range = [2.0, 1.0]', "k_range must be"),
        (
            '["perspective"]',
            '["perspective"]\nfocal = 3',
            "camera[0].focal is not known; allowed here: body_diameter",
        ),
        ("[noise]", "[search]\nsteps = 1\n[noise]", "search.steps = 1 is wrong"),
        ("[noise]", '[search]\nconfigurations = ["cube"]\n[noise]', "perpendicular-plane"),
        ("width = 1920", 'width = "1920"', "a whole number without quotes"),
        ('length = "50 mm"\n', "", "key laser.length is missing; add it"),
    ],
)
def test_a_mistake_is_told_in_one_sentence_with_file_and_key(tmp_path, old, new, said):
    assert old in GOOD
    with pytest.raises(InputError) as error:
        _read(tmp_path, GOOD.replace(old, new, 1))
    sentence = str(error.value)
    assert said in sentence
    assert sentence.startswith(str(tmp_path / "spec.toml"))
    assert sentence.endswith((".", ".)"))
    assert "\n" not in sentence


def test_two_cameras_of_one_name_are_refused(tmp_path):
    twice = GOOD + GOOD[GOOD.index("[[camera]]") :]
    with pytest.raises(InputError, match='"HD" is given to two cameras'):
        _read(tmp_path, twice)
