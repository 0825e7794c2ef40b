"""The tutorial is true: every block of it runs, in order, and prints what the page says it prints."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from markdown_pages import ROOT, Block, blocks, differences

TUTORIAL = ROOT / "docs" / "tutorial" / "first-profile.md"
LONGEST = 120  # s, for one block


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """[(block, what it printed)] of the tutorial, all run in one folder as a reader would."""
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed, so the shell blocks of the tutorial cannot be run")
    folder = tmp_path_factory.mktemp("tutorial")
    return list(zip(*run_all(blocks(TUTORIAL), folder), strict=True))


def run_all(page: list[Block], folder: Path) -> tuple[list[Block], list[str]]:
    """Runs sh and python blocks of `page` in `folder`; python blocks see what earlier ones have defined."""
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": os.pathsep.join(p for p in sys.path if p),
        "MPLBACKEND": "Agg",
    }
    todo, printed, before = [b for b in page if b.language in ("sh", "python")], [], ""
    for block in todo:
        if block.language == "sh":
            command = ["bash", "-euo", "pipefail", "-c", block.text]
        else:
            mark = "print('-- this block --')\n"
            command, before = [sys.executable, "-c", before + mark + block.text], before + block.text
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
        )
        assert done.returncode == 0, f"{TUTORIAL.name}, line {block.line}:\n{done.stderr}{done.stdout}"
        printed.append(done.stdout.rpartition("-- this block --\n")[2])
    return todo, printed


def promises(page: list[Block]) -> dict[int, str]:
    """Line of a block -> the text block that follows it directly, which is what it prints."""
    return {
        first.line: second.text
        for first, second in zip(page, page[1:], strict=False)
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
