"""The house rules, checked: layers, file sizes, public names."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "src" / "calibore"
MODULES = sorted(SOURCE.rglob("*.py"))
PACKAGES = sorted(path.parent.name for path in SOURCE.glob("*/__init__.py"))
LONGEST = 260
FORBIDDEN = {"core", "utils", "common", "helpers", "misc"}


def test_packages_import_only_what_stands_below_them():
    linter = Path(sys.executable).with_name("lint-imports")
    run = subprocess.run([linter], cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_a_file_holds_one_idea(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_packages_are_nouns_of_the_trade():
    assert not FORBIDDEN & {path.stem for path in MODULES} | FORBIDDEN & set(PACKAGES)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_begins_with_its_table_of_contents(package):
    module = importlib.import_module(f"calibore.{package}")
    assert module.__doc__
    assert module.__all__
    for name in module.__all__:
        thing = getattr(module, name)
        assert getattr(thing, "__doc__", None) or not callable(thing), f"{package}.{name} has no docstring"


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_modules_below_a_package_are_private(path):
    if path.parent != SOURCE:
        assert path.stem.startswith("_")


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_no_argument_after_the_second_is_positional_and_boolean(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            for argument in node.args.args:
                kind = ast.unparse(argument.annotation) if argument.annotation else ""
                allowed = kind != "bool" or path.parent.name == "cli"
                assert allowed, f"{path.name}: {node.name}({argument.arg}) is a positional boolean"
