"""`calibore design`: everything is there, nothing half, and what cannot be is said in a sentence."""

import json
import os
import re
import subprocess
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from calibore.cli import main
from calibore.design import FORMAT, KINDS, Study, Wishes, analyse, plain_analysis
from calibore.errors import OutputError
from calibore.plotting import design_pictures
from calibore.reports import write_design
from calibore.rigs import write_rig

RIG_FILE = Study("rotating-spot", 0.1524)


def run(*words):
    """Exit status, standard output and standard error of `calibore design WORDS` in a process of its own."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "calibore", "design", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def here(tmp_path, monkeypatch, capsys):
    """The same as `run`, within this process, started in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run_here(*words):
        monkeypatch.setattr(sys, "argv", ["calibore", "design", *map(str, words)])
        with pytest.raises(SystemExit) as left:
            main()
        said = capsys.readouterr()
        return left.value.code or 0, said.out, said.err

    return run_here


@pytest.fixture
def few_pictures(monkeypatch):
    """Only the first three pictures of a design, to be quick."""
    monkeypatch.setattr("calibore.reports._design.design_pictures", lambda *a, **k: islice(design_pictures(*a, **k), 3))


@pytest.fixture(scope="module")
def cone(tmp_path_factory):
    """A finished design of a single cone, from the command line."""
    out = tmp_path_factory.mktemp("design") / "cone"
    status, words, complaint = run(
        "single-cone", "--out", out, "--baseline", "3 in", "--projection", "2", "--unit", "in", "--bump", "0.1 in"
    )
    assert status == 0, complaint
    return out, words


def test_a_design_is_complete(cone):
    out, words = cone
    data = json.loads((out / "design.json").read_text(encoding="utf-8"))
    assert data["format"] == FORMAT
    assert sorted(path.name for path in out.iterdir()) == data["files"]
    pictures = {path.stem for path in out.glob("*.png")}
    assert pictures == {path.stem for path in out.glob("*.svg")}
    assert pictures >= {"map", "limits", "round_pipe", "against_radius", "against_baseline", "against_projection"}
    assert pictures >= {"misalignment", "occlusion", "budget", "tolerances", "deployment"}
    assert all(sentence in words for sentence in data["verdicts"])
    assert " in " in words
    assert " mm" not in words


def test_the_page_needs_nothing_but_itself(cone):
    out, _ = cone
    page = (out / "design.html").read_text(encoding="utf-8")
    assert page.count('<img src="data:image/png;base64,') == len(list(out.glob("*.png")))
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert "How well must it be built" in page
    assert "nan" not in re.sub(r"base64,[^\"]+", "", page).lower().split()


def test_what_was_asked_for_is_what_was_computed(cone):
    out, _ = cone
    data = json.loads((out / "design.json").read_text(encoding="utf-8"))
    again = plain_analysis(analyse(Study("single-cone", 0.1524, baseline=0.5, projection=2.0), Wishes(bump=0.00254)))
    assert data.keys() - again.keys() == {"calibore", "files", "verdicts"}
    for part in ("ring", "limits", "radius", "baseline", "tolerances", "bump_shadow", "deployment"):
        for name, values in again[part].items():
            if name not in ("rows", "name"):
                found, expected = (np.array(one, dtype=float) for one in (data[part][name], values))
                np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9, err_msg=f"{part} {name}")


def test_a_map_in_numbers_is_null_where_there_is_no_value(cone):
    out, _ = cone
    (one,) = json.loads((out / "design.json").read_text(encoding="utf-8"))["maps"]
    shape = len(one["v"]), len(one["u"])
    for name in ("radius", "axial", "u_radius", "u_axial", "region"):
        assert np.array(one[name], dtype=float).shape == shape
    unknown = np.array(one["region"]) > one["regions"]["monte carlo"]
    assert unknown.any()
    np.testing.assert_array_equal(np.isnan(np.array(one["radius"], dtype=float)), unknown)


