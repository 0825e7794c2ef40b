"""Starting costs nothing: no verb imports what it does not need, and help needs nothing at all."""

import subprocess
import sys

import pytest
import typer

from calibore.cli import app
from calibore.cli._help import help_text

HEAVY = ("numpy", "scipy", "pydantic", "matplotlib", "xarray", "zarr", "av", "pint", "jinja2", "laspy", "PIL", "cv2")
HELP_TAKES = 0.3
"""Seconds; of the processor, because the tests run beside each other."""


def imported_by(statement: str) -> set[str]:
    """Top-level packages that a new interpreter has imported after `statement`."""
    program = f"import sys\n{statement}\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(run.stdout.splitlines()[-1].split())


@pytest.mark.parametrize("statement", ["import calibore", "import calibore.cli", "import calibore.errors"])
def test_importing_the_package_or_its_command_line_imports_nothing_heavy(statement):
    assert not imported_by(statement) & set(HEAVY)


def test_the_package_alone_imports_none_of_its_parts_and_not_the_command_line():
    assert "typer" not in imported_by("import calibore")
    program = "import sys, calibore; print(*[name for name in sys.modules if name.startswith('calibore.')])"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []


def commands(group=None, before=()):
    """The words of every verb and of every group of verbs."""
    group = group or typer.main.get_command(app)
    found = [before]
    for name, command in group.commands.items():
        found += commands(command, (*before, name)) if hasattr(command, "commands") else [(*before, name)]
    return found


EVERY_VERB = pytest.mark.parametrize("verb", commands(), ids=" ".join)


@EVERY_VERB
def test_help_is_shown_without_importing_anything_heavy(verb):
    statement = f"import sys; sys.argv = {['calibore', *verb, '--help']!r}\nfrom calibore.cli import main\nmain()"
    assert not imported_by(statement) & set(HEAVY)


@EVERY_VERB
def test_help_is_that_of_the_program(verb, capsys):
    with pytest.raises(SystemExit):
        app([*verb, "--help"], prog_name="calibore")
    assert capsys.readouterr().out == f"{help_text(app, [*verb, '--help'])}\n"


def test_who_asks_for_no_help_or_for_that_of_no_verb_gets_none():
    assert help_text(app, ["profile", "scan"]) is None
    assert help_text(app, ["measure", "--help"]) is None


@pytest.mark.skipif(sys.platform == "win32", reason="needs the processor time of a child")
def test_help_is_there_at_once():
    def seconds() -> float:
        import resource

        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-m", "calibore", "profile", "--help"], capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    assert min(seconds() for _ in range(3)) < HELP_TAKES


def test_an_export_needs_neither_pictures_nor_video():
    needed = imported_by(
        "import sys; sys.argv = ['calibore', 'export', 'nowhere', 'ply']\n"
        "from calibore.cli import main\n"
        "try:\n    main()\nexcept SystemExit: pass"
    )
    assert not needed & {"matplotlib", "av"}
