"""Paths as people have them: relative, with spaces and umlauts, with names that are no text at all."""

import json
import os
import shutil
import sys
from pathlib import Path

import pytest
from command_line import calibore, outcome_of, profile, started

NAME = "Rohr Nr. 7 (Süd), Größe 12″"


@pytest.fixture
def named(scan: Path) -> Path:
    """The scan folder with a name and images a German office would give them."""
    folder = scan.rename(scan.with_name(NAME))
    for image in folder.glob("*.png"):
        image.rename(image.with_name(image.name.replace("pipe ", "Prüfung Süd ")))
    text = (folder / "scan.toml").read_text(encoding="utf-8").replace("pipe {", "Prüfung Süd {")
    (folder / "scan.toml").write_text(text.replace("small pipe", NAME), encoding="utf-8")
    return folder


def test_spaces_and_umlauts_in_every_name_do_no_harm(named, tmp_path):
    out = tmp_path / "Ergebnis für Müller" / "Profil 1"
    outcome = calibore("profile", named, "--out", out, "--export", "csv")
    assert (outcome.status, outcome.err) == (0, "")
    assert f"Result: {out}   Report: {out / 'report.html'}" in outcome.out
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["name"] == NAME
    assert NAME in (out / "report.html").read_text(encoding="utf-8")


def test_an_image_with_an_umlaut_is_named_as_it_is_written(named):
    (named / "Prüfung Süd 002 0.png").unlink()
    (named / "Prüfung Süd 002 0.png").write_bytes(b"")
    outcome = profile(named)
    assert outcome.status == 3
    assert "could not be used: Prüfung Süd 002 0.png (it is empty" in outcome.err


@pytest.mark.parametrize("given", [".", "./", "scan.toml", "../small"])
def test_relative_paths_start_where_the_user_stands(scan, tmp_path, monkeypatch, given):
    monkeypatch.chdir(scan)
    outcome = profile(Path(given), out=Path("../out"))
    assert (outcome.status, outcome.err) == (0, "")
    assert (tmp_path / "out" / "profile.zarr").is_dir()


def test_the_same_scan_reached_by_another_path_replaces_its_own_result(scan, tmp_path, monkeypatch):
    assert profile(scan).status == 0
    monkeypatch.chdir(scan)
    assert profile(Path("scan.toml"), out=tmp_path / "out").status == 0
    (tmp_path / "link").symlink_to(scan)
    assert profile(tmp_path / "link" / ".", out=tmp_path / "out").status == 0


def test_a_result_behind_a_symbolic_link_is_replaced_and_the_link_stays(scan, tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "disk" / "result")
    for _ in range(2):
        assert profile(scan).status == 0
    assert (tmp_path / "out").is_symlink()
    assert os.listdir(tmp_path / "disk") == ["result"]


@pytest.mark.skipif(sys.platform != "linux", reason="other systems allow no such names")
@pytest.mark.parametrize("option", ["--no-pictures", "--json"])
def test_a_name_that_is_no_text_does_not_end_a_run(scan, tmp_path, option):
    strange = tmp_path / os.fsdecode(b"rohr \xff")
    shutil.copytree(scan, strange)
    outcome = outcome_of(
        started("profile", strange, "--out", tmp_path / os.fsdecode(b"out \xfe"), "--no-pictures", option)
    )
    assert (outcome.status, outcome.err) == (0, "")
    assert "4 stations" in outcome.out or json.loads(outcome.out)["counts"]["stations"] == 4
