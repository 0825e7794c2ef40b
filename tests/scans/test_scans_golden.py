"""Results written by earlier versions still open (tests/golden/v1, written by version 0.1.0)."""

from pathlib import Path

import numpy as np
from tiny_survey import ring, row

from calibore.scans import open_profile, read_rings

GOLDEN = Path(__file__).parents[1] / "golden" / "v1"


def test_a_profile_written_by_version_0_1_still_opens():
    profile = open_profile(GOLDEN)
    assert profile.sizes == {"station": 3, "clock": 8, "mode": 2}
    rings = [ring(station)[0] for station in range(3)]
    for name in ("radius", "u_common", "status"):
        np.testing.assert_allclose(profile[name], [getattr(r, name) for r in rings], rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(profile["axial"], [0, 0.1, 0.2], rtol=1e-12)


def test_its_ring_table_still_opens():
    rings = read_rings(GOLDEN)
    np.testing.assert_allclose(rings["mean_diameter"], [row(ring(s)[0])["mean_diameter"] for s in range(3)], rtol=1e-12)
