"""Folders of images: which file is which station, and what is said where that fails."""

import os
import pickle
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibore.errors import ImageError, InputError
from calibore.images import ImageFolder, NamePattern, image_size, read_image

NAMES = "plane12in {station:03d} {take}.png"


def write(path: Path, level: int = 0) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full((4, 6), level, np.uint8))


def listed(folder: ImageFolder) -> list[tuple[int, int, tuple[int, ...]]]:
    return [(images.station, images.angular, images.takes) for images in folder.stations()]


def test_only_what_is_there_is_listed_by_station_and_take(tmp_path: Path) -> None:
    for station, take in [(11, 1), (2, 0), (11, 0), (1234, 0), (33, 7)]:
        write(tmp_path / NAMES.format(station=station, take=take))
    for other in [
        "plane12in 5 0.png",
        "plane12in 0005 0.png",
        "plane12in abc 0.png",
        "plane12in 005 0.png.txt",
        "x.png",
    ]:
        (tmp_path / other).write_text("")
    (tmp_path / "plane12in 006 0.png").mkdir()
    folder = ImageFolder(tmp_path, NAMES)
    assert listed(folder) == [(2, 0, (0,)), (11, 0, (0, 1)), (33, 0, (7,)), (1234, 0, (0,))]
    assert folder.expected_stations == 4
    assert folder.refusals == ()


def test_every_station_hands_out_its_own_pixels(tmp_path: Path) -> None:
    for station in range(5):
        for take in range(2):
            write(tmp_path / NAMES.format(station=station, take=take), 10 * station + take)
    folder = ImageFolder(tmp_path, NAMES)
    handed_out = list(folder.stations())
    for images in handed_out:
        assert images.time_s is None
        for take in images.takes:
            assert (images.read(take) == 10 * images.station + take).all()
            assert np.array_equal(folder.read(images.station, take), images.read(take))


def test_what_another_machine_is_sent_of_a_station_does_not_grow_with_the_scan(tmp_path: Path) -> None:
    for number in range(300):
        write(tmp_path / f"{number:03d}.png")
        if number == 0:
            alone = next(ImageFolder(tmp_path, "{station:03d}.png").stations())
    among = next(ImageFolder(tmp_path, "{station:03d}.png").stations())
    assert len(pickle.dumps(among)) == len(pickle.dumps(alone))


def test_without_a_take_in_the_pattern_the_take_is_zero(tmp_path: Path) -> None:
    write(tmp_path / "ring7.bmp")
    assert listed(ImageFolder(tmp_path, "ring{station}.bmp")) == [(7, 0, (0,))]


def test_angular_stops_are_stations_of_their_own(tmp_path: Path) -> None:
    for station, angular, take in [(0, 0, 0), (0, 9, 0), (0, 9, 1), (1, 0, 0)]:
        write(tmp_path / f"side {station} {angular:03d} {take}.png", angular)
    folder = ImageFolder(tmp_path, "side {station} {angular:03d} {take}.png")
    assert listed(folder) == [(0, 0, (0,)), (0, 9, (0, 1)), (1, 0, (0,))]
    assert (folder.read(0, 1, angular=9) == 9).all()


@pytest.mark.parametrize(
    "pattern",
    [
        "a b/{station:02d} {take}.png",
        "run {station:02d}/take{take}.png",
        "x/y/{station:x}_{take}.png",
        "{{1}}/{station}-{take}.png",
    ],
)
def test_sub_folders_and_braces_in_the_pattern_are_followed(tmp_path: Path, pattern: str) -> None:
    for station in (0, 5, 77):
        write(tmp_path / pattern.format(station=station, take=1), station)
    write(tmp_path / "elsewhere" / "05 1.png")
    folder = ImageFolder(tmp_path, pattern)
    assert listed(folder) == [(0, 0, (1,)), (5, 0, (1,)), (77, 0, (1,))]
    assert (folder.read(77, 1) == 77).all()


