"""The targets of native/fuzz: built with libFuzzer and AddressSanitizer, and their corpora."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

from fuzzing._pictures import PICTURES, arguments, pictures

CRATE = Path(__file__).parents[1] / "native" / "fuzz"
TARGET = "x86_64-unknown-linux-gnu"
COVERAGE = ("level=4", "inline-8bit-counters", "pc-table", "trace-compares")
FLAGS = " ".join(
    [
        "--cfg fuzzing -Zsanitizer=address -Cpasses=sancov-module",
        *(f"-Cllvm-args=-sanitizer-coverage-{kind}" for kind in COVERAGE),
    ]
)
LARGEST = {"png": 4096, "jpeg": 8192, "tiff": 4096, "bmp": 2048, "ring": 2048, "line": 2048}
"""Bytes of an input, where 4096 are not right."""
TARGETS = ("jpeg", "tiff", "png", "ring", "line", "measure", "draw", "bmp", "pnm")
"""In the order of the risk."""


def build() -> None:
    """All targets, in minutes the first time; the stable compiler knows the flags if it is told to."""
    env = os.environ | {"RUSTC_BOOTSTRAP": "1", "RUSTFLAGS": FLAGS, "PYO3_PYTHON": sys.executable}
    subprocess.run(["cargo", "build", "--release", "--quiet", "--target", TARGET], cwd=CRATE, env=env, check=True)


def command(name: str, home: Path, *, seed: int) -> list[str]:
    """That fuzzes a target until SIGINT; its corpus is begun where there is none."""
    corpus, found = home / name / "corpus", home / name / "found"
    found.mkdir(parents=True, exist_ok=True)
    if not corpus.is_dir():
        corpus.mkdir()
        for number, one in enumerate(pictures(name) if name in PICTURES else arguments()):
            (corpus / f"seed-{number:03d}").write_bytes(one)
    limits = ["-rss_limit_mb=2048", "-malloc_limit_mb=512", "-timeout=1000000", f"-max_len={LARGEST.get(name, 4096)}"]
    binary = CRATE / "target" / TARGET / "release" / name
    return [str(binary), str(corpus), f"-artifact_prefix={found}/", f"-seed={seed}", "-print_final_stats=1", *limits]


def environment() -> dict[str, str]:
    """The targets are linked to Python's library, none of which they call."""
    library = sysconfig.get_config_var("LIBDIR") or ""
    paths = ":".join(filter(None, (library, os.environ.get("LD_LIBRARY_PATH", ""))))
    return os.environ | {"LD_LIBRARY_PATH": paths, "ASAN_OPTIONS": "detect_leaks=0"}
