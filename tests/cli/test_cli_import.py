"""`calibore import`: an archive that profiles like its pictures; killed it goes on; mistakes in one sentence."""

import json
import os
import shutil
import signal
import sys
import time
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "system"))
sys.path.append(str(Path(__file__).parents[1] / "profiling"))
from command_line import calibore, outcome_of, started
from side_scans import side_survey

from calibore.images import ImageArchive, ImageFolder, read_image
from calibore.profiling import archive_scan
from calibore.scans import read_scan
from calibore.simulation import demo_survey, simulate_scan

SHARED = Path(__file__).parents[2].parent / "shared" / "data" / "simulated"
DONE, UNUSABLE, PARTLY_REFUSED = 0, 1, 3
KILLS = 3


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """The demonstration's scan."""
    return simulate_scan(tmp_path_factory.mktemp("scans") / "demo", demo_survey(seed=2), seed=2)


@pytest.fixture
def copy(scan, tmp_path):
    """A scan folder of four stations to spoil."""
    folder = tmp_path / "scan"
    shutil.copytree(scan, folder, ignore=lambda _, names: sorted(n for n in names if n.endswith(".png"))[4:])
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def arrays(out: Path) -> dict[str, bytes]:
    """Every number of a result, as its bytes."""
    return {name: data for name, data in contents(out).items() if "/c/" in name or name == "rings.csv"}


def profiled(scan: Path, out: Path) -> tuple[int, dict]:
    outcome = calibore("profile", scan, "--out", out, "--no-pictures", "--json")
    return outcome.status, json.loads(outcome.out)


def assert_measured_alike(scan: Path, tmp_path: Path) -> None:
    assert calibore("import", scan, "--out", tmp_path / "archive").status in (DONE, PARTLY_REFUSED)
    status, summary = profiled(scan, tmp_path / "of files")
    assert profiled(tmp_path / "archive", tmp_path / "of archive")[0] == status
    assert len(arrays(tmp_path / "of files")) > 20
    assert arrays(tmp_path / "of archive") == arrays(tmp_path / "of files")
    again = json.loads((tmp_path / "of archive" / "summary.json").read_text(encoding="utf-8"))
    assert again["skipped"] == summary["skipped"]


@pytest.mark.parametrize("name", ["plane-12in", "cone-dual", "field", "side-2.4in"])
def test_the_shared_surveys_are_measured_bit_for_bit_alike_from_their_archive(name, tmp_path):
    if not (SHARED / name).exists():
        pytest.skip(f"the simulated surveys beside the repository (shared/data/simulated/{name}) are absent")
    folder = tmp_path / name
    shutil.copytree(SHARED / name, folder)
    for image in sorted(folder.glob("*.png"))[4:]:
        image.unlink()
    assert_measured_alike(folder, tmp_path)


def test_a_scan_with_damaged_pictures_is_measured_alike_and_names_them_too(copy, tmp_path):
    for image in sorted(copy.glob("*.png"))[1:3]:
        image.write_bytes(image.read_bytes()[:5000])
    assert_measured_alike(copy, tmp_path)


def test_a_side_facing_scan_is_measured_alike(tmp_path):
    survey = side_survey(3, angles=(0, 1, 2, 200), takes=2)
    assert_measured_alike(simulate_scan(tmp_path / "side", survey, seed=1), tmp_path)


@pytest.mark.parametrize("bits", [8, 16])
def test_grey_pictures_of_8_and_16_bit_are_measured_alike(copy, tmp_path, bits):
    for path in copy.glob("*.png"):
        picture = read_image(path)
        grey = picture[:, :, 0] if picture.ndim == 3 else picture
        cv2.imwrite(str(path), grey if bits == 8 else 257 * grey.astype(np.uint16))
    assert_measured_alike(copy, tmp_path)


def test_a_byte_that_changes_in_an_archive_costs_one_picture_and_exit_status_3(copy, tmp_path):
    assert calibore("import", copy, "--out", tmp_path / "archive").status == DONE
    file = next((tmp_path / "archive" / "images.zarr").glob("*/c/2/**/0/0"))
    file = file if file.is_file() else next(path for path in file.rglob("*") if path.is_file())
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    status, summary = profiled(tmp_path / "archive", tmp_path / "out")
    assert status == PARTLY_REFUSED
    assert len(summary["skipped"]) == 1
    assert "have changed since it was imported" in json.dumps(summary["skipped"])
    assert summary["counts"]["images"] == 3


