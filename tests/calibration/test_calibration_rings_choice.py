"""Which lens ring marks speak for, what they cannot tell, and what disturbs them."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from calibration_ring_marks import LAWS, Noise, exact_marks, noisy

from calibore.calibration._in_words import Unit
from calibore.calibration._lens_models import LensModel
from calibore.calibration._rings._calibrate import evaluated
from calibore.calibration._rings._model import Printed
from calibore.calibration._rings._result import comparisons
from calibore.calibration._rings._sight import Sight
from calibore.calibration._rings._target import RingTarget
from calibore.calibration._rings._words import check, findings, warnings
from calibore.errors import InputError
from calibore.optics import LENS_LAWS

INCH = 0.0254
RADII = INCH * np.arange(1, 10)
SIZE = (1024, 768)
NOISE = Noise(0.02, 0.2, 0.001)


def _sight(law, distances, *, noise=NOISE, errors=0.0, extras=(), seed=1, **known):
    """Marks on a target of nine rings that fills the image from the first of the `distances` [in]; and the true k."""
    rng = np.random.default_rng(seed)
    k = 350 / LENS_LAWS[law].ratio(np.arctan(RADII[-1] / INCH / distances[0]))
    values = {"camera.k": k, **dict(zip(("camera.c1", "camera.c2"), extras, strict=False))}
    camera = LensModel(law, ("c1", "c2") if extras else ()).camera(values, width=SIZE[0], height=SIZE[1])
    targets = [RingTarget(distance * INCH, 0.01, -0.02, 0.001, 0.002, 0.3) for distance in distances]
    marks = tuple(noisy(exact_marks(camera, target, RADII + errors, per_ring=240), noise, rng) for target in targets)
    return Sight(Printed(RADII, 8), marks, SIZE, distances[0] * 0.9 * INCH, **known), k


@lru_cache
def _plain(*distances):
    """What good marks of an equidistant lens give, and its true k."""
    sight, k = _sight("equidistant", distances)
    return evaluated(sight, "equidistant"), k


def _pictures(sight):
    """What sentences say of the pictures."""
    target = SimpleNamespace(rings=RADII.size, spokes=8)
    files = tuple(SimpleNamespace(name=f"rings {i}.png", refused="") for i in range(len(sight.marks)))
    return SimpleNamespace(
        toml="target.toml",
        target=target,
        radii=RADII,
        unit=Unit("in", INCH),
        files=files,
        used=tuple(range(len(files))),
        marks=sight.marks,
    )


@pytest.mark.parametrize("law", LAWS)
def test_the_law_that_made_the_marks_is_recommended_with_its_distance_and_scale(law):
    sight, k = _sight(law, [7.0])
    found = evaluated(sight)
    assert found.chosen.lens == LensModel(law)
    distance, scale = found.value("laser.baseline"), found.value("camera.k")
    # 9 rings and 8 spokes tell few degrees of freedom: 3.5 u are 99 %
    assert abs(distance.value - 7.0 * INCH) < 3.5 * distance.u < 1e-3 * distance.value
    assert abs(scale.value - k) < 3.5 * scale.u < 1e-3 * k
    check(found, _pictures(sight))
    table = {row.model: row for row in comparisons(found, [trial.lens for trial in found.trials])}
    assert table["perspective"].remark.startswith("tells D / k only")
    assert table[law].remark == "recommended"
    assert table[law].aicc < table["perspective"].aicc - 100
    said = " ".join(findings(found, _pictures(sight)))
    assert said.startswith(f"Recommended lens: {law}, the simplest (1 parameter)")


def test_a_lens_with_residual_distortion_is_not_taken_for_a_pure_law():
    sight, _ = _sight("equidistant", [6.0, 9.0], extras=(0.03, -0.02))
    found = evaluated(sight, "equidistant")
    assert found.chosen.lens.extras == ("c1", "c2")


def test_of_a_perspective_lens_rings_tell_the_ratio_of_distance_and_scale_only():
    sight, k = _sight("perspective", [6.0])
    found = evaluated(sight, "perspective")
    assert found.value("laser.baseline").u > 0.1 * 6 * INCH
    ratio = found.value("laser.baseline").value / found.value("camera.k").value
    assert abs(ratio / (6 * INCH / k) - 1) < 1e-3
    with pytest.raises(InputError, match=r"rings tell D / k only \(0\.\d+ in/px\).*chessboard"):
        check(found, _pictures(sight))


def test_a_view_too_narrow_to_tell_distance_from_scale_is_refused_with_a_cure():
    sight, _ = _sight("sine-law", [100.0], noise=Noise(0.5, 0.2, 0.3))
    with pytest.raises(
        InputError, match=r"rings cover zenith 0-6 deg only; photograph the target from nearer than 4.5 in"
    ):
        check(evaluated(sight, "sine-law"), _pictures(sight))


def test_a_narrow_view_is_warned_of_with_the_correlation():
    sight, _ = _sight("sine-law", [30.0])
    found = evaluated(sight, "sine-law")
    check(found, _pictures(sight))
    assert any("correlation 0.99" in sentence for sentence in warnings(found, _pictures(sight)))


def test_laws_that_the_marks_do_not_rule_out_widen_the_uncertainty():
    sight, _ = _sight("sine-law", [40.0], noise=Noise(0.05, 0.2, 0.02))
    known, unknown = evaluated(sight, "sine-law"), evaluated(sight)
    assert unknown.rivals
    assert unknown.value("laser.baseline").u > 2 * known.value("laser.baseline").u
    assert any("do not rule out other lens laws" in sentence for sentence in warnings(unknown, _pictures(sight)))


def test_it_does_not_matter_whether_the_target_is_mirrored_or_turned():
    sight, _ = _sight("equidistant", [6.0])
    marks = sight.marks[0]
    mirrored = replace(
        marks,
        u=SIZE[0] - 1 - marks.u,
        direction=marks.direction * [-1, 1],
        spoke=np.where(marks.ring == 0, (-marks.spoke) % 8, -1),
        centre=(SIZE[0] - 1 - marks.centre[0], marks.centre[1]),
    )
    turned = replace(marks, spoke=np.where(marks.ring == 0, (marks.spoke + 3) % 8, -1))
    plain, _ = _plain(6.0)
    for other in (mirrored, turned):
        found = evaluated(replace(sight, marks=(other,)), "equidistant")
        for name in ("camera.k", "laser.baseline"):
            # the same marks; which of them begins a stretch may differ
            assert abs(found.value(name).value - plain.value(name).value) < 0.5 * plain.value(name).u


def test_marks_on_dirt_are_left_out():
    sight, k = _sight("equidistant", [6.0])
    marks, rng = sight.marks[0], np.random.default_rng(7)
    dirty = rng.random(marks.u.size) < 0.03
    stain = (marks.ring == 4) & (np.arctan2(marks.v - marks.centre[1], marks.u - marks.centre[0]) > 2.8)
    aside = np.where(dirty, rng.normal(0, 2, dirty.size), 0.0) + 0.5 * stain
    moved = replace(marks, u=marks.u + aside * marks.direction[:, 0], v=marks.v + aside * marks.direction[:, 1])
    found = evaluated(replace(sight, marks=(moved,)), "equidistant")
    assert (found.ring_fit.fit.weights == 0).any()
    assert abs(found.value("camera.k").value - k) < 3.5 * found.value("camera.k").u < 1e-3 * k


def test_several_pictures_tell_more_than_one():
    alone, _ = _plain(6.0)
    together, k = _plain(6.0, 9.0)
    assert together.value("camera.k").u < alone.value("camera.k").u
    assert abs(together.value("camera.k").value - k) < 3.5 * together.value("camera.k").u
    assert abs(together.ring_fit.fit.value("target.1.baseline") - 9 * INCH) < 3.5 * together.ring_fit.u(
        "target.1.baseline"
    )


def test_errors_of_the_print_are_told_from_errors_of_the_picture_and_widen_the_uncertainty():
    errors = np.random.default_rng(8).normal(0, 2e-4, RADII.size)
    plain, k = _plain(6.0, 9.0)
    printed, _ = _sight("equidistant", [6.0, 9.0], errors=errors)
    stated = replace(printed, u_ring=2e-4)
    told, known = (evaluated(sight, "equidistant") for sight in (printed, stated))
    assert told.ring_fit.of_print
    # a standard deviation from nine rings, two parameters among them: 25 %
    assert 1e-4 < told.ring_fit.fit.group_sigma < 4e-4
    for found in (told, known):
        assert found.value("camera.k").u > 2 * plain.value("camera.k").u
        assert abs(found.value("camera.k").value - k) < 3.5 * found.value("camera.k").u
    assert "Measure the rings" in " ".join(findings(told, _pictures(printed)))


def test_rings_counted_wrongly_fit_no_lens():
    sight, _ = _sight("equidistant", [6.0])
    marks = sight.marks[0]
    shifted = replace(marks, ring=np.where(marks.ring > 0, marks.ring - 1, 0))
    rows = (marks.ring != 1) | (shifted.ring > 0)
    kept = {name: getattr(shifted, name)[rows] for name in ("u", "v", "direction", "sigma", "ring", "spoke")}
    with pytest.raises(InputError, match=r"no lens model describes the rings.*Check that the target has 9"):
        check(evaluated(replace(sight, marks=(replace(shifted, **kept),)), "equidistant"), _pictures(sight))
