"""The lines of a station are the same whether its pictures are read and measured in one call or in two steps."""

from dataclasses import fields, replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from calibore.images import ImageFolder, StationImages, read_image
from calibore.profiling import Job, Tally, prepare
from calibore.profiling._side._job import prepare_side
from calibore.profiling._side._stop import find_stop_lines
from calibore.profiling._side._survey import _stops
from calibore.profiling._station import find_lines
from calibore.scans import read_scan
from calibore.stripe import Stripe

SIMULATED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"


def survey(name: str) -> Path:
    if not (SIMULATED / name).is_dir():
        pytest.skip(f"simulated data are not at {SIMULATED / name}")
    return SIMULATED / name


def in_two_steps(images: StationImages) -> StationImages:
    return replace(images, files=())


def assert_same(ours: Stripe, theirs: Stripe) -> None:
    for field in fields(Stripe):
        one, other = getattr(ours, field.name), getattr(theirs, field.name)
        same = np.array_equal(one, other, equal_nan=True) if isinstance(one, np.ndarray) else one == other
        assert same, field.name


@pytest.mark.parametrize("name", ["plane-12in", "cone-dual", "field"])
def test_a_station_has_the_same_lines_in_one_call_and_in_two_steps(name: str) -> None:
    job, source, _ = prepare(read_scan(survey(name)), estimator="zero-crossing")
    count = 0
    for images, _ in zip(source.stations(), range(3), strict=False):
        assert len(images.files) == len(images.takes)
        found, expected = find_lines(images, job), find_lines(in_two_steps(images), job)
        assert (found.refused, found.unlit) == (expected.refused, expected.unlit)
        for ours, theirs in zip(found.lines, expected.lines, strict=True):
            assert (ours.take, ours.laser) == (theirs.take, theirs.laser)
            assert_same(ours.stripe, theirs.stripe)
        count += len(found.lines)
    assert count >= 2


def test_a_stop_of_a_side_facing_head_has_the_same_line_in_one_call_and_in_two_steps() -> None:
    job, source, place = prepare_side(read_scan(survey("side-2.4in")), estimator="zero-crossing")
    for stop in _stops(source, place, job, Tally())[:3]:
        found = find_stop_lines(stop, job)
        expected = find_stop_lines(replace(stop, images=in_two_steps(stop.images)), job)
        assert (found.refused, found.unlit) == (expected.refused, expected.unlit)
        assert len(found.lines) == len(expected.lines) > 0
        for (take, ours), (same_take, theirs) in zip(found.lines, expected.lines, strict=True):
            assert take == same_take
            assert_same(ours, theirs)


@pytest.fixture
def unusable(tmp_path: Path) -> ImageFolder:
    """A usable picture, one of another size, one without a ring, one cut short, one of no bytes."""
    path = next(survey("plane-12in").glob("*.png"))
    pixels = read_image(path)
    contents = {
        "0 0": path.read_bytes(),
        "0 1": cv2.imencode(".png", pixels[:-1])[1].tobytes(),
        "0 2": cv2.imencode(".png", np.full_like(pixels, 7))[1].tobytes(),
        "0 3": path.read_bytes()[:-5000],
        "0 4": b"",
    }
    for name, content in contents.items():
        (tmp_path / f"{name}.png").write_bytes(content)
    return ImageFolder(tmp_path, "{station} {take}.png")


def test_an_unusable_picture_is_refused_for_the_same_reason_in_one_call_and_in_two_steps(unusable: ImageFolder) -> None:
    job: Job = prepare(read_scan(survey("plane-12in")), estimator="zero-crossing")[0]
    (images,) = unusable.stations()
    found, expected = find_lines(images, job), find_lines(in_two_steps(images), job)
    assert [line.take for line in found.lines] == [0]
    assert len(found.refused) == 4
    assert found.refused == expected.refused
    for image, why in zip(found.refused, ["1024 x 767", "every red value is 7", "truncated", "empty"], strict=True):
        assert why in image.reason
