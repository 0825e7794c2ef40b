"""`calibore reproduce --experiment`: whose folder it may use, and which options belong to it."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "system"))
from command_line import calibore


def test_options_of_the_experiment_need_it(tmp_path):
    for option in (("--keep-pictures",), ("--scheduler", "tcp://127.0.0.1:1")):
        failed = calibore("reproduce", "--out", tmp_path / "out", *option)
        assert failed.status == 2
        assert failed.sentence == "--scheduler and --keep-pictures belong to --experiment; add it."


def test_an_unknown_size_is_told():
    failed = calibore("reproduce", "--experiment", "--out", "out", "--size", "huge")
    assert failed.status == 2
    assert "reduced" in failed.err


def test_the_experiment_leaves_other_folders_alone(tmp_path):
    (tmp_path / "thesis.txt").write_text("years of work")
    failed = calibore("reproduce", "--experiment", "--out", tmp_path)
    assert failed.status == 1
    assert failed.sentence.endswith("choose an empty or new folder for the experiment.")
