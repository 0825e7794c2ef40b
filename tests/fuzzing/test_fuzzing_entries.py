"""Every reader reads a spoilt file or refuses it in a sentence; minutes of this: `python -m fuzzing`."""

import re
import sys
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT))  # the package `fuzzing` stands beside `tests`

from calibore.errors import InputError  # noqa: E402
from fuzzing._entries import ENTRIES  # noqa: E402
from fuzzing._judging import fault_of  # noqa: E402
from fuzzing._ledger import Done, add, ledger, table  # noqa: E402
from fuzzing._mutations import mutated  # noqa: E402
from fuzzing._native import TARGETS  # noqa: E402
from fuzzing._trying import attempts, head_of  # noqa: E402

CALLS = {"results": 60, "scans": 40, "archives": 60, "calibrations": 60, "videos": 120}
OTHERWISE = 250
SEED = 7
PHOTOGRAPHS = {"targets": {"read_ring_pictures", "read_board_pictures", "read_two_pin"}}
"""Readers that need more than dark pictures: they come as far as these."""


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzzing")


@pytest.mark.parametrize("name", ENTRIES)
def test_a_spoilt_file_or_number_is_read_or_refused_in_a_sentence(name: str, home: Path) -> None:
    every = islice(attempts(name, home / name, seed=SEED), CALLS.get(name, OTHERWISE))
    assert {head_of(fault): fault for fault in every if fault} == {}


@pytest.mark.parametrize("name", [name for name, entry in ENTRIES.items() if hasattr(entry, "readers")])
def test_every_reader_accepts_something_that_is_not_spoilt(name: str, home: Path) -> None:
    """Or nothing but its first line would be tried."""
    entry, folders = ENTRIES[name], home / name / "seeds"
    entry.prepare(home / name)
    never = {read.__name__ for read in entry.readers if not any(accepts(read, one) for one in folders.iterdir())}
    assert never == PHOTOGRAPHS.get(name, set())


def accepts(read: Callable[[Path], object], folder: Path) -> bool:
    try:
        read(folder)
    except InputError:
        return False
    return True


def fails(error: Exception) -> object:
    raise error


def test_the_judge_tells_every_kind_of_fault() -> None:
    assert fault_of(lambda: 1) is None
    assert fault_of(lambda: fails(InputError("The file is empty; give another."))) is None
    for error, said in [
        (InputError("no full stop"), "no full stop"),
        (InputError(""), "empty"),
        (ValueError("of the code"), "ValueError at"),
        (RecursionError("deep"), "RecursionError at"),
        (MemoryError(), "MemoryError at"),
    ]:
        assert said in (fault_of(lambda error=error: fails(error)) or "")
    assert (fault_of(lambda: np.float64(1.0) / np.float64(0.0)) or "").startswith("warning at")


def test_the_same_seed_spoils_a_file_the_same_way_and_another_one_otherwise() -> None:
    data = b'format = "x"\n[a]\nb = 12\nc = [1, 2]\n' * 4
    first, again, other = (
        [mutated("a.toml", data, np.random.default_rng([s, i]), others=[data]) for i in range(50)] for s in (1, 1, 2)
    )
    assert first == again != other
    assert sum(one != data for one in first) > 40


def test_the_ledger_adds_up_over_runs(tmp_path: Path) -> None:
    add(tmp_path, "png", Done(10, 30.0, 1, 1))
    add(tmp_path, "png", Done(5, 60.0, 0, 1))
    assert ledger(tmp_path)["png"] == Done(15, 90.0, 1, 2)
    assert table(tmp_path)[-1] == "| png | 15 | 1.5 | 1 |"


def test_every_target_of_the_crate_is_an_entry() -> None:
    manifest = (ROOT / "native" / "fuzz" / "Cargo.toml").read_text(encoding="utf-8")
    assert sorted(re.findall(r'path = "targets/(\w+)\.rs"', manifest)) == sorted(TARGETS)
