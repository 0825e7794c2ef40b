"""Every configuration is data: what is written as a rig file is read back as the same rig."""

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.lasers import Beam, Cone, Plane, Sheet
from calibore.optics import Camera, FlatPort, Lens
from calibore.rigs import CONFIGURATIONS, FORWARD, Laser, Rig, SideFacing, read_rig, write_rig
from calibore.uncertainty import Covariance

CAMERA = Camera(640, 480, Lens("equisolid-angle", 400.0, 240.0, c1=0.01), (319.0, 241.5), 1.01)
LASERS = {
    Plane: [Laser(Plane(0.3, 0.01, -0.02), "red")],
    Cone: [Laser(Cone(0.08, 0.2, 0.44), None, (1,)), Laser(Cone(0.07, 0.1, 0.5, 1.5), "green", (2, 3))],
    Sheet: [Laser(Sheet(1e-4, 0.001, -0.002))],
    Beam: [Laser(Beam(0.01, 0.02, 0.03, 0.7, clock)) for clock in (0.0, 2.0, 4.0)],
}


def rig_of(name):
    configuration = CONFIGURATIONS[name]
    count = 3 if name == "spot-array" else configuration.lasers[0]
    lasers = LASERS[configuration.surface][:count]
    if configuration.fixed and configuration.surface is Cone:
        fixed = dict(configuration.fixed)
        angle = 2.4 if configuration.reversed else 0.5
        lasers = [Laser(Cone(**{"baseline": 0.08, "half_angle": angle, "offset": 0.25, **fixed}))]
    return Rig(name, CAMERA, tuple(lasers), mount=SideFacing(0.06, 0.35) if configuration.side_facing else FORWARD)


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_a_rig_that_is_written_is_read_back_the_same(name, tmp_path):
    rig = rig_of(name).with_default_uncertainty(0.15)
    write_rig(rig, tmp_path / "rig.toml")
    again = read_rig(tmp_path / "rig.toml")
    assert (again.configuration, again.camera, again.mount) == (rig.configuration, rig.camera, rig.mount)
    for ours, theirs in zip(rig.lasers, again.lasers, strict=True):
        assert (ours.channel, ours.takes) == (theirs.channel, theirs.takes)
        values = [[getattr(s, n) for n in s.parameter_names] for s in (ours.surface, theirs.surface)]
        assert np.allclose(*values, rtol=1e-13, atol=0)
    written = again.covariance.restricted(rig.covariance.names)
    assert np.allclose(written.matrix, rig.covariance.matrix, rtol=1e-12, atol=0)


def test_distributions_freedom_and_port_survive_the_file(tmp_path):
    camera = Camera(
        640, 480, CAMERA.lens, (319.0, 241.5), pupil_walk=(1e-3, -2e-4), port=FlatPort(3e-3, 1.52, 0.01, 1.33)
    )
    covariance = Covariance.independent(
        {"laser.baseline": 1e-4, "camera.k": 0.5, "camera.principal_point_u": 0.1, "camera.principal_point_v": 0.1},
        distributions={"laser.baseline": "rectangular"},
        degrees_of_freedom={"camera.k": 9.0},
    )
    rig = Rig("perpendicular-plane", camera, (Laser(Plane(0.3)),), covariance=covariance, stripe=0.2)
    write_rig(rig, tmp_path / "rig.toml")
    again = read_rig(tmp_path / "rig.toml")
    assert again.camera == camera
    assert again.stripe == 0.2
    assert again.covariance.names == covariance.names
    assert again.covariance.distributions == covariance.distributions
    assert again.covariance.degrees_of_freedom == covariance.degrees_of_freedom
    assert np.allclose(again.covariance.matrix, covariance.matrix, rtol=1e-13, atol=0)


def test_limits_and_correlations_are_read_as_uncertainties(tmp_path):
    write_rig(rig_of("single-cone"), tmp_path / "rig.toml")
    with (tmp_path / "rig.toml").open("a") as file:
        file.write(
            '\n[uncertainty]\nbaseline = { limits = "0.3 mm" }\naim = "0.1 deg"\n'
            'half_angle = { limits = "0.2 deg", distribution = "triangular" }\n'
            'correlation = [{ between = ["laser.aim", "laser.half_angle"], coefficient = -0.5 }]\n'
        )
    covariance = read_rig(tmp_path / "rig.toml").covariance
    assert covariance.names == ("laser.baseline", "laser.aim", "laser.half_angle")
    assert np.allclose(covariance.u, [3e-4 / np.sqrt(3), np.radians(0.1), np.radians(0.2) / np.sqrt(6)])
    assert covariance.correlation("laser.aim", "laser.half_angle") == pytest.approx(-0.5)
    assert [str(d) for d in covariance.distributions] == ["rectangular", "normal", "triangular"]


def test_the_default_of_a_cone_comes_correlated_through_its_lengths():
    """Swanbom 2007, eqs. 3-46 to 3-51, with the correlation that (3-40) drops."""
    cone = Cone.for_ring(0.5, 2.0, 1.0)
    rig = Rig("single-cone", CAMERA, (Laser(cone),)).with_default_uncertainty(1.0)
    step = 1e-6
    moved = [
        [getattr(Cone.for_ring(0.5 + s * i, 2.0 + s * j, 1.0), n) for n in ("baseline", "aim", "half_angle")]
        for i, j in ((1, 0), (0, 1))
        for s in (step, -step)
    ]
    jacobian = np.stack([np.subtract(moved[0], moved[1]), np.subtract(moved[2], moved[3])], axis=1) / (2 * step)
    assert rig.covariance.names == ("laser.baseline", "laser.aim", "laser.half_angle")
    assert np.allclose(rig.covariance.matrix, 1e-6 / 3 * jacobian @ jacobian.T, rtol=1e-6)


def test_a_reversed_cone_written_as_a_forward_one_is_told_what_to_write(tmp_path):
    write_rig(rig_of("reversed-cone"), tmp_path / "rig.toml")
    text = (tmp_path / "rig.toml").read_text().replace("2.4 rad", "40 deg")
    (tmp_path / "rig.toml").write_text(text)
    with pytest.raises(InputError, match=r"between 90 and 180 deg.*got 40 deg; write 140 deg"):
        read_rig(tmp_path / "rig.toml")
