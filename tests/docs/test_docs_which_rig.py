"""The page that decides for the reader says what the code predicts."""

from dataclasses import replace

import numpy as np
import pytest
from markdown_pages import ROOT

from calibore.design import (
    HONEST,
    KINDS,
    Study,
    measuring_limits,
    occlusion,
    predict_ring,
    ring_clocks,
    shadows,
)

PAGE = ROOT / "docs" / "explanation" / "which-rig.md"
RADIUS = 6 * 0.0254
INPUTS = replace(HONEST, u_pixel=0.3)
RIDGE = 0.02  # of the radius: 3 mm


def table():
    """Cells by configuration."""
    lines = [line.strip("|").split("|") for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:3] == "| `"]
    return {cells[0].strip(" `"): [cell.strip() for cell in cells[1:]] for cells in lines}


def study(kind, **changes):
    return Study(kind, RADIUS, maximum_radius=1.5, inputs=INPUTS, **changes)


def row(kind):
    design = study(kind)
    rig = design.rig()
    ring = predict_ring(rig, ring_clocks(rig), RADIUS, assumptions=INPUTS)
    good = ring.first_order
    u, common = 2e3 * ring.u_radius[good], 2e3 * ring.u_common[good]
    limits = measuring_limits(rig, nominal_radius=RADIUS, assumptions=INPUTS)
    flattest = min(float(np.nanmin([one.camera, one.light])) for one in occlusion(rig, nominal_radius=RADIUS))
    shadow = 1e3 * float(np.squeeze(shadows(rig, nominal_radius=RADIUS, heights=RIDGE * RADIUS).along))
    name = KINDS[kind].baseline_name.partition(":")[0]
    lengths = f"{name} {design.baseline:g}" + (f", projection {design.projection:g}" if design.projection else "")
    least = limits.everywhere[0]
    return [
        lengths,
        f"{u.min():.2g} to {u.max():.2g} mm",
        f"{common.max():.1g} mm",
        f"{100 * good.mean():.0f} %",
        "none" if np.isnan(least) else f"{1e3 * least:.0f} mm",
        f"{np.degrees(flattest):.0f}°",
        f"{shadow:.1f} mm",
    ]


def test_the_page_lists_every_kind_of_rig():
    assert list(table()) == list(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_the_table_of_rigs_says_what_the_code_predicts(kind):
    assert table()[kind] == row(kind)


def test_the_words_on_baselines_hold():
    u = {}
    for baseline in (0.5, 1.0, 2.0, 5.0):
        rig = study("perpendicular-plane", baseline=baseline).rig()
        u[baseline] = f"{2e3 * float(predict_ring(rig, 0.0, RADIUS, assumptions=INPUTS).u_radius):.2f}"
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert f"from {u[0.5]} to {u[1.0]} and {u[2.0]} mm" in text
    assert f"at five radii it is still {u[5.0]} mm" in text
    assert f"at {np.degrees(np.arctan(1 / 2)):.0f}°, at five at {np.degrees(np.arctan(1 / 5)):.0f}°" in text
