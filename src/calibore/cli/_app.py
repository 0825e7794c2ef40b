"""The `calibore` command and its verbs."""

import sys
import warnings
from io import TextIOWrapper
from typing import Annotated

import typer

from calibore import __version__
from calibore.cli._calibrate import calibrate
from calibore.cli._compare import compare
from calibore.cli._demo import demo
from calibore.cli._design import design
from calibore.cli._export import export
from calibore.cli._failure import telling_failures
from calibore.cli._help import show_help
from calibore.cli._import import import_scan
from calibore.cli._live import live
from calibore.cli._profile import profile
from calibore.cli._reproduce import reproduce
from calibore.cli._simulate import simulate

app = typer.Typer(
    name="calibore",
    help="Measures the inside of pipes with laser light, and says how well.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"calibore {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


for verb in (demo, profile, live, compare, export, reproduce, simulate):
    app.command()(verb)
app.command("import")(import_scan)
app.add_typer(calibrate)
app.add_typer(design)


def main() -> None:
    """Entry point: runs the verb; a failure becomes one sentence and an exit status."""
    warnings.filterwarnings("ignore", module="zarr")  # remarks on its own storage format, of no use to a user
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name that the terminal cannot write must not end a run
    with telling_failures():
        if not show_help(app):
            app()
