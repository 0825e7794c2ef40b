"""`calibore reproduce`: one page that needs nothing but itself, and a folder that appears whole."""

import json
import re
import subprocess
import sys

import pytest

from calibore.errors import OutputError
from calibore.published import PICTURES, published_values
from calibore.reports import _reproduction, write_reproduction

FEW = tuple(build for build in PICTURES if build.__name__ in ("figure_3_3", "figure_4_6"))
ALLOWED_S = 60


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(_reproduction, "PICTURES", FEW)


@pytest.mark.usefixtures("few")
def test_the_page_stands_alone_and_shows_every_number(tmp_path):
    told = []
    facts = write_reproduction(tmp_path / "out", progress=lambda done, total: told.append((done, total)))
    page = (tmp_path / "out" / "reproduction.html").read_text(encoding="utf-8")
    assert set(re.findall(r'src="(\w+:)', page)) == {"data:"}
    assert "://" not in page
    assert page.count("<img") == len(FEW)
    for value in published_values():
        if value.printed:
            assert f">{value.printed}<" in page or f">{value.printed} (scan: {value.scanned})<" in page
    assert told[0] == (0, 3)
    assert told[-1] == (3, 3)
    assert json.loads((tmp_path / "out" / "reproduction.json").read_text(encoding="utf-8")) == facts


@pytest.mark.usefixtures("few")
def test_every_file_the_json_names_is_there_and_no_other(tmp_path):
    facts = write_reproduction(tmp_path / "out")
    named = {name for picture in facts["pictures"] for name in picture["files"]}
    assert {path.name for path in (tmp_path / "out").iterdir()} == named | {"reproduction.html", "reproduction.json"}
    assert len(named) == 2 * len(FEW)
    assert facts["published"] == 79
    assert sum(facts["counts"].values()) == 97
    assert facts["counts"]["not reproduced"] == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.usefixtures("few")
def test_a_second_run_replaces_the_first_with_the_same_bytes(tmp_path):
    out = tmp_path / "out"
    write_reproduction(out)
    first = {path.name: path.read_bytes() for path in out.iterdir()}
    write_reproduction(out)
    assert {path.name: path.read_bytes() for path in out.iterdir()} == first


@pytest.mark.usefixtures("few")
def test_what_somebody_else_put_there_is_left_alone(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (out / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match="no reproduction of this program"):
        write_reproduction(out)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="is a file"):
        write_reproduction(tmp_path / "file")
    assert (out / "notes.txt").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "out"]


@pytest.mark.usefixtures("few")
def test_a_run_that_fails_leaves_the_earlier_result(tmp_path, monkeypatch):
    out = tmp_path / "out"
    write_reproduction(out)
    before = sorted(path.name for path in out.iterdir())

    def broken(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(_reproduction, "save_vector", broken)
    with pytest.raises(OutputError, match="No space left"):
        write_reproduction(out)
    assert sorted(path.name for path in out.iterdir()) == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs the processor time of a child")
def test_the_whole_of_it_takes_less_than_a_minute_of_one_processor(tmp_path):
    import resource

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "calibore", "reproduce", "--out", str(tmp_path / "out"), "--json"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert run.returncode == 0, run.stderr
    facts = json.loads(run.stdout)
    assert len(facts["pictures"]) == len(PICTURES)
    assert facts["counts"]["not reproduced"] == 0
    assert after.ru_utime - before.ru_utime < ALLOWED_S
