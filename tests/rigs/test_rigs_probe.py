"""A probe as a file says it, and what its uncertainty means for a radius."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.rigs import Probe, read_probe
from calibore.uncertainty import Covariance

NAMES = ("probe.slope", "probe.intercept")
FILE = """format = "calibore-rig/1"
configuration = "tactile-probe"
[probe]
slope = "5.2405 in"
intercept = "4.5706 in"
noise = "0.0005 in"
[calibration]
parameters = ["probe.intercept", "probe.slope"]
covariance = [[4e-10, 1e-10], [1e-10, 2e-10]]
degrees_of_freedom = 31
evidence = "probe.zarr"
"""


def file_of(tmp_path, text):
    path = tmp_path / "probe.toml"
    path.write_text(text)
    return path


def test_a_file_is_read_whatever_the_order_of_its_parameters(tmp_path):
    probe = read_probe(file_of(tmp_path, FILE))
    assert probe.slope == pytest.approx(5.2405 * 0.0254)
    assert probe.noise == pytest.approx(0.0005 * 0.0254)
    assert probe.degrees_of_freedom == 31
    np.testing.assert_allclose(probe.covariance.matrix, [[2e-10, 1e-10], [1e-10, 4e-10]])


def test_the_published_conversion_is_8_2(tmp_path):
    probe = read_probe(file_of(tmp_path, FILE.split("[calibration]")[0]))
    np.testing.assert_allclose(probe.radius([0.0, 0.2, 0.5]) / 0.0254, [4.5706, 5.6187, 7.19085])
    assert not probe.u_common(0.2).any()


def test_the_uncertainty_of_a_radius_is_that_of_drawn_probes():
    rng = np.random.default_rng(0)
    known = Covariance(NAMES, [[2e-10, -5e-11], [-5e-11, 3e-10]])
    probe, ratio = Probe(0.133, 0.116, known), np.linspace(0, 0.7, 5)
    drawn = known.draw(rng, 20000)
    scatter = (drawn @ probe.sensitivities(ratio).T).std(axis=0)
    np.testing.assert_allclose(probe.u_common(ratio), scatter, rtol=0.02)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ('slope = "5.2405 in"', "slope = 5.2405\n"),
        ('slope = "5.2405 in"', 'slope = "0 in"\n'),
        ('parameters = ["probe.intercept", "probe.slope"]', 'parameters = ["probe.intercept", "probe.gain"]\n'),
        ("covariance = [[4e-10, 1e-10], [1e-10, 2e-10]]", "covariance = [[4e-10, 1e-10]]\n"),
        ('configuration = "tactile-probe"', 'configuration = "side-facing"\n'),
        ("[probe]", "[prob]\n"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path, wrong, said):
    with pytest.raises(InputError, match=r"probe\.toml"):
        read_probe(file_of(tmp_path, FILE.replace(wrong, said)))


def test_a_probe_needs_a_slope_a_noise_and_its_own_covariance():
    known = Covariance(NAMES, np.eye(2))
    for bad in ({"slope": 0.0}, {"noise": -1.0}, {"covariance": Covariance(NAMES[::-1], np.eye(2))}):
        with pytest.raises(InputError):
            Probe(**{"slope": 0.1, "intercept": 0.1, "covariance": known, **bad})


def test_the_modes_hold_slope_and_intercept_and_a_bend_that_vanishes_at_the_anchor():
    rng = np.random.default_rng(1)
    root = rng.normal(size=(2, 2)) * 1e-5
    probe = Probe(0.133, 0.116, Covariance(NAMES, root @ root.T), linearity=2e-5, stroke=(0.05, 0.65))
    ratio = rng.uniform(0, 0.7, 40)
    by_both = probe.sensitivities(ratio)
    modes = probe.common_modes(ratio)
    np.testing.assert_allclose(modes[:, :2] @ modes[:, :2].T, by_both @ root @ root.T @ by_both.T, atol=1e-18)
    assert probe.common_modes(probe.anchor)[1:] == pytest.approx([0, 0], abs=1e-18)
    ends = probe.common_modes([0.05, 0.35, 0.65])[:, 2]
    assert ends[0] - ends[1] == pytest.approx(1.5 * 2e-5)
