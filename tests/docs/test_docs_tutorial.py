"""The tutorial is true: every block of it runs, in order, and prints what the page says it prints."""

import contextlib
import io
import os
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from markdown_pages import ROOT, Block, blocks, differences

TUTORIAL = ROOT / "docs" / "tutorial" / "first-profile.md"
LONGEST = 120  # s, for one block


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """[(block, what it printed)] of the tutorial, all run in one folder as a reader would."""
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed, so the shell blocks of the tutorial cannot be run")
    names: dict[str, Any] = {}
    with contextlib.chdir(tmp_path_factory.mktemp("tutorial")):
        runs = {"sh": shell, "python": lambda block: python(block, names)}
        return [(block, runs[block.language](block)) for block in blocks(TUTORIAL) if block.language in runs]


def shell(block: Block) -> str:
    """What `block` prints in a shell that finds this environment's commands; the current folder reads `...`."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", block.text],
        env=os.environ | {"PATH": path, "MPLBACKEND": "Agg", "LC_ALL": "C"},
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
    )
    assert done.returncode == 0, f"{TUTORIAL.name}, line {block.line}:\n{done.stderr}{done.stdout}"
    return done.stdout.replace(os.getcwd(), "...")


def python(block: Block, names: dict[str, Any]) -> str:
    """What `block` prints; `names` are those that earlier blocks have defined."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(block.text, f"{TUTORIAL.name}, line {block.line}", "exec"), names)
    return printed.getvalue()


def promises(page: list[Block]) -> dict[int, str]:
    """Line of a block -> the text block that follows it directly, which is what it prints."""
    return {
        first.line: second.text
        for first, second in pairwise(page)
        if first.language in ("sh", "python") and second.language == "text" and second.follows
    }


def test_every_block_prints_what_the_page_promises(ran):
    promised = promises(blocks(TUTORIAL))
    assert len(promised) >= 6
    wrong = [
        f"{TUTORIAL.name}, line {block.line}:\n{difference}"
        for block, printed in ran
        for difference in differences(promised.get(block.line, ""), printed)
    ]
    assert not wrong, "\n".join(wrong)


def test_every_text_block_is_a_promise_of_the_block_before_it():
    page = blocks(TUTORIAL)
    assert sum(block.language == "text" for block in page) == len(promises(page))
    assert {block.language for block in page} == {"sh", "python", "text"}


@pytest.mark.parametrize(
    ("promised", "printed", "agree"),
    [
        ("D = 304.12 mm", "D = 304.13 mm\n", True),
        ("D = 304.12 mm", "D = 304.15 mm", False),
        ("4 stations", "5 stations", False),
        ("truth inside: yes", "truth inside: no", False),
        ("a\n...\nd 1.0", "a\nb\nc\nd 1.0", True),
        ("a\n...\nd 1.0", "a\nb\nc\nd 2.0", False),
        ("a", "a\nb", False),
        ("", "a", False),
    ],
)
def test_a_page_that_lies_is_found_out(promised, printed, agree):
    assert (differences(promised, printed) == []) == agree
