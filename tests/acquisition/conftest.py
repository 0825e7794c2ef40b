"""The small pipe, once for all tests of this folder."""

from pathlib import Path

import pytest
from live_parts import PATTERN, SIZE, photographs, write_film, write_picture, write_scan

from calibore.profiling import profile_scan


@pytest.fixture(scope="session")
def images():
    return photographs()


@pytest.fixture(scope="session")
def pictures(tmp_path_factory, images) -> Path:
    """A scan folder of picture files, two takes at station 4; its result beside it is called `profiled`."""
    folder = write_scan(tmp_path_factory.mktemp("pictures") / "pipe", f'pattern = "{PATTERN}"')
    for number, image in enumerate(images):
        write_picture(folder / PATTERN.format(station=number, take=0), image)
    write_picture(folder / PATTERN.format(station=4, take=1), images[4])
    profile_scan(folder, folder.parent / "profiled", workers=2)
    return folder


@pytest.fixture(scope="session")
def film(tmp_path_factory, images) -> Path:
    """The scan folder of a film; its result beside it is called `profiled`."""
    folder = write_scan(tmp_path_factory.mktemp("film") / "pipe", 'video = "film.mp4"')
    write_film(folder / "film.mp4", images)
    small = [image[::2, ::2].copy() for image in images[:5]]
    write_film(folder / "smaller.mp4", small)
    assert small[0].shape[:2] == (SIZE[1] // 2, SIZE[0] // 2)
    profile_scan(folder, folder.parent / "profiled", workers=2)
    return folder
