"""What the command line prints: units, numbers that are not there, and who gets to see it."""

import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import pytest
import typer

from calibore.cli import app
from calibore.cli._failure import INTERRUPTED, telling_failures, wrong_usage
from calibore.cli._profile import as_json, brief, progress_bar, tell
from calibore.errors import CaliboreError, ImageError, InputError, OutputError, UsageError

NAN = float("nan")


def summary(**more: Any) -> dict[str, Any]:
    """Of a 12 in pipe: 0.3048 m."""
    worst = {
        "station": 7,
        "axial_m": 2.54,
        "ovality_f1216_max_percent": 1.0,
        "u_ovality_f1216_max_percent": 0.1,
        "ovality_f1216_min_percent": 2.0,
        "u_ovality_f1216_min_percent": 0.2,
        "deflection_percent": 3.0,
        "u_deflection_percent": 0.3,
    }
    return {
        "counts": {"stations": 10, "images": 20, "refused_images": 0},
        "fraction_measured": 0.987,
        "mean_diameter_m": 0.3048,
        "u_mean_diameter_m": 0.000127,
        "worst_stations": [worst],
        "warnings": [],
    } | more


def test_lengths_are_printed_in_the_unit_asked_for():
    assert "Mean diameter 304.800 mm (U95 0.254)." in list(brief(summary(), "mm"))
    assert "Mean diameter 12.0000 in (U95 0.0100)." in list(brief(summary(), "in"))
    assert any("at station 7, 2540.0 mm;" in line for line in brief(summary(), "mm"))
    assert any("at station 7, 100.0 in;" in line for line in brief(summary(), "in"))


def test_the_worse_of_the_two_ovalities_is_told_with_its_own_uncertainty():
    assert any(line.startswith("Worst ovality 2.00 % (U95 0.40)") for line in brief(summary(), "mm"))


def test_one_station_is_not_one_stations():
    counts = {"stations": 1, "images": 1, "refused_images": 0}
    assert next(brief(summary(counts=counts), "mm")).startswith("1 station from 1 image, 98.7 %")


def test_what_was_not_measured_is_not_printed():
    nothing = {key: NAN if key.endswith("percent") else 1 for key in summary()["worst_stations"][0]}
    lines = list(brief(summary(mean_diameter_m=NAN, u_mean_diameter_m=NAN, worst_stations=[nothing]), "mm"))
    assert lines == ["10 stations from 20 images, 98.7 % of all positions measured."]
    assert len(list(brief(summary(worst_stations=[]), "mm"))) == 2


def test_json_is_valid_whatever_is_not_a_number():
    value = {"a": NAN, "b": [float("inf"), {"c": (NAN, 1.5)}], "d": "nan", "e": "Größe", "f": None, "g": True}
    text = as_json(value)
    assert text.isascii()
    strict = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    assert strict == {"a": None, "b": [None, {"c": [None, 1.5]}], "d": "nan", "e": "Größe", "f": None, "g": True}


@pytest.mark.parametrize("as_text", [False, True])
def test_warnings_go_to_standard_error_and_results_to_standard_output(tmp_path, as_text):
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        tell(summary(warnings=["Mind the gap."]), tmp_path, unit="mm", json=as_text)
    assert err.getvalue() == "Warning: Mind the gap.\n"
    assert "304.8" in out.getvalue() or json.loads(out.getvalue())["mean_diameter_m"] == 0.3048
    assert "Mind the gap" not in out.getvalue() or as_text


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (InputError("This is wrong."), 1),
        (ImageError("This is wrong."), 1),
        (OutputError("This is wrong."), 1),
        (UsageError("This is wrong."), 2),
        (CaliboreError("This is wrong."), 1),
    ],
)
def test_every_error_raised_on_purpose_is_its_sentence_and_its_status(capsys, error, status):
    with pytest.raises(SystemExit) as left, telling_failures():
        raise error
    assert left.value.code == status
    assert capsys.readouterr() == ("", "calibore: This is wrong.\n")


def test_what_the_system_refuses_is_told_with_its_path(capsys):
    with pytest.raises(SystemExit) as left, telling_failures():
        Path("/nowhere/at/all").read_text(encoding="utf-8")
    assert left.value.code == 1
    assert capsys.readouterr().err == (
        "calibore: /nowhere/at/all: No such file or directory; check that path and its permissions.\n"
    )


@pytest.mark.parametrize("interruption", [KeyboardInterrupt(), SystemExit(INTERRUPTED)])
def test_an_interruption_is_told_and_has_its_status(capsys, interruption):
    with pytest.raises(SystemExit) as left, telling_failures():
        raise interruption
    assert left.value.code == INTERRUPTED
    assert "interrupted; the result folder is as it was" in capsys.readouterr().err


def test_a_fault_of_this_program_is_not_hidden():
    with pytest.raises(ZeroDivisionError), telling_failures():
        raise ZeroDivisionError


def test_what_the_command_line_alone_shows_to_be_wrong_is_wrong_usage():
    with pytest.raises(UsageError, match="not known"), wrong_usage():
        raise InputError('Unit "furlong" is not known.')


def test_a_reader_that_has_gone_away_is_no_failure_to_report():
    program = "import sys; sys.argv = ['calibore', '--help']; from calibore.cli import main; main()"
    read, write = os.pipe()
    os.close(read)
    run = subprocess.run([sys.executable, "-c", program], stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert "Traceback" not in run.stderr


def test_no_progress_is_drawn_where_nobody_is_watching(capsys, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress_bar("Profiling", quiet=False) as progress:
        assert progress is None
    assert capsys.readouterr() == ("", "")


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
def test_progress_is_drawn_on_a_terminal_and_only_where_errors_go():
    program = (
        "from calibore.cli._profile import progress_bar\n"
        "for quiet in (False, True):\n"
        "    with progress_bar('Measuring', quiet=quiet) as progress:\n"
        "        progress and progress(3, 7)\n"
    )
    ours, theirs = os.openpty()
    run = subprocess.run(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        stderr=theirs,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "100"},
        check=True,
    )
    os.close(theirs)
    shown = os.read(ours, 65536).decode()
    os.close(ours)
    assert run.stdout == b""
    assert "Measuring" in shown
    assert "3/7" in shown


def test_every_verb_and_option_says_what_it_is_for():
    command = typer.main.get_command(app)
    assert {"profile", "demo", "export"} <= set(command.commands)  # pyright: ignore[reportAttributeAccessIssue]
    for verb in command.commands.values():  # pyright: ignore[reportAttributeAccessIssue]
        assert verb.help
        assert all(parameter.help for parameter in verb.params if parameter.name != "help")


def test_the_help_names_every_estimator_and_export_format_there_is():
    from calibore.errors import UsageError
    from calibore.scans import check_format
    from calibore.stripe import Estimator

    verb = typer.main.get_command(app).commands["profile"]  # pyright: ignore[reportAttributeAccessIssue]
    told = {parameter.name: parameter.help for parameter in verb.params}
    for estimator in Estimator:
        if estimator is not Estimator.CROSSING:
            assert estimator.label in told["estimator"]
    with pytest.raises((InputError, UsageError)) as wrong:
        check_format("docx")
    for name in str(wrong.value).split("allowed: ")[1].rstrip(".").split(", "):
        assert name in told["exports"]
