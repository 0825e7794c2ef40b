"""A folder of pictures, numbers and one page, for whatever there is to say of calibrations."""

import base64
import json
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from calibore import __version__
from calibore.folders import listed_in, whole_folder
from calibore.plotting import DesignPicture, save_picture, save_vector

DIGITS = 9
TABLES = ("warnings", "parameters", "models", "changes", "steps", "ranking", "refused")
"""What a page may leave out."""


def write_page(
    out: Path | str, name: str, *, words: dict[str, Any], data: dict[str, Any], pictures: Iterable[DesignPicture]
) -> Path:
    """Writes `out`/NAME.json, NAME.html and every picture as PNG and SVG, all or nothing; returns the page's path.

    `words`: what the template shows, of `TABLES` those that there are; `data`: numbers in SI, written with their
    "format" and the "files" beside them.
    """
    marker, page, form = f"{name}.json", f"{name}.html", f"calibore-{name}-page/1"
    with whole_folder(out, listed_in(marker, form), what=f"{name} page") as folder:
        shown = [saved_picture(picture, folder) for picture in pictures]
        text = _filled(dict.fromkeys(TABLES, ()) | words | {"pictures": shown, "version": __version__})
        (folder / page).write_text(text, encoding="utf-8", newline="\n")
        listed = sorted([path.name for path in folder.iterdir()] + [marker])
        plain = {"format": form, "calibore": __version__, **data, "files": listed}
        text = json.dumps(plain_numbers(plain), indent=1, allow_nan=False) + "\n"
        (folder / marker).write_text(text, encoding="utf-8", newline="\n")
    return Path(out) / page


def plain_numbers(value: Any) -> Any:
    """Arrays as lists, numbers with nine digits, what is not finite as None."""
    if isinstance(value, dict):
        return {str(key): plain_numbers(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain_numbers(value.tolist())
    if isinstance(value, list | tuple):
        return [plain_numbers(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def saved_picture(picture: DesignPicture, folder: Path) -> dict[str, str]:
    """`picture` as PNG and SVG in `folder`; its words and data for a page."""
    path = save_picture(picture.figure, folder / f"{picture.name}.png")
    picture.figure.set_layout_engine("none")  # it is laid out; doing so again takes as long as drawing
    save_vector(picture.figure, folder / f"{picture.name}.svg")
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return {"title": picture.title, "caption": picture.caption, "data": data}


def _filled(words: dict[str, Any]) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("calibration.html.jinja").read_text(encoding="utf-8")
    return environment.from_string(template).render(**words)
