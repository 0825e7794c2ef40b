"""`write_comparison`: arrays, numbers, pictures and one page of two profiles compared."""

import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

from calibore import __version__
from calibore.comparison import Compared, numbers, write_arrays
from calibore.folders import listed_in, whole_folder
from calibore.plotting import comparison_pictures, length_unit
from calibore.reports._calibration_page import plain_numbers, saved_picture
from calibore.reports._comparison_words import answer, facts, motion_rows, radius_rows, region_rows

FORMAT = "calibore-comparison/1"
MARKER = "summary.json"
KNOWN = listed_in(MARKER, FORMAT)
METHOD = (
    "Points of the moving profile are brought onto the reference by the motion under which they fit best, robustly, "
    "with the calibration errors of both as unknowns; the uncertainty of the motion and of both calibrations is in "
    "every number. Between points of the reference its wall is interpolated, and what may lie between is counted."
)
CHANGE = (
    " What calibration errors of either epoch can explain is taken out before change is looked for. Means over windows "
    "of several sizes are compared with what noise gives anywhere on an unchanged pipe; what exceeds that is a region."
)


def write_comparison(
    make: Callable[[Path], Compared], out: Path | str, *, unit: str = "mm", pictures: bool = True
) -> dict[str, Any]:
    """Writes the folder `out`, all or nothing, in place of an earlier comparison only; returns what summary.json holds.

    `make` gets the folder that is being written, for what it has to put there (profiles of scans), and compares.
    """
    length_unit(unit)
    with whole_folder(out, KNOWN, what="comparison") as folder:
        found = make(folder)
        write_arrays(found, folder)
        drawn = comparison_pictures(found, unit=unit) if pictures else ()
        shown = [saved_picture(one, folder) for one in drawn]
        said = answer(found, unit)
        if pictures:
            (folder / "report.html").write_text(_page(found, said, shown, unit), encoding="utf-8", newline="\n")
        plain: dict[str, Any] = {"format": FORMAT, "calibore": __version__, "answer": said}
        plain |= {"warnings": list(found.warnings), **numbers(found)}
        plain["files"] = sorted([path.name for path in folder.iterdir()] + [MARKER])
        plain = plain_numbers(plain)
        text = json.dumps(plain, indent=1, allow_nan=False) + "\n"
        (folder / MARKER).write_text(text, encoding="utf-8", newline="\n")
    return plain


def _page(found: Compared, said: list[str], shown: list[dict[str, str]], unit: str) -> str:
    from jinja2 import Environment, StrictUndefined

    epochs = found.changes is not None
    words = {
        "title": "Two epochs compared" if epochs else "A measurement compared with a reference",
        "subtitle": f"{found.names[0]} minus {found.names[1]}.",
        "sentences": said,
        "warnings": found.warnings,
        "facts": facts(found, unit),
        "regions": region_rows(found, unit),
        "motion": motion_rows(found, unit),
        "radii": () if epochs else radius_rows(found, unit),
        "pictures": shown,
        "method": METHOD + CHANGE * epochs,
        "unit": unit,
        "version": __version__,
        "rates": found.years is not None,
    }
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("comparison.html.jinja").read_text(encoding="utf-8")
    return environment.from_string(template).render(**words)
