"""`python -m benchmarks`: all speed tables as Markdown, on standard output and in benchmarks/out/report.md.

`python -m benchmarks coverage`, `ovality`, `every_rig`, `pictures`, `calibration`, `change` and `change_pictures` run
the long accuracy studies instead (minutes each), `cluster` two Dask workers against one,
`archive` pictures from archives against PNG files, `real_time` films and archives against ten times the densest system.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

PACKAGES = ("calibore", "numpy", "opencv-python-headless", "uncertainties")
PARTS = ("kernel", "side_facing", "triangulation", "end_to_end_one", "end_to_end_two", "decode", "startup")


def part(name: str, *rest: str) -> list[str]:
    """One table, in a process of its own so that pinning and threads do not leak."""
    from benchmarks import (
        archive,
        calibration,
        change,
        change_pictures,
        cluster,
        end_to_end,
        every_rig,
        kernel,
        line_choice,
        prediction,
        real_time,
        side_facing,
        startup,
        studies,
        timing,
        triangulation,
    )

    if name in ("kernel", "side_facing", "end_to_end_one", "decode", "archive"):
        timing.pin_to_one_core()
    tables = {
        "archive": archive.report,
        "kernel": kernel.report,
        "side_facing": side_facing.report,
        "end_to_end_one": lambda: end_to_end.report(1),
        "end_to_end_two": lambda: end_to_end.report(2),
        "decode": end_to_end.decoding,
        "startup": startup.report,
        "triangulation": triangulation.report,
        "calibration": lambda: calibration.report(*rest),
        "change": lambda: change.report(*rest),
        "change_pictures": lambda: change_pictures.report(*rest),
        "cluster": cluster.report,
        "coverage": studies.coverage,
        "ovality": studies.ovality,
        "every_rig": every_rig.report,
        "pictures": every_rig.pictures,
        "real_time": real_time.report,
        "line_choice": lambda: line_choice.report(*rest),
        "prediction": lambda: prediction.report(*rest),
    }
    return tables[name]()


def main() -> None:
    """Run every part, or the one named."""
    if len(sys.argv) > 1:
        print("\n".join(part(*sys.argv[1:])))
        return
    load = f"{os.getloadavg()[0]:.2f}" if hasattr(os, "getloadavg") else "unknown"
    machine = (
        f"{platform.machine()}, {os.cpu_count()} cores, load {load} at the start, Python {platform.python_version()}"
    )
    lines = ["# Benchmarks", f"{machine}; " + ", ".join(f"{name} {version(name)}" for name in PACKAGES), ""]
    for name in PARTS:
        run = subprocess.run([sys.executable, "-m", "benchmarks", name], check=True, capture_output=True, text=True)
        lines += [run.stdout]
    out = Path(__file__).parent / "out" / "report.md"
    out.parent.mkdir(exist_ok=True)
    out.write_text("\n".join(lines), encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
