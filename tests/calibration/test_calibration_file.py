"""A calibration's FILE: a rig file that says how well it is known, whole or not at all, with its evidence beside it."""

import os
import shutil
import subprocess
import sys
import time
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from calibration_examples import NAMES, calibration, fitted, lens, probe, seed_in

from calibore.calibration import (
    Calibration,
    InputFile,
    check_calibration_file,
    read_calibration,
    verify_inputs,
    write_calibration,
)
from calibore.errors import InputError, OutputError
from calibore.rigs import read_camera, read_rig

SCRIPT = Path(__file__).with_name("calibration_examples.py")
KINDS = {"rig": calibration, "lens": lens, "probe": probe}


@pytest.fixture
def out(tmp_path):
    return tmp_path / "here" / "lens.toml"


def beside(out: Path) -> list[str]:
    return sorted(path.name for path in out.parent.iterdir())


def differences(one, other, path: str = "") -> list[str]:
    """Where two calibrations are not the same to the last bit."""
    if hasattr(one, "__dataclass_fields__") and type(one) is type(other):
        names = [field.name for field in fields(one)]
        return [d for n in names for d in differences(getattr(one, n), getattr(other, n), f"{path}.{n}")]
    if isinstance(one, np.ndarray):
        return (
            [] if one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f") else [path]
        )
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return [d for i, (a, b) in enumerate(zip(one, other, strict=True)) for d in differences(a, b, f"{path}[{i}]")]
    same = one == other or (one != one and other != other)
    return [] if same else [f"{path}: {one!r} {other!r}"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_calibration_that_is_written_is_read_back_to_the_last_bit(out, kind, seed):
    found = KINDS[kind](seed)
    write_calibration(found, out)
    again = read_calibration(out)
    assert differences(found, again) == []
    assert list(again.values) == list(found.covariance.names)
    assert len(beside(out)) == 2


def test_what_is_not_known_is_read_back_as_not_known(out):
    whitened = replace(
        calibration(tied=False), degrees_of_freedom=float("inf"), noise=float("nan"), models=(), valid=None
    )
    found = replace(whitened, rig=replace(whitened.rig, valid=None, degrees_of_freedom=None))
    write_calibration(found, out)
    assert differences(found, read_calibration(out)) == []


def test_the_same_calibration_gives_the_same_bytes(tmp_path):
    def content(folder: Path) -> dict[str, bytes]:
        write_calibration(calibration(tied=False), folder / "rig.toml")
        return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    assert content(tmp_path / "a") == content(tmp_path / "b")


def test_it_is_a_rig_file_with_covariance_and_valid_region(out):
    found = calibration()
    write_calibration(found, out)
    rig = read_rig(out)
    assert rig.covariance.names == NAMES
    assert np.array_equal(rig.covariance.matrix, found.covariance.matrix)
    assert (rig.valid, rig.degrees_of_freedom) == (found.valid, 41.5)
    assert rig.lasers == found.rig.lasers
    camera = read_camera(out)
    assert camera.camera == found.camera
    assert camera.covariance.names == NAMES[2:]
    assert np.array_equal(camera.covariance.matrix, found.covariance.matrix[2:, 2:])


def test_what_is_stated_of_inputs_that_were_not_calibrated_stays_in_the_file(out):
    from calibore.uncertainty import Covariance

    found = calibration()
    stated = Covariance.independent({"laser.tilt_y": 2e-3, "camera.aspect": 1e-4})
    rig = replace(found.rig, covariance=found.covariance.joined(stated), stripe=0.5)
    write_calibration(replace(found, rig=rig), out)
    again = read_rig(out)
    assert again.covariance.names == (*NAMES, "laser.tilt_y", "camera.aspect")
    assert np.allclose(again.covariance.matrix, rig.covariance.matrix, rtol=1e-12)
    assert again.stripe == 0.5


def test_a_camera_alone_is_known_but_is_no_rig(out):
    write_calibration(lens(), out)
    camera = read_camera(out)
    assert camera.covariance.names == NAMES[2:]
    assert camera.degrees_of_freedom == 41.5
    assert camera.valid == lens().valid
    with pytest.raises(
        InputError, match=r"configuration and \[laser\] are missing. Join it .* `calibore calibrate rig`"
    ):
        read_rig(out)


def test_a_probe_is_neither(out):
    write_calibration(probe(), out)
    with pytest.raises(InputError, match=r"holds no rig: configuration, \[camera\] and \[laser\] are missing"):
        read_rig(out)
    with pytest.raises(InputError, match=r"holds no camera: \[camera\] is missing"):
        read_camera(out)


def test_parameters_of_the_target_are_kept_but_not_the_rigs(out):
    found = calibration()
    names = (*NAMES, "pose.0.x")
    covariance = type(found.covariance)(names, np.diag([1e-8, 1e-6, 0.1, 0.1, 1e-8]))
    values = {**found.values, "pose.0.x": 0.1}
    write_calibration(replace(found, values=values, covariance=covariance), out)
    assert read_calibration(out).covariance.names == names
    assert read_rig(out).covariance.names == NAMES


def test_values_and_covariance_must_speak_of_the_same(out):
    with pytest.raises(InputError, match="must name the same parameters"):
        write_calibration(replace(calibration(), values={"camera.k": 571.0}), out)
    assert not out.parent.exists()


def test_a_replaced_file_takes_its_evidence_with_it(out):
    for seed in (1, 2, 2):
        write_calibration(calibration(seed), out)
        assert seed_in(out) == seed
        assert len(beside(out)) == 2


def test_evidence_that_a_copy_of_the_file_still_names_is_kept(out):
    write_calibration(calibration(1), out)
    shutil.copy(out, out.with_name("2024.toml"))
    write_calibration(calibration(2), out)
    assert (seed_in(out), seed_in(out.with_name("2024.toml"))) == (2, 1)


def test_file_and_evidence_may_be_moved_together_and_the_file_renamed(out, tmp_path):
    write_calibration(calibration(), out)
    shutil.move(out.parent, tmp_path / "there")
    os.rename(tmp_path / "there" / "lens.toml", tmp_path / "there" / "camera 7.toml")
    assert seed_in(tmp_path / "there" / "camera 7.toml") == 1


def test_without_its_evidence_the_file_still_says_what_was_found(out, tmp_path):
    write_calibration(calibration(), out)
    shutil.copy(out, tmp_path / "alone.toml")
    alone = read_calibration(tmp_path / "alone.toml")
    assert differences(read_rig(tmp_path / "alone.toml").covariance, calibration().covariance) == []
    assert alone.observations.residual.size == 0
    assert any("is not beside it" in warning for warning in alone.warnings)
    assert seed_in(out) == 1


def test_changed_evidence_is_refused(out):
    write_calibration(calibration(), out)
    store = next(out.parent.glob("*.zarr"))
    other = out.with_name("other.toml")
    write_calibration(calibration(2), other)
    theirs = next(out.parent.glob("other-*.zarr"))
    shutil.rmtree(store)
    shutil.copytree(theirs, store)
    with pytest.raises(InputError, match="has been changed since it was written"):
        read_calibration(out)
    (store / "zarr.json").write_text("{")
    with pytest.raises(InputError, match="cannot be read"):
        read_calibration(out)
    write_calibration(calibration(), out)
    assert seed_in(out) == 1


def test_a_changed_or_missing_input_is_detected(out, tmp_path):
    import hashlib

    names = ["a.png", "b.png", "c.png"]
    for name in names:
        (tmp_path / name).write_bytes(name.encode())
    files = tuple(InputFile(name, hashlib.sha256(name.encode()).hexdigest()) for name in names)
    write_calibration(replace(calibration(), files=files), out)
    assert verify_inputs(out, tmp_path) == {}
    (tmp_path / "b.png").write_bytes(b"B.png")
    (tmp_path / "c.png").unlink()
    assert verify_inputs(out, tmp_path) == {"b.png": "changed", "c.png": "missing"}


def test_what_this_program_did_not_write_is_not_replaced(out):
    out.parent.mkdir()
    for text in ("my notes", 'format = "calibore-rig/1"\n[camera]\nk = 1\n', "\x00"):
        out.write_text(text)
        for write in (check_calibration_file, lambda path: write_calibration(calibration(), path)):
            with pytest.raises(OutputError, match="is no calibration that this program wrote"):
                write(out)
        assert out.read_text() == text
        assert beside(out) == ["lens.toml"]


def test_a_folder_and_a_place_below_a_file_are_refused(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    with pytest.raises(OutputError, match="is a folder; give the name of a file"):
        write_calibration(calibration(), tmp_path)
    with pytest.raises(OutputError, match="is not a folder; choose another place"):
        write_calibration(calibration(), tmp_path / "file" / "lens.toml")
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(OutputError, match="is not writable"):
        check_calibration_file(tmp_path / "lens.toml")


@pytest.mark.parametrize("step", ["replace", "rename"])
def test_a_failure_leaves_what_was_there(out, monkeypatch, step):
    def failing(*_):
        raise OSError(28, "No space left on device")

    write_calibration(calibration(1), out)
    before = beside(out)
    with monkeypatch.context() as patched:
        patched.setattr(os, step, failing)
        with pytest.raises(OutputError, match=r"cannot be written \(No space left on device"):
            write_calibration(calibration(2), out)
    assert beside(out) == before
    assert seed_in(out) == 1


def test_what_a_dead_run_left_is_removed_after_an_hour(out):
    write_calibration(calibration(1), out)
    for name in (".lens.toml.partial-0123abcd", ".lens-0123456789ab.zarr.partial-0123abcd", "lens-0123456789ab.zarr"):
        (out.parent / name).mkdir()
    (out.parent / ".mine.toml.partial-0123abcd").mkdir()
    write_calibration(calibration(1), out)
    assert len(beside(out)) == 6
    long_ago = time.time() - 4000
    for name in beside(out):
        os.utime(out.parent / name, (long_ago, long_ago))
    write_calibration(calibration(1), out)
    assert [name for name in beside(out) if "mine" in name] == [".mine.toml.partial-0123abcd"]
    assert len(beside(out)) == 3
    assert seed_in(out) == 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
def test_a_run_killed_at_any_change_of_the_disk_leaves_the_old_pair_or_the_new_pair(out):
    run = subprocess.run([sys.executable, SCRIPT, out, "3"], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stdout + run.stderr


def test_a_file_that_no_calibration_wrote_is_told(tmp_path):
    (tmp_path / "rig.toml").write_text('format = "calibore-rig/1"\n')
    with pytest.raises(InputError, match="Give a file that `calibore calibrate` wrote"):
        read_calibration(tmp_path / "rig.toml")
    with pytest.raises(InputError, match="does not exist"):
        read_calibration(tmp_path / "nowhere.toml")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("noise = 0.21", 'noise = "low"', r"calibration.noise = 'low' is wrong"),
        ("0.1 rad", "2 rad", "from a smaller to a larger value"),
        ('kind = "ring-gauge"', 'kind = "ring-gauge"\nzoom = 2', "calibration.zoom is not known"),
        ("values = [", "values = [ 1.0,", "4 parameters need as many values, got 5"),
        ("covariance = [", "covariance = [ [1.0],", "4 parameters need as many rows of as many numbers"),
        ("k = 571.2", "k = 572.2", r"camera.k is 572.2\d* in the rig but was calibrated as 571.2"),
    ],
)
def test_a_file_changed_by_hand_is_told_where(out, old, new, sentence):
    write_calibration(calibration(), out)
    text = out.read_text()
    assert old in text
    out.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=sentence):
        read_calibration(out)


def test_observations_that_do_not_fit_together_cannot_be_made():
    with pytest.raises(InputError, match=r"need jacobian of shape \(240, 6\), got \(3, 2\)"):
        replace(fitted()[1], jacobian=np.zeros((3, 2)))
    with pytest.raises(InputError, match=r"need whitened of shape \(3, 6\), got \(3, 2\)"):
        replace(fitted()[1], whitened=np.zeros((3, 2)))


def test_a_calibration_is_what_the_contract_says(out):
    import tomllib

    write_calibration(calibration(), out)
    table = tomllib.loads(out.read_text())["calibration"]
    assert {"parameters", "covariance", "degrees_of_freedom", "evidence", "kind", "created_by"} <= table.keys()
    assert (out.parent / table["evidence"] / "zarr.json").is_file()
    assert table["model"][0]["model"] == "sine-law"
    assert table["file"][0].keys() == {"name", "sha256"}
    assert table["file"][1]["refused"] == "no line was found"
    assert table["file"][2]["set_aside"] == "it has room light"
    assert "refused" not in table["file"][2]
    assert isinstance(read_calibration(out), Calibration)
