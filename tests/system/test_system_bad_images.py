"""What there is to read is not what a scan needs: it is told so, and what can be measured is."""

import json
import re
import shutil

import numpy as np
import pytest
from command_line import calibore, profile
from PIL import Image
from spoilt import DONE, PARTLY, PICTURE, images, nothing_was_written, refused, replace

from calibore.scans import read_rings
from calibore.simulation import Sensor


def test_a_scan_that_does_not_exist_is_named(tmp_path):
    refused(profile(tmp_path / "nowhere"), str(tmp_path / "nowhere"), "does not exist", "give a scan folder")


def test_an_empty_folder_is_told_to_need_a_scan_file(tmp_path):
    (tmp_path / "empty").mkdir()
    refused(profile(tmp_path / "empty"), str(tmp_path / "empty"), "has no scan.toml", "give a folder that holds one")


def test_a_picture_given_as_scan_is_told_to_be_no_text(scan):
    refused(profile(images(scan)[0]), PICTURE.format(0), "not UTF-8 text", "give a TOML file")


def test_a_name_too_long_for_the_system_is_no_crash(tmp_path):
    refused(profile(tmp_path / ("x" * 300)), "xxx", "too long", "check that path")


def test_a_folder_without_images_is_told_the_pattern_and_what_is_there(scan):
    for image in images(scan):
        image.unlink()
    refused(profile(scan), str(scan), "pipe {station:03d} {take}.png", '"rig.toml"', "Write the pattern as")
    assert nothing_was_written(scan)


def test_images_of_another_name_are_told_the_pattern_and_one_of_their_names(scan):
    for image in images(scan):
        image.rename(image.with_name(image.name.replace("pipe", "tube")))
    refused(profile(scan), "pipe {station:03d} {take}.png", '"tube 000 0.png"', "Write the pattern as")


# Images


SPOILT_FILES = {
    "truncated": (lambda whole: whole[:2000], "truncated"),
    "empty": (lambda whole: b"", "empty (0 bytes)"),
    "text": (lambda whole: b"this is no picture", "not a PNG, JPEG, TIFF, BMP, PGM or PPM"),
    "header only": (lambda whole: whole[:30], "truncated"),
    "bits flipped": (lambda whole: whole[:1000] + bytes(255 - b for b in whole[1000:1100]) + whole[1100:], "corrupt"),
}


