"""The page of a comparison says the answer first, and the folder is whole or not there."""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "comparison"))
from compared_walls import found

from calibore.errors import InputError, OutputError
from calibore.reports import write_comparison


@pytest.fixture(scope="module", params=[True, False], ids=["change", "error"])
def folder(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("compared") / "out"
    write_comparison(lambda _: found(epochs=request.param), out, unit="mm")
    return request.param, out


def words(out):
    page = (out / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?://|url\(|@import|<script|<link", page)
    return " ".join(re.sub(r"<[^>]+>", " ", re.sub(r"<style>.*?</style>", "", page, flags=re.DOTALL)).split())


def test_the_answer_comes_first(folder):
    epochs, out = folder
    text, summary = words(out), json.loads((out / "summary.json").read_text(encoding="utf-8"))
    first = summary["answer"][0]
    assert first.startswith("The wall has changed at one place" if epochs else "later against earlier: rms error")
    assert first in text
    assert text.index(first) < 200
    assert ("per year" in text) == epochs


def test_the_summary_lists_what_is_there(folder):
    _, out = folder
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["files"] == sorted(path.name for path in out.iterdir())
    assert {"difference.zarr", "rings.csv", "report.html", "difference.png", "difference.svg"} <= set(summary["files"])


def test_an_unchanged_wall_says_what_could_not_have_escaped(tmp_path):
    one = found(epochs=True)
    still = replace(one, changes=replace(one.changes, regions=()))
    summary = write_comparison(lambda _: still, tmp_path / "out", pictures=False)
    assert summary["answer"][0] == "No significant change of the wall."
    assert re.match(r"No change larger than [\d.]+ mm .* would have escaped", summary["answer"][1])


def test_what_goes_wrong_leaves_everything_as_it_was(tmp_path):
    out = tmp_path / "out"
    write_comparison(lambda _: found(epochs=False), out, pictures=False)
    before = (out / "summary.json").read_bytes()

    def fails(folder):
        (folder / "profile-a").mkdir()
        raise InputError("different pipes")

    with pytest.raises(InputError):
        write_comparison(fails, out)
    assert (out / "summary.json").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_only_an_earlier_comparison_is_replaced(tmp_path):
    (tmp_path / "mine.txt").touch()
    with pytest.raises(OutputError, match=r"mine\.txt"):
        write_comparison(lambda _: found(epochs=False), tmp_path, pictures=False)
    for _ in range(2):
        write_comparison(lambda _: found(epochs=False), tmp_path / "out", pictures=False)