FILLS = st.sampled_from(["", "0>", "*^", " <", "x=", "0<"])
SPECS = st.builds(
    lambda fill, sign, zero, width, kind: f"{fill}{sign}{zero}{width}{kind}",
    *(FILLS, st.sampled_from(["", "+", " ", "-"]), st.sampled_from(["", "0"]), st.sampled_from(["", 1, 3, 6])),
    st.sampled_from(["", "d", "x", "X", "o", "b", ",", "_d"]),
)


@given(SPECS, SPECS, st.integers(0, 100_000), st.integers(0, 20))
def test_a_name_that_a_pattern_writes_is_read_back(station_spec: str, take_spec: str, station: int, take: int) -> None:
    text = f"img {{station:{station_spec}}} ;{{take:{take_spec}}}.png"
    name = text.format(station=station, take=take)
    numbers = NamePattern(text).match(name)
    assert numbers is None or text.format(**numbers) == name
    if "<" not in station_spec + take_spec and "^" not in station_spec + take_spec:  # filled at the end: 1 or 10 or 100
        assert numbers == {"station": station, "angular": 0, "take": take}


@pytest.mark.parametrize(
    "pattern",
    ["{ring} {station}.png", "{take}.png", "fixed.png", "{station", "{}", "{station:.2f}", "{station!r}", "{0}"],
)
def test_a_wrong_pattern_names_the_allowed_fields(tmp_path: Path, pattern: str) -> None:
    with pytest.raises(InputError, match=r"\{station\}, \{angular\} and \{take\}"):
        ImageFolder(tmp_path, pattern)


def test_nothing_found_says_folder_pattern_count_and_an_example(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is empty"):
        ImageFolder(tmp_path, NAMES)
    for name in ("notes.txt", "shot7.png", "shot8.png"):
        (tmp_path / name).write_text("")
    with pytest.raises(InputError) as caught:
        ImageFolder(tmp_path, NAMES)
    for part in (str(tmp_path), NAMES, "3 files", "shot7.png"):
        assert part in str(caught.value)
    with pytest.raises(InputError, match="cannot be read"):
        ImageFolder(tmp_path / "absent", NAMES)


def test_an_unusable_image_is_an_error_of_its_own_that_says_why(tmp_path: Path) -> None:
    write(tmp_path / "good 1.png", 9)
    whole = (tmp_path / "good 1.png").read_bytes()
    bad = {
        2: (b"", "empty"),
        3: (whole[:-20], "truncated"),
        4: (b"GIF89a", "not a PNG"),
        5: (whole.replace(b"IDAT", b"IDAU"), "corrupt"),
    }
    for station, (data, _) in bad.items():
        (tmp_path / f"good {station}.png").write_bytes(data)
    folder = ImageFolder(tmp_path, "good {station}.png")
    assert folder.expected_stations == 5
    for station, (_, why) in bad.items():
        with pytest.raises(ImageError, match=why) as caught:
            folder.read(station)
        assert f"good {station}.png" in str(caught.value)
    assert (folder.read(1) == 9).all()
    with pytest.raises(ImageError, match="no image of station 6"):
        folder.read(6)


def test_an_image_that_vanishes_or_is_no_file_is_an_image_error(tmp_path: Path) -> None:
    write(tmp_path / "1.png")
    folder = ImageFolder(tmp_path, "{station}.png")
    os.remove(tmp_path / "1.png")
    with pytest.raises(ImageError, match="No such file"):
        folder.read(1)
    with pytest.raises(ImageError, match="not a regular file"):
        read_image(tmp_path)


def test_size_and_limit_are_those_of_the_file(tmp_path: Path) -> None:
    write(tmp_path / "1.tif")
    assert image_size(tmp_path / "1.tif") == (6, 4)
    with pytest.raises(ImageError, match="more than the limit"):
        ImageFolder(tmp_path, "{station}.tif", limit=20).read(1)
    (tmp_path / "2.bmp").write_bytes(
        b"BM" + struct.pack("<IHHIIiiHH", 0, 0, 0, 54, 40, 30000, 30000, 1, 24) + bytes(24)
    )
    with pytest.raises(ImageError, match="more than the limit"):
        read_image(tmp_path / "2.bmp")