@pytest.mark.parametrize("spoil", SPOILT_FILES.values(), ids=SPOILT_FILES.keys())
def test_one_spoilt_image_is_skipped_counted_and_named_and_the_others_are_measured(scan, spoil):
    change, why = spoil
    image = images(scan)[1]
    replace(image, change(image.read_bytes()))
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert outcome.out.startswith("3 stations from 3 images")
    assert outcome.err.startswith(f"Warning: 1 image could not be used: {image.name} (")
    assert why in outcome.err
    assert "copy or save it again, or remove it" in outcome.err
    assert outcome.err.count("\n") == 1
    assert read_rings(scan.parent / "out")["station"].tolist() == [0, 2, 3]
    summary = json.loads((scan.parent / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["counts"] | {"stations": 3, "images": 3, "refused_images": 1} == summary["counts"]
    assert [one["image"] for one in summary["skipped"]] == [image.name]


@pytest.mark.parametrize("spoil", SPOILT_FILES.values(), ids=SPOILT_FILES.keys())
def test_where_every_image_is_spoilt_nothing_is_written_and_the_first_is_named(scan, spoil):
    change, why = spoil
    for image in images(scan):
        replace(image, change(image.read_bytes()))
    refused(profile(scan), str(scan), "none of its 4 images", PICTURE.format(0), why, "copy or save it again")
    assert nothing_was_written(scan)


def flat(value: int) -> np.ndarray:
    return np.full((240, 320, 3), value, np.uint8)


def noise() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 256, (240, 320, 3), dtype=np.uint8)


def sensor_noise() -> np.ndarray:
    """What the camera sees with the laser off."""
    return np.asarray(Sensor().read_out(np.zeros((240, 320, 3)), np.random.default_rng(2)))


def lamp(colour: tuple[float, float, float] = (1.0, 0.9, 0.8)) -> np.ndarray:
    """A lamp's blob where the ring would be."""
    row, column = np.mgrid[:240, :320]
    blob = 400 * np.exp(-((column - 225) ** 2 + (row - 100) ** 2) / (2 * 15**2))
    return np.clip(blob[..., np.newaxis] * colour + sensor_noise(), 0, 255).astype(np.uint8)


WITHOUT_RING = {
    "black": (flat(0), "every red value is 0 of 255"),
    "grey": (flat(90), "every red value is 90 of 255"),
    "saturated": (flat(255), "every red value is 255 of 255"),
    "noise": (noise(), "red values 0 to 255 of 255"),
    "laser off": (sensor_noise(), "of 255"),
    "white lamp": (lamp(), "to 255 of 255"),
    "red lamp": (lamp((1.0, 0.1, 0.1)), "to 255 of 255"),
}


@pytest.mark.parametrize("picture", WITHOUT_RING.values(), ids=WITHOUT_RING.keys())
def test_pictures_without_a_ring_are_told_so_with_their_brightness_and_what_to_check(scan, picture):
    pixels, brightness = picture
    for image in images(scan):
        replace(image, pixels)
    sentence = refused(profile(scan), "none of its 4 images", PICTURE.format(0), "no laser ring", brightness)
    assert "check exposure, laser.channel and pipe.nominal_radius" in sentence
    assert re.search(r"looked for \d+ to \d+ px from column 160, row 120", sentence)
    assert nothing_was_written(scan)


@pytest.mark.parametrize("picture", WITHOUT_RING.values(), ids=WITHOUT_RING.keys())
def test_one_picture_without_a_ring_costs_only_its_station(scan, picture):
    pixels, brightness = picture
    replace(images(scan)[2], pixels)
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert f"1 image could not be used: {PICTURE.format(2)} (there is no laser ring" in outcome.err
    assert brightness in outcome.err
    assert read_rings(scan.parent / "out")["station"].tolist() == [0, 1, 3]


def test_images_of_another_size_than_the_rigs_are_told_both_sizes(scan):
    for image in images(scan):
        replace(image, np.zeros((100, 120, 3), np.uint8))
    refused(profile(scan), PICTURE.format(0), "120 x 100 px", "320 x 240 px", "use the rig file of the camera")


def test_one_image_of_another_size_is_skipped_and_named(scan):
    replace(images(scan)[3], np.zeros((480, 640, 3), np.uint8))
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert f"{PICTURE.format(3)} (it is 640 x 480 px but the rig's camera has 320 x 240 px" in outcome.err


def test_images_refused_for_one_reason_are_named_together(scan):
    for image in images(scan)[1:]:
        replace(image, b"")
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert "3 images could not be used: pipe 001 0.png, pipe 002 0.png, pipe 003 0.png (it is empty" in outcome.err


@pytest.mark.parametrize("options", [("--pictures",), ("--no-pictures", "--json")], ids=" ".join)
def test_a_line_seen_on_a_third_of_the_ring_is_measured_but_not_judged(scan, options):
    row, column = np.mgrid[:240, :320]
    hidden = np.mod(np.degrees(np.arctan2(column - 160, 120 - row)), 360) > 120
    for image in images(scan):
        pixels = np.array(Image.open(image))
        pixels[hidden] = 3
        replace(image, pixels)
    outcome = calibore("profile", scan, "--out", scan.parent / "out", *options)
    assert outcome.status == DONE
    assert "Less than 50 % of the ring was measured at 4 stations: 0, 1, 2, 3." in outcome.err
    if "--json" in options:
        summary = json.loads(outcome.out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
        assert summary["worst_stations"][0]["deflection_percent"] is None
    else:
        assert "nan" not in outcome.out
        assert (scan.parent / "out" / "report.html").exists()


def test_with_json_the_warnings_go_to_standard_error_and_the_result_stays_machine_readable(scan):
    replace(images(scan)[0], b"")
    outcome = profile(scan, "--json")
    assert outcome.status == PARTLY
    summary = json.loads(outcome.out)
    assert summary["counts"]["refused_images"] == 1
    assert summary["skipped"][0]["image"] == PICTURE.format(0)
    assert PICTURE.format(0) in outcome.err


def test_with_json_a_failure_leaves_standard_output_empty(scan):
    for image in images(scan):
        replace(image, b"")
    refused(profile(scan, "--json"), PICTURE.format(0))


def test_a_folder_named_like_an_image_is_no_image(scan):
    image = images(scan)[1]
    image.unlink()
    image.mkdir()
    outcome = profile(scan)
    assert outcome.status == DONE
    assert outcome.out.startswith("3 stations from 3 images")


def test_a_missing_station_in_a_regular_numbering_is_mentioned_and_no_failure(scan):
    for number in range(4, 8):
        shutil.copy(images(scan)[0], scan / PICTURE.format(number))
    images(scan)[5].unlink()
    outcome = profile(scan)
    assert outcome.status == DONE
    assert "1 station without an image, but the numbering of the others has gaps there: 5." in outcome.err


def test_an_unreadable_image_is_not_also_a_missing_station(scan):
    for number in range(4, 8):
        shutil.copy(images(scan)[0], scan / PICTURE.format(number))
    replace(images(scan)[5], b"")
    outcome = profile(scan)
    assert outcome.status == PARTLY
    assert "without an image" not in outcome.err
