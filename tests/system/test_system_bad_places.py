"""Results never replace what is not theirs, and a full or locked disk is told."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from command_line import calibore, profile, stray_files
from spoilt import DONE, PARTLY, WRONG_USAGE, refused, write_key

NOBODY = 65534


def test_a_folder_with_other_files_is_never_replaced(scan, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "diary.txt").write_text("mine")
    refused(profile(scan), str(tmp_path / "out"), '"diary.txt"', "choose an empty or new folder")
    assert (tmp_path / "out" / "diary.txt").read_text() == "mine"
    assert os.listdir(tmp_path / "out") == ["diary.txt"]


def test_the_result_of_another_scan_is_never_replaced(scan, tmp_path):
    assert profile(scan).status == DONE
    before = (tmp_path / "out" / "summary.json").read_bytes()
    write_key(scan / "scan.toml", '"small pipe"', '"another pipe"')
    refused(profile(scan), str(tmp_path / "out"), 'another scan ("small pipe")', "choose another folder")
    assert (tmp_path / "out" / "summary.json").read_bytes() == before


def test_a_result_to_which_somebody_added_files_is_never_replaced(scan, tmp_path):
    assert profile(scan).status == DONE
    (tmp_path / "out" / "notes.txt").write_text("mine")
    refused(profile(scan), str(tmp_path / "out"), "holds notes.txt", "move it away or choose another folder")
    assert (tmp_path / "out" / "notes.txt").exists()


def test_the_scan_folder_itself_is_never_replaced(scan):
    before = sorted(os.listdir(scan))
    refused(profile(scan, out=scan), str(scan), "choose an empty or new folder")
    refused(profile(scan, out=scan.parent), str(scan.parent), "choose an empty or new folder")
    assert sorted(os.listdir(scan)) == before


def test_a_result_inside_the_scan_folder_does_not_touch_the_scan(scan):
    before = sorted(os.listdir(scan))
    for _ in range(2):
        assert profile(scan, out=scan / "result").status == DONE
    assert sorted(os.listdir(scan)) == sorted([*before, "result"])


def test_a_file_in_the_way_is_named(scan):
    refused(profile(scan, out=scan / "scan.toml"), "scan.toml is a file", "choose another name")
    refused(profile(scan, out=scan / "scan.toml" / "out"), "is not a folder", "choose another place")


@contextmanager
def as_nobody() -> Iterator[None]:
    """Root may write everywhere; for the time of this block it is somebody who may not."""
    if os.getuid() != 0:
        yield
        return
    os.setresuid(NOBODY, NOBODY, 0)
    try:
        yield
    finally:
        os.setresuid(0, 0, 0)


@pytest.mark.skipif(not hasattr(os, "setresuid"), reason="needs POSIX users")
def test_a_folder_without_permission_to_write_is_named(rendered):
    assert profile(rendered, "--estimator", "none").status == WRONG_USAGE  # imports what nobody may not read
    with TemporaryDirectory() as name:
        place = Path(name)
        shutil.copytree(rendered, place / "small")
        for path in (*place.rglob("*"), place):
            path.chmod(0o755)
        closed = place / "closed"
        closed.mkdir(mode=0o555)
        with as_nobody():
            outcome = profile(place / "small", out=closed / "out")
        refused(outcome, str(closed / "out"), "cannot be written", "choose a folder that you may write to")
        assert os.listdir(closed) == []


@pytest.mark.skipif(not hasattr(os, "setresuid"), reason="needs POSIX users")
@pytest.mark.parametrize("name", ["scan.toml", "rig.toml", "pipe 002 0.png"])
def test_a_file_without_permission_to_read_is_named(rendered, name):
    assert profile(rendered, "--estimator", "none").status == WRONG_USAGE
    with TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copytree(rendered, place / "small")
        for path in (*place.rglob("*"), place):
            path.chmod(0o777)
        (place / "small" / name).chmod(0)
        with as_nobody():
            outcome = profile(place / "small")
        if name.endswith("toml"):
            refused(outcome, name, "cannot be read", "ermission")
        else:
            assert outcome.status == PARTLY
            assert f"{name} (it cannot be read (Permission denied)" in outcome.err


@contextmanager
def small_disk(limit: int) -> Iterator[None]:
    """No file may grow beyond `limit` bytes."""
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


LIMITS = (3_000, 20_000, 60_000)
"""Bytes per file, reached by rings.csv and metadata, by an array, by a picture."""


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX resource limits")
@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("old", [False, True], ids=["nothing there", "old result there"])
def test_a_full_disk_is_told_and_leaves_what_was_there(scan, tmp_path, limit, old):
    out = tmp_path / "out"
    if old:
        assert profile(scan).status == DONE
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}

    with small_disk(limit):
        outcome = calibore("profile", scan, "--out", out)
    refused(outcome, str(out), "the disk is full or a size limit is reached", "Free some space or choose a folder")
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before
    assert out.exists() == old
    assert not stray_files(out)
