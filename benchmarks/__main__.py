"""`python -m benchmarks`: all speed tables as Markdown, on standard output and in benchmarks/out/report.md.

`python -m benchmarks NAME [ARGUMENTS]` makes one table of `PARTS`; docs/how-to/benchmark.md says how to read them.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import NamedTuple


class Part(NamedTuple):
    """A table: `function` of a module here; on one core; in the report, or a study of minutes that is asked for;
    taken once in either state of the C library's `memory`, on which peers depend.
    """

    function: str
    arguments: tuple[object, ...] = ()
    pinned: bool = False
    in_report: bool = False
    memory: bool = False


KEPT = {"MALLOC_MMAP_THRESHOLD_": str(256 << 20), "MALLOC_TRIM_THRESHOLD_": str(512 << 20)}
MEMORY: dict[str, dict[str, str]] = {"Memory left to the C library": {}, "Memory kept by the process": KEPT}
"""What glibc does with freed large arrays depends on what the process has done before, unless it is told."""

PARTS = {
    "kernel": Part("kernel.report", pinned=True, in_report=True, memory=True),
    "kernel_peers": Part("kernel_peers.rings", pinned=True, in_report=True, memory=True),
    "side_facing": Part("side_facing.report", pinned=True, in_report=True, memory=True),
    "side_facing_peers": Part("kernel_peers.rows", pinned=True, in_report=True, memory=True),
    "tracked": Part("tracked.report", pinned=True, in_report=True, memory=True),
    "triangulation": Part("triangulation.report", in_report=True),
    "end_to_end_one": Part("end_to_end.report", (1,), pinned=True, in_report=True, memory=True),
    "end_to_end_two": Part("end_to_end.report", (2,), in_report=True, memory=True),
    "end_to_end_parts": Part("end_to_end_parts.report", pinned=True, in_report=True),
    "decode": Part("end_to_end.decoding", pinned=True, in_report=True),
    "startup": Part("startup.report", in_report=True),
    "archive": Part("archive.report", pinned=True),
    "calibration": Part("calibration.report"),
    "change": Part("change.report"),
    "change_pictures": Part("change_pictures.report"),
    "cluster": Part("cluster.report"),
    "coverage": Part("studies.coverage"),
    "estimator": Part("estimator.report"),
    "every_rig": Part("every_rig.report"),
    "line_choice": Part("line_choice.report"),
    "ovality": Part("studies.ovality"),
    "pictures": Part("every_rig.pictures"),
    "prediction": Part("prediction.report"),
    "real_time": Part("real_time.report"),
}


def tables(name: str, *rest: str) -> list[str]:
    """A part, each table of it in a process of its own so that pinning, threads and memory do not leak."""
    states = MEMORY if PARTS[name].memory and not any(key in os.environ for key in KEPT) else {"": {}}
    lines: list[str] = []
    for title, settings in states.items():
        command = [sys.executable, "-m", "benchmarks", "--alone", name, *rest]
        run = subprocess.run(command, check=True, capture_output=True, text=True, env=os.environ | settings)
        lines += [f"**{title}**", ""] * bool(title) + [run.stdout]
    return lines


def part(name: str, *rest: str) -> list[str]:
    """One table, in this process."""
    from benchmarks import timing

    chosen = PARTS[name]
    if chosen.pinned:
        timing.pin_to_one_core()
    module, function = chosen.function.split(".")
    return getattr(import_module(f"benchmarks.{module}"), function)(*chosen.arguments, *rest)


def main() -> None:
    """Run every part of the report, or the one named."""
    if sys.argv[1:2] == ["--alone"]:
        print("\n".join(part(*sys.argv[2:])))
        return
    if len(sys.argv) > 1:
        print("\n".join(tables(*sys.argv[1:])))
        return
    from benchmarks.machine import machine

    lines = ["# Benchmarks", "", *machine()]
    for name in (name for name, one in PARTS.items() if one.in_report):
        lines += tables(name)
    out = Path(__file__).parent / "out" / "report.md"
    out.parent.mkdir(exist_ok=True)
    out.write_text("\n".join(lines), encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
