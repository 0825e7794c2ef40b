"""What a benchmark ran on, as far as the system tells."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = (
    *("calibore", "numpy", "scipy", "opencv-python-headless", "scikit-image", "numba", "uncertainties", "py4dgeo"),
    *("pillow", "av", "zarr", "numcodecs", "xarray", "distributed"),
)
CORE = Path("/sys/devices/system/cpu/cpu0")


def machine() -> list[str]:
    """Markdown lines: processor, caches, how its clock is governed, load, versions of everything that is timed."""
    load = f"{os.getloadavg()[0]:.2f}" if hasattr(os, "getloadavg") else "unknown"
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    rows = {
        "processor": f"{_processor()}, {usable} cores",
        "caches": ", ".join(_caches()) or "unknown",
        "governor": _text(CORE / "cpufreq" / "scaling_governor") or "unknown (a virtual machine does not tell)",
        "load at the start": load,
        "system": f"{platform.system()} {platform.release()} {platform.machine()}, Python {platform.python_version()}",
        "packages": ", ".join(f"{name} {_version(name)}" for name in PACKAGES),
    }
    return ["| | |", "|---|---|", *(f"| {name} | {said} |" for name, said in rows.items()), ""]


def _processor() -> str:
    lines = _text(Path("/proc/cpuinfo")).splitlines()
    said = dict(line.split(":", 1) for line in lines if ":" in line)
    models = [value.strip() for key, value in said.items() if key.strip() == "model name"]
    flags = next((value.split() for key, value in said.items() if key.strip() == "flags"), [])
    wide = [name for name in ("avx2", "avx512f") if name in flags]
    return f"{models[0] if models else platform.processor() or 'unknown'} ({', '.join(wide) or 'no AVX2'})"


def _caches() -> list[str]:
    found = []
    for index in sorted((CORE / "cache").glob("index*")):
        kind = {"Data": "d", "Instruction": "i"}.get(_text(index / "type"), "")
        found.append(f"L{_text(index / 'level')}{kind} {_text(index / 'size')}")
    return found


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip()
    except OSError:
        return ""


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "absent"