@pytest.mark.parametrize("configuration", ["dual-cone", "side-facing", "reversed-cone", "spot-array"])
def test_a_configuration_can_be_analysed_and_written_as_numbers(configuration):
    found = plain_analysis(analyse(Study(configuration, 0.1524, beams=2)))
    text = json.dumps(found, allow_nan=False)
    assert json.loads(text) == found
    assert found["tolerances"]["rows"]
    assert found["u_radius_worst"] > 0
    assert (found["projection"] is None) == (KINDS[configuration].projection is None)


def test_a_rig_file_can_be_judged(tmp_path, here, few_pictures):
    write_rig(RIG_FILE.rig(), tmp_path / "rig.toml")
    status, words, complaint = here("rig", "rig.toml", "--out", "out", "--radius", "6 in", "--json")
    assert status == 0, complaint
    data = json.loads(words)
    assert data["study"] == {}
    assert data["baseline"] is None
    same = plain_analysis(analyse(RIG_FILE))
    assert data["u_radius_worst"] == pytest.approx(same["u_radius_worst"], rel=1e-6)
    assert not (tmp_path / "out" / "against_baseline.png").exists()


@pytest.fixture(scope="module")
def spot():
    return analyse(Study("rotating-spot", 0.1524))


def test_a_second_run_replaces_the_design_and_nothing_else(tmp_path, spot, few_pictures):
    out = tmp_path / "design"
    write_design(spot, out)
    first = (out / "design.html").read_bytes()
    write_design(spot, out)
    assert (out / "design.html").read_bytes() == first
    (out / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match=r"notes\.txt"):
        write_design(spot, out)
    assert (out / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["design"]


def test_a_run_that_dies_leaves_the_old_design(tmp_path, spot, few_pictures):
    out = tmp_path / "design"
    write_design(spot, out)
    before = {path.name: path.read_bytes() for path in out.iterdir()}

    def die(done, total):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_design(spot, out, progress=die)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["design"]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (("single-cone", "--baseline", "7 in"), 1, "below 1 nominal radii, got 1.16"),
        (("side-facing", "--maximum", "0.5"), 1, "above 0.7"),
        (("perpendicular-plane", "--baseline", "-1"), 1, "above 0 nominal radii"),
        (("reversed-cone", "--offset", "1.5", "--lens", "perspective"), 1, "does not image a zenith"),
        (("perpendicular-plane", "--pixel-noise", "-1"), 1, "must be 0 or more, got -1"),
        (("perpendicular-plane", "--length-uncertainty", "-0.1"), 1, "must be 0 or more"),
        (("perpendicular-plane", "--bump", "2"), 1, "lower than the pipe's radius"),
        (("perpendicular-plane", "--lens", "fisheye"), 1, 'Lens law "fisheye" is not known'),
        (("perpendicular-plane", "--radius", "6"), 2, "has no unit"),
        (("perpendicular-plane", "--baseline", "12 kg"), 2, "is not a length"),
        (("perpendicular-plane", "--unit", "furlong"), 2, "not known"),
        (("perpendicular-plane", "--projection", "2"), 2, "No such option"),
        (("no-such-rig",), 2, "No such command"),
        (("rig", "nowhere.toml", "--radius", "6 in"), 1, "nowhere.toml"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_what_cannot_be_is_said_in_a_sentence(tmp_path, here, words, status, said):
    found, _, complaint = here(*words, "--out", tmp_path / "out")
    assert found == status
    assert said in complaint
    assert "Traceback" not in complaint
    assert not list(Path(tmp_path).iterdir())


@pytest.mark.parametrize("words", [("--help",), ("dual-cone", "--help"), ("rig", "--help")], ids=" ".join)
def test_help_needs_nothing_heavy(words):
    program = (
        "import sys\nfrom calibore.cli import app\n"
        f"try:\n    app({['design', *words]!r})\nexcept SystemExit: pass\n"
        "print(*{name.split('.')[0] for name in sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert not {"numpy", "matplotlib", "pint", "scipy"} & set(done.stdout.splitlines()[-1].split())
