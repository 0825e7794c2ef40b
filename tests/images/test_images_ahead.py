"""Files are announced to the system before they are wanted, and nothing else changes."""

import os
from pathlib import Path

import numpy as np
import pytest

from calibore.images import ImageFolder, PictureFile, StationImages, read_ahead
from calibore.images._ahead import AHEAD


def folder(path: Path, count: int) -> ImageFolder:
    for number in range(count):
        (path / f"{number}.pgm").write_bytes(b"P5 2 2 255\n" + bytes([number]) * 4)
    return ImageFolder(path, "{station}.pgm")


def test_stations_come_in_their_order_with_all_their_pictures(tmp_path: Path) -> None:
    for count in range(1, 6):
        source = folder(tmp_path, count)
        stations = list(read_ahead(source.stations()))
        assert [images.station for images in stations] == list(range(count))
        assert all((images.read(0) == images.station).all() for images in stations)


@pytest.mark.skipif(not hasattr(os, "posix_fadvise"), reason="this system takes no hints")
def test_the_files_of_the_stations_that_follow_are_announced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    announced: list[str] = []

    def advise(descriptor: int, offset: int, length: int, advice: int) -> None:
        assert (offset, length, advice) == (0, 0, os.POSIX_FADV_WILLNEED)
        announced.append(os.pread(descriptor, 12, 0)[-1:].hex())

    monkeypatch.setattr(os, "posix_fadvise", advise)
    for images in read_ahead(folder(tmp_path, 6).stations()):
        assert len(announced) == min(images.station + AHEAD + 1, 6)
    assert announced == [f"{number:02x}" for number in range(6)]


def test_a_file_that_is_gone_is_no_reason_to_stop(tmp_path: Path) -> None:
    def lost(take: int) -> np.ndarray:
        raise AssertionError(take)

    files = (PictureFile(tmp_path / "absent.png", 1000), PictureFile(tmp_path, 1000))
    stations = [StationImages(number, (0, 1), lost, files=files) for number in range(4)]
    assert list(read_ahead(stations)) == stations