def test_the_command_tells_what_it_did(copy, tmp_path):
    next(iter(sorted(copy.glob("*.png")))).write_bytes(b"no picture")
    told = calibore("import", copy, "--out", tmp_path / "a")
    assert told.status == PARTLY_REFUSED
    assert told.out.startswith("3 images: ")
    assert told.err.startswith('Warning: image "')
    counted = calibore("import", copy, "--out", tmp_path / "b", "--json", "--workers", 1)
    assert counted.status == PARTLY_REFUSED
    said = json.loads(counted.out)
    assert said["counts"] == {"images": 3, "refused_images": 1}
    assert said["bytes_in_archive"] < said["bytes_of_files"]
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def lines(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def wait_for_another_picture(process, journal: Path) -> None:
    """Until the run has finished one more picture than earlier runs had, or has ended."""
    before, deadline = lines(journal), time.monotonic() + 60
    while process.poll() is None and time.monotonic() < deadline and lines(journal) <= max(before, 1):
        time.sleep(0.002)


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_killed_again_and_again_it_goes_on_and_the_archive_appears_whole(scan, tmp_path):
    assert calibore("import", scan, "--out", tmp_path / "undisturbed").status == DONE
    out, rng, done = tmp_path / "out", np.random.default_rng(9), []
    journal = tmp_path / ".out.importing" / "import.jsonl"
    for _ in range(KILLS):
        process = started("import", scan, "--out", out)
        wait_for_another_picture(process, journal)
        time.sleep(float(rng.uniform(0.0, 0.2)))
        process.send_signal(signal.SIGKILL)
        if outcome_of(process).status == DONE:
            break
        assert not out.exists()
        done.append(lines(journal))
    assert all(more > fewer for fewer, more in pairwise([1, *done]))  # nothing that was done is lost
    assert len(done) > 1
    assert out.exists() or calibore("import", scan, "--out", out).status == DONE
    assert contents(out) == contents(tmp_path / "undisturbed")
    assert sorted(os.listdir(tmp_path)) == ["out", "undisturbed"]


def test_everything_that_scan_toml_names_goes_along(copy, tmp_path):
    elsewhere = tmp_path / "rigs"
    elsewhere.mkdir()
    (copy / "rig.toml").rename(elsewhere / "ours.toml")
    (copy / "places").mkdir()
    stations = "".join(f"{number},{0.1 * number}\n" for number in range(20))
    (copy / "places" / "stations.csv").write_text(f"station,axial_m\n{stations}", encoding="utf-8")
    text = (copy / "scan.toml").read_text(encoding="utf-8").split("[motion]")[0]
    text = text.replace('"rig.toml"', '"../rigs/ours.toml"') + '[motion]\ntable = "places/stations.csv"\n'
    (copy / "scan.toml").write_text(text, encoding="utf-8")
    (tmp_path / ".archive.importing" / "places").mkdir(parents=True)  # an earlier run died while it copied
    archive_scan(copy, tmp_path / "archive")
    assert (tmp_path / "archive" / "ours.toml").read_bytes() == (elsewhere / "ours.toml").read_bytes()
    before, after = read_scan(copy), read_scan(tmp_path / "archive")
    shutil.rmtree(elsewhere)
    assert after.rig_path == (tmp_path / "archive" / "ours.toml").resolve()
    assert after.motion == (tmp_path / "archive" / "places" / "stations.csv").resolve()
    assert after.pattern == before.pattern
    assert profiled(tmp_path / "archive", tmp_path / "out")[0] == DONE


@pytest.mark.parametrize(
    "written",
    ["[images]\npattern = {}", "images = {{ pattern = {} }}", "images.pattern = {}", "[images]\r\npattern={}"],
)
def test_scan_toml_may_be_written_in_any_way_and_keeps_its_comments(copy, tmp_path, written):
    spec = read_scan(copy)
    images, motion = written.format(json.dumps(spec.pattern)), 'axial = { origin = "0 m", step = "1 m" }'
    head = (
        f'# ours\nformat = "calibore-scan/1"\nname = "a"\nrig = "rig.toml"\npipe.nominal_radius = "0.15 m"\n{images}\n'
    )
    motion = f"[motion]\n{motion}\n" if written.startswith("[") else f"motion.{motion}\n"
    (copy / "scan.toml").write_bytes((head + motion).encode())
    archive_scan(copy, tmp_path / "archive")
    assert (tmp_path / "archive" / "scan.toml").read_text(encoding="utf-8").startswith("# ours")
    store = read_scan(tmp_path / "archive").archive
    assert store is not None
    archive, folder = ImageArchive(store, str(spec.pattern)), ImageFolder(copy, str(spec.pattern))
    assert archive.expected_stations == folder.expected_stations


def test_an_archive_is_never_replaced_and_mistakes_are_told_in_a_sentence(copy, tmp_path):
    archive = tmp_path / "archive"
    assert calibore("import", copy, "--out", archive).status == DONE
    before = contents(archive)
    for arguments, said in (
        ((copy, "--out", archive), "holds an archive already, which is never replaced"),
        ((copy, "--out", copy), "exists and is not empty"),
        ((archive, "--out", tmp_path / "b"), "names an archive already; profile it as it is"),
        ((tmp_path / "nowhere", "--out", tmp_path / "b"), "does not exist"),
    ):
        outcome = calibore("import", *arguments)
        assert outcome.status == UNUSABLE
        assert said in outcome.sentence
    assert contents(archive) == before
    assert sorted(os.listdir(tmp_path)) == ["archive", "scan"]


def test_a_film_and_a_scan_by_touch_are_left_as_they_are(copy, tmp_path):
    (copy / "a.mp4").touch()
    text = (copy / "scan.toml").read_text(encoding="utf-8")
    pattern = str(read_scan(copy).pattern)
    (copy / "scan.toml").write_text(text.replace(f'pattern = "{pattern}"', 'video = "a.mp4"'), encoding="utf-8")
    outcome = calibore("import", copy, "--out", tmp_path / "archive")
    assert outcome.status == UNUSABLE
    assert "names a film, which decoded would need many times its size; only pictures" in outcome.sentence


def test_an_archive_without_the_names_of_its_pictures_or_that_is_not_there_is_told(copy):
    text, pattern = (copy / "scan.toml").read_text(encoding="utf-8"), str(read_scan(copy).pattern)
    for images, said in (
        ('archive = "images.zarr"', "names no data"),
        (f'pattern = "{pattern}"\narchive = "images.zarr"', "names no existing archive"),
        ('archive = "images.zarr"\nvideo = "a.mp4"', "images.archive needs images.pattern"),
    ):
        (copy / "scan.toml").write_text(text.replace(f'pattern = "{pattern}"', images), encoding="utf-8")
        outcome = calibore("profile", copy, "--out", copy / "out")
        assert outcome.status == UNUSABLE
        assert said in outcome.sentence
