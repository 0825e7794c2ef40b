"""`write_report`: plain data in, one self-contained HTML page out."""

import base64
import os
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from calibore.errors import InputError, OutputError
from calibore.plotting import (
    DETECTED_LINE_CAPTION,
    DETECTED_LINE_TITLE,
    STANDARD_PICTURES,
    axial_unit,
    length_unit,
)
from calibore.reports._findings import flag_counts, key_numbers, limit_checks, span, worst_table
from calibore.reports._words import DEFINITIONS, UNCERTAINTY_STATEMENTS

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def write_report(
    folder: Path | str,
    *,
    summary: Mapping[str, Any],
    rings: Mapping[str, Any],
    pictures: Mapping[str, Path],
    unit: str = "mm",
    created: str | None = None,
    captions: Mapping[str, str] | None = None,
) -> Path:
    """Writes `folder`/report.html and returns its path.

    `rings`: columns of rings.csv. `pictures`: title -> PNG file, in the order of the page. `created`: a time to print;
    without it the page holds none, so that equal input gives equal bytes. `captions`: title -> caption, for pictures
    that are not the standard ones.

    `summary` needs "name" and "nominal_radius_m"; used when present: "command", "estimator", "versions" {name: text},
    "counts" {name: number}, "mean_diameter_m" and "u_mean_diameter_m", "limits" {"ovality_percent",
    "deflection_percent"}, "rig" {"configuration", "file", "lens", "calibration", "default_uncertainty" (bool or text),
    "parameters" [{"name", "value", "u", "unit"}]} in SI, "warnings" [sentence], "skipped" [{"image", "reason"}].

    Raises InputError for a missing key or picture, OutputError when the page cannot be written.
    """
    complete = _complete(summary)
    page = _render(
        {
            "summary": complete,
            "created": created,
            "unit": length_unit(unit).symbol,
            "axial": axial_unit(unit, span(rings)).symbol,
            "nominal": f"{2 * float(summary['nominal_radius_m']) / length_unit(unit).metres:.1f}",
            "key_numbers": key_numbers(rings, summary, unit=unit),
            "checks": limit_checks(rings, summary.get("limits") or {}),
            "pictures": _pictures(pictures, captions or {}),
            "worst": worst_table(rings, unit=unit, nominal_radius=float(summary["nominal_radius_m"])),
            "station_count": len(rings["station"]),
            "flags": flag_counts(rings),
            "parameters": _parameters(complete["rig"].get("parameters") or (), unit),
            "definitions": DEFINITIONS,
            "statements": UNCERTAINTY_STATEMENTS,
        }
    )
    return _write(Path(folder) / "report.html", page)


OPTIONAL: dict[str, Any] = {
    "command": None,
    "estimator": None,
    "versions": {},
    "counts": {},
    "warnings": [],
    "skipped": [],
}


RIG: dict[str, Any] = {
    "configuration": None,
    "file": None,
    "lens": None,
    "calibration": None,
    "default_uncertainty": False,
}


def _complete(summary: Mapping[str, Any]) -> dict[str, Any]:
    """`summary` with every key the template reads; raises InputError where a necessary one is missing."""
    missing = [key for key in ("name", "nominal_radius_m") if key not in summary]
    if missing:
        raise InputError(f"The summary of a report lacks {' and '.join(missing)}; add it.")
    found = {key: summary.get(key) or default for key, default in OPTIONAL.items()}
    return found | {"name": str(summary["name"]), "rig": RIG | dict(summary.get("rig") or {})}


def _render(values: dict[str, Any]) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("report.html.jinja").read_text(encoding="utf-8")
    return environment.from_string(template).render(values)


def _pictures(pictures: Mapping[str, Path], captions: Mapping[str, str]) -> list[dict[str, str]]:
    known = {picture.title: picture.caption for picture in STANDARD_PICTURES}
    known |= {DETECTED_LINE_TITLE: DETECTED_LINE_CAPTION} | dict(captions)
    return [
        {"title": title, "caption": known.get(title, ""), "data": _encoded(Path(path))}
        for title, path in pictures.items()
    ]


def _encoded(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"Picture {path} cannot be read ({error}); draw it before the report.") from error
    if not data.startswith(PNG_SIGNATURE):
        raise InputError(f"Picture {path} is not a PNG file; save it with calibore.plotting.save_picture.")
    return base64.b64encode(data).decode("ascii")


def _parameters(parameters: Any, unit: str) -> list[dict[str, str]]:
    """Rig parameters as text; lengths in the reader's unit."""
    scale = length_unit(unit)
    rows = []
    for one in parameters:
        factor, symbol = (1 / scale.metres, unit) if one.get("unit") == "m" else (1.0, one.get("unit") or "")
        u = one.get("u")
        rows.append(
            {
                "name": str(one["name"]),
                "value": f"{float(one['value']) * factor:.6g}",
                "u": "not stated" if u is None else f"{float(u) * factor:.2g}",
                "unit": symbol,
            }
        )
    return rows


def _write(path: Path, page: str) -> Path:
    """Written beside, then renamed: never half a page under the final name."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.write_text(page, encoding="utf-8", newline="\n")
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written ({error}); give a folder you may write to.") from error
    return path
