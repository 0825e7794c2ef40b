"""A tactile scan that names no probe, but stands beside what calibrates one: the command makes the calibration."""

import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from calibore.profiling import Finisher, Sealed
    from calibore.rigs import Probe

FILE = "probe.toml"


@dataclass(frozen=True)
class MadeProbe:
    """A `probe` and the `folder` that holds its file and evidence."""

    probe: "Probe"
    folder: Path

    def put_beside(self, finisher: "Finisher | None") -> "Finisher":
        """`finisher`, after the calibration has become part of the result."""

        def finish(sealed: "Sealed") -> None:
            shutil.copytree(self.folder, sealed.folder, dirs_exist_ok=True)
            sealed.summary["rig"]["file"] = FILE
            if finisher:
                finisher(sealed)

        return finish


@contextmanager
def probe_made_from(scan: Path) -> Iterator[MadeProbe | None]:
    """The probe calibrated from target.toml of kind "probe" in the folder of a tactile `scan` that names none; None
    where there is nothing of the kind. Says on standard error what it did.
    """
    target = _target(scan)
    if target is None:
        yield None
        return
    from calibore.calibration import calibrate, write_calibration
    from calibore.rigs import read_probe

    with TemporaryDirectory() as folder:
        found = calibrate("probe", target)
        write_calibration(found, Path(folder) / FILE)
        typer.echo(f"scan.toml names no probe; calibrated one from {target}: {found.findings[0]}", err=True)
        for warning in found.warnings:
            typer.echo(f"Warning: {warning}", err=True)
        yield MadeProbe(read_probe(Path(folder) / FILE), Path(folder))


def _target(scan: Path) -> Path | None:
    """The target.toml that calibrates the probe of `scan`, where it is needed."""
    from calibore.scans import read_scan

    spec = read_scan(scan)
    target = spec.folder / "target.toml"
    if spec.tactile is None or spec.tactile.probe is not None or not target.is_file():
        return None
    with suppress(tomllib.TOMLDecodeError, UnicodeDecodeError):
        return target if tomllib.loads(target.read_text(encoding="utf-8")).get("kind") == "probe" else None
    return target
