"""A folder that is being filled gives the result that it gives when it is full, whoever fills it and however badly."""

import shutil

import numpy as np
import pytest
from live_parts import HERE, PATTERN, PICTURES, SIZE, Record, contents, python, run, write_picture

from calibore.acquisition import Wanted
from calibore.errors import InputError
from calibore.profiling import profile_scan
from calibore.scans import read_rings

PARTS = ("profile.zarr", "points.zarr", "rings.csv")


def emptied(pictures, folder):
    """The scan folder without its pictures."""
    folder.mkdir()
    for name in ("scan.toml", "rig.toml"):
        shutil.copy(pictures / name, folder)
    return folder


@pytest.mark.parametrize("seed", [1, 2])
def test_a_folder_filled_by_a_slow_camera_gives_the_same_bytes_as_when_it_is_full(pictures, tmp_path, seed):
    scan, watch = emptied(pictures, tmp_path / "pipe"), Record()
    toml = scan / "scan.toml"
    toml.write_text(toml.read_text(encoding="utf-8").replace("{take}", "0"), encoding="utf-8")
    camera = python(HERE / "slow_camera.py", pictures, scan, seed, 0.12)
    summary = run(Wanted(str(scan)), tmp_path / "out", watch=watch, count=PICTURES, late=20.0, grace=20.0)
    assert camera.communicate()[1] == ""
    profile_scan(scan, tmp_path / "profiled", workers=1)
    assert contents(tmp_path / "out", *PARTS) == contents(tmp_path / "profiled", *PARTS)
    assert watch.sentences == []
    assert summary["counts"]["refused_images"] == 0
    assert summary["live"]["ended"] == "as many rings as asked for"


def test_takes_of_a_station_are_waited_for_and_combined(pictures, tmp_path):
    scan = emptied(pictures, tmp_path / "pipe")
    names = sorted(path.name for path in pictures.glob("*.png"))
    second = PATTERN.format(station=4, take=1)
    for name in names:
        if name != second and name < PATTERN.format(station=6, take=0):
            shutil.copy(pictures / name, scan)

    def bring_rest(vitals):
        if vitals.rings == 4:
            for name in (second, *(name for name in names if not (scan / name).exists())):
                shutil.copy(pictures / name, scan)

    summary = run(Wanted(str(scan), idle=0.5), tmp_path / "out", watch=Record(each=bring_rest), late=3.0)
    assert contents(tmp_path / "out", *PARTS) == contents(pictures.parent / "profiled", *PARTS)
    assert summary["counts"]["images"] == PICTURES + 1


def test_a_broken_picture_and_one_of_another_size_are_told_once_and_left_out_as_by_profile(pictures, images, tmp_path):
    scan = emptied(pictures, tmp_path / "pipe")
    for path in pictures.glob("*.png"):
        shutil.copy(path, scan)
    broken, small = (scan / PATTERN.format(station=n, take=0) for n in (2, 7))
    broken.write_bytes(broken.read_bytes()[:5000])
    for path in (small, scan / PATTERN.format(station=8, take=0)):
        write_picture(path, images[7][::2, ::2].copy())
    watch = Record()
    summary = run(Wanted(str(scan), idle=0.5), tmp_path / "out", watch=watch)
    assert [sentence[: len(broken.name)] for sentence in watch.sentences] == [broken.name, small.name]
    assert f"it is {SIZE[0] // 2} x {SIZE[1] // 2} px but the rig's camera has" in watch.sentences[1]
    expected = profile_scan(scan, tmp_path / "profiled", workers=1)
    assert contents(tmp_path / "out", *PARTS) == contents(tmp_path / "profiled", *PARTS)
    assert summary["skipped"] == expected["skipped"]
    assert summary["warnings"] == expected["warnings"]


def test_a_picture_that_comes_after_later_stations_is_named_and_not_measured(pictures, tmp_path):
    scan, late = emptied(pictures, tmp_path / "pipe"), PATTERN.format(station=1, take=0)
    for path in pictures.glob("*.png"):
        if path.name != late:
            shutil.copy(path, scan)

    def bring_late(vitals):
        if vitals.rings == 3:
            shutil.copy(pictures / late, scan)

    summary = run(Wanted(str(scan), idle=1.0), tmp_path / "out", watch=Record(each=bring_late))
    assert read_rings(tmp_path / "out")["station"].tolist() == [0, *range(2, PICTURES)]
    assert summary["counts"]["refused_images"] == 1
    assert any("it came after pictures of later stations" in warning for warning in summary["warnings"])


def test_pictures_are_never_dropped_and_few_of_them_wait_in_memory(pictures, tmp_path):
    seen = []
    watch = Record(each=lambda vitals: seen.append(vitals.backlog))
    summary = run(Wanted(str(pictures), idle=0.2, waiting=1), tmp_path / "out", watch=watch)
    assert summary["counts"]["dropped_images"] == 0
    assert len(watch.rows) == PICTURES
    assert max(seen) >= PICTURES // 2
    assert np.all(np.array(watch.latencies) > 0)


def test_a_folder_that_is_not_there_or_stays_empty_is_told(pictures, tmp_path):
    scan = emptied(pictures, tmp_path / "pipe")
    with pytest.raises(InputError, match=r"sent no picture in \d+ s, so there is nothing to write; check"):
        run(Wanted(str(scan), idle=0.1), tmp_path / "out")
    with pytest.raises(InputError, match="does not exist; give a scan folder"):
        run(Wanted(str(tmp_path / "nowhere")), tmp_path / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["pipe"]
