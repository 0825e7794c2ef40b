"""Whatever happens to a run, OUT is the old result, the new one, or absent; and what is not ours is never touched."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tiny_survey import SCAN, make_scan, ring, row, verify, write

from calibore.errors import OutputError
from calibore.scans import ResultWriter, read_scan

SCRIPT = Path(__file__).with_name("tiny_survey.py")
posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")


@pytest.fixture
def scan(tmp_path):
    return make_scan(tmp_path / "scan")


@pytest.fixture
def out(tmp_path):
    return tmp_path / "out"


def beside(out: Path) -> set[str]:
    return {path.name for path in out.parent.iterdir()}


def run_script(name: str, out: Path, scan: Path, number: int) -> subprocess.CompletedProcess[str]:
    arguments = [sys.executable, str(SCRIPT), name, str(out), str(scan), str(number)]
    return subprocess.run(arguments, capture_output=True, text=True, timeout=120)


def test_a_second_run_replaces_the_first(out, scan):
    for seed in (1, 2):
        write(out, scan, seed=seed)
        assert verify(out) == seed
    assert beside(out) == {"out", "scan"}


def test_parents_are_made_and_an_empty_folder_is_used(tmp_path, scan):
    write(tmp_path / "a" / "b" / "out", scan)
    (tmp_path / "empty").mkdir()
    write(tmp_path / "empty", scan)
    assert verify(tmp_path / "a" / "b" / "out") == verify(tmp_path / "empty") == 1


def test_a_link_to_a_folder_is_followed(tmp_path, scan):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write(tmp_path / "link", scan)
    assert (tmp_path / "link").is_symlink()
    assert verify(tmp_path / "real") == 1


@pytest.mark.parametrize(
    "name", ["notes.txt", "profile.zarr/notes.txt", "profile.zarr/radius/notes.txt", "mine/notes.txt", "photo.png"]
)
def test_a_result_with_a_strangers_file_is_refused_before_any_work(out, scan, name):
    write(out, scan)
    (out / name).parent.mkdir(exist_ok=True)
    (out / name).write_text("mine")
    with pytest.raises(OutputError, match=f"holds {name}, which this program did not write; move it away"):
        ResultWriter(out, read_scan(scan))
    assert (out / name).read_text() == "mine"
    assert verify(out) == 1


def test_what_file_browsers_and_exports_leave_does_not_stand_in_the_way(out, scan):
    write(out, scan)
    for name in (".DS_Store", "profile.nc", "points.laz"):
        (out / name).write_text("x")
    write(out, scan, seed=2)
    assert verify(out) == 2


def test_a_folder_of_other_files_is_refused(out, scan):
    out.mkdir()
    (out / "thesis.tex").write_text("years of work")
    with pytest.raises(OutputError, match=r'not a result of this program, for example "thesis.tex"; choose an'):
        ResultWriter(out, read_scan(scan))
    (out / "summary.json").write_text('{"format": "calibore-result/1", "broken')
    with pytest.raises(OutputError, match="not a result of this program"):
        ResultWriter(out, read_scan(scan))


def test_another_scans_result_is_refused(out, scan, tmp_path):
    write(out, scan)
    other = make_scan(tmp_path / "other", SCAN.replace("tiny pipe", "long pipe"))
    with pytest.raises(OutputError, match=r'holds the result of another scan ."tiny pipe".; choose another folder'):
        ResultWriter(out, read_scan(other))
    assert verify(out) == 1


def test_a_file_a_mount_point_and_a_place_below_a_file_are_refused(tmp_path, scan):
    (tmp_path / "file").write_text("x")
    for place, sentence in (
        (tmp_path / "file", "is a file, not a folder"),
        (tmp_path / "file" / "out", "is not a folder; choose another place"),
        (Path("/"), "is a mount point"),
    ):
        with pytest.raises(OutputError, match=sentence):
            ResultWriter(place, read_scan(scan))


def test_a_parent_that_may_not_be_written_is_refused(out, scan, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(OutputError, match="is not writable; choose a folder that you may write to"):
        ResultWriter(out, read_scan(scan))


@pytest.mark.parametrize("interruption", [KeyboardInterrupt(), ValueError("no"), OSError(errno.EIO, "bad disk")])
def test_an_interrupted_run_leaves_the_old_result(out, scan, interruption):
    def interrupted():
        with ResultWriter(out, read_scan(scan)) as writer:
            writer.add(*ring(0), {})
            raise interruption

    write(out, scan)
    with pytest.raises(type(interruption)):
        interrupted()
    assert verify(out) == 1
    assert beside(out) == {"out", "scan"}


def test_leaving_without_finishing_leaves_nothing(out, scan):
    with ResultWriter(out, read_scan(scan)) as writer:
        writer.add(*ring(0), {})
    assert beside(out) == {"scan"}
    with pytest.raises(RuntimeError, match="only inside its with block"):
        _ = writer.folder


def test_an_interruption_between_the_two_renames_puts_the_old_result_back(out, scan, monkeypatch):
    write(out, scan)
    rename = os.rename

    def interrupted(source, target):
        if ".partial-" in str(source):
            monkeypatch.setattr(os, "rename", rename)
            raise KeyboardInterrupt
        rename(source, target)

    monkeypatch.setattr(os, "rename", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write(out, scan, seed=2)
    assert verify(out) == 1
    assert beside(out) == {"out", "scan"}


def test_a_file_put_into_the_old_result_during_the_run_is_kept(out, scan):
    write(out, scan)
    with ResultWriter(out, read_scan(scan)) as writer:
        profile, points = ring(0)
        writer.add(profile, points, row(profile))
        (out / "notes").write_text("mine")
        with pytest.raises(OutputError, match="holds notes"):
            writer.finish({})
    assert (out / "notes").read_text() == "mine"
    assert beside(out) == {"out", "scan"}


def test_two_runs_into_one_folder_are_refused(out, scan):
    with ResultWriter(out, read_scan(scan)) as writer:
        with pytest.raises(OutputError, match="is being written by another run"), ResultWriter(out, read_scan(scan)):
            pass
        assert writer.folder.is_dir()
        done = run_script("abandon", out, scan, 0)
        assert "is being written by another run" in done.stderr
        assert writer.folder.is_dir()


def test_a_half_removed_old_result_is_not_put_back(out, scan):
    write(out, scan)
    aside = out.with_name(".out.old-1-0123abcd")
    os.rename(out, aside)
    (aside / "rings.csv").unlink()
    with ResultWriter(out, read_scan(scan)):
        pass
    assert beside(out) == {"scan"}


def test_names_that_look_like_patterns_are_left_alone(tmp_path, scan):
    for name in ("out", "[o]ut", "out.old"):
        (tmp_path / f".{name}.partial-1-0123abcd").mkdir()
    (tmp_path / ".out.partial-mine").mkdir()
    write(tmp_path / "out", scan)
    assert beside(tmp_path / "out") == {
        "out",
        "scan",
        ".[o]ut.partial-1-0123abcd",
        ".out.old.partial-1-0123abcd",
        ".out.partial-mine",
    }


@posix
def test_a_run_killed_at_any_change_of_the_disk_leaves_the_old_result_the_new_one_or_none(out, scan):
    done = run_script("survive_kills", out, scan, 12)
    assert done.returncode == 0, done.stdout + done.stderr


@posix
def test_runs_killed_at_random_times_leave_a_complete_result_or_none(out, scan):
    done = run_script("survive_random_kills", out, scan, 5)
    assert done.returncode == 0, done.stdout + done.stderr


@posix
@pytest.mark.parametrize("limit", [100, 50_000])
def test_a_file_size_limit_is_told_like_a_full_disk(out, scan, limit):
    done = run_script("write_with_small_files", out, scan, limit)
    assert "OutputError" in done.stderr
    assert "the disk is full or a size limit is reached" in done.stderr
    assert beside(out) == {"scan"}


@pytest.fixture
def small_disk(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if (
        not sys.platform.startswith("linux")
        or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(disk)], capture_output=True
        ).returncode
    ):
        pytest.skip("a small disk cannot be mounted here (needs root on Linux)")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def test_a_full_disk_is_told_and_leaves_the_old_result(small_disk, scan):
    out = small_disk / "out"
    write(out, scan, stations=1, points=0)
    old = sorted(path.name for path in out.rglob("*"))
    with pytest.raises(OutputError, match=r"cannot be written: the disk is full .*Free some space or choose"):
        write(out, scan, stations=400, clocks=400)
    assert sorted(path.name for path in out.rglob("*")) == old
    assert {path.name for path in small_disk.iterdir()} == {"out"}


def test_a_disk_filled_by_a_picture_is_told_too(small_disk, scan):
    with (
        pytest.raises(OutputError, match="the disk is full"),
        ResultWriter(small_disk / "out", read_scan(scan)) as writer,
    ):
        (writer.folder / "map.png").write_bytes(bytes(1_000_000))
    assert list(small_disk.iterdir()) == []
