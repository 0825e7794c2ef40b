"""How well each estimator finds the place of a Gaussian line."""

import numpy as np
import pytest
from stripe_scenes import BACKGROUND, cramer_rao, line_image

from calibore.errors import UsageError
from calibore.status import Status
from calibore.stripe import detect_line, estimator_named

NAMES = ("zero-crossing", "parabola", "maximum", "threshold", "centroid", "correlation", "steger")


def rms(name: str, *, peak: float, seed: int) -> float:
    image, row = line_image(np.random.default_rng(seed), peak=peak)
    error = detect_line(image, estimator=name).v - row
    assert np.isfinite(error[10:-10]).mean() > 0.999  # at the edge some have too little to go by
    return float(np.sqrt(np.nanmean(error**2)))


@pytest.mark.parametrize("peak", [150.0, 175.0, 200.0])
def test_the_default_reaches_the_cramer_rao_bound(peak: float) -> None:
    _, row = line_image(np.random.default_rng(0), peak=peak)
    bound = cramer_rao(row, width=2.0, peak=peak)
    # 3000 columns: the rms itself scatters by 1.3 %, three of that below; anchors.md asks for 1.10 above
    assert 0.96 < rms("zero-crossing", peak=peak, seed=int(peak)) / bound < 1.10


def test_the_estimators_rank_as_in_the_literature() -> None:
    _, row = line_image(np.random.default_rng(0))
    bound = cramer_rao(row, width=2.0, peak=175.0)
    found = {name: rms(name, peak=175.0, seed=3) / bound for name in NAMES}
    assert max(found, key=lambda name: found[name]) == "maximum"
    assert min(found, key=lambda name: found[name]) == "steger"
    assert 0.4 < found["steger"] < 0.6  # it sees the neighbouring columns too: the bound is that of one column
    assert min(set(NAMES) - {"steger"}, key=lambda name: found[name]) in ("zero-crossing", "correlation")
    assert 10 < found["maximum"] < 40  # anchors.md: 20
    assert 3 < found["parabola"] < 8  # 5.4, pixel locking
    assert found["threshold"] < 2.5  # 1.7
    assert found["centroid"] < 2.5  # 1.2 to 1.3
    assert found["correlation"] < 1.3  # 1.15


@pytest.mark.parametrize("name", NAMES)
def test_no_estimator_is_biased(name: str) -> None:
    image, row = line_image(np.random.default_rng(8))
    error = detect_line(image, estimator=name).v - row
    assert abs(np.nanmean(error)) < 4 * np.nanstd(error) / np.sqrt(row.size) + 0.005


def test_parabola_is_the_vertex_through_eight_samples() -> None:
    rng = np.random.default_rng(5)
    image, _ = line_image(rng, columns=200)
    stripe = detect_line(image, estimator="parabola")
    lever = np.arange(8) - 3.5
    for column in range(200):
        samples = image[:, column].astype(float)
        vertices = []
        for first in range(samples.size - 8):
            bend, slope, _ = np.polyfit(lever, samples[first : first + 8], 2)
            if bend < 0 and abs(slope / (2 * bend)) <= 0.6 and samples[first + 3 : first + 5].max() > 90:
                vertices.append(first + 3.5 - slope / (2 * bend))
        assert np.min(np.abs(np.array(vertices) - stripe.v[column])) < 1e-6


def test_the_published_threshold_is_45_grey_values() -> None:
    rng = np.random.default_rng(6)
    below, _ = line_image(rng, columns=300, peak=28.0)
    above, _ = line_image(rng, columns=300, peak=52.0)
    assert below.max() < 45
    assert above.max() > 45 + BACKGROUND
    assert np.all(detect_line(below, estimator="parabola").status == Status.NO_PEAK)
    assert detect_line(above, estimator="parabola").found.all()
    assert detect_line(below).found.all(), "the default asks for prominence, not for absolute brightness"


def test_an_unknown_estimator_is_named_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match='"best".*' + ", ".join(NAMES)):
        estimator_named("best")
    with pytest.raises(UsageError):
        estimator_named("crossing")
