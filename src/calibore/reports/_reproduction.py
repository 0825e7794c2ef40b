"""What the source published beside what this program computes: numbers, pictures, one page, one JSON file."""

import base64
import json
import multiprocessing
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from calibore.folders import listed_in, whole_folder
from calibore.plotting import published_number, published_picture, save_picture, save_vector
from calibore.published import MEANINGS, PICTURES, Reproduction, Verdict, reproduced

FORMAT, PAGE, FACTS = "calibore-reproduction/1", "reproduction.html", "reproduction.json"
SOURCE = (
    "M. K. Swanbom, Uncertainty and error in laser triangulation measurements for pipe profiling, doctoral "
    "dissertation, Louisiana Tech University, 2007"
)
ROUNDING = 1e-12
HOLDS = {True: "holds", False: "does not hold", None: "in part"}
Progress = Callable[[int, int], None]
Plain = dict[str, Any]


def write_reproduction(out: Path | str, *, workers: int = 1, progress: Progress | None = None) -> Plain:
    """Computes every published number anew, draws the tables and figures, and writes page, JSON and pictures to `out`.

    Returns what reproduction.json holds. `workers` processes draw; `progress` is told what is done, of how much. `out`
    appears when complete; it must be new, empty, or an earlier reproduction, which it replaces. Raises OutputError.
    """
    with whole_folder(out, listed_in(FACTS, FORMAT), what="reproduction") as folder:
        return _made(folder, workers, progress or (lambda done, total: None))


def _made(folder: Path, workers: int, progress: Progress) -> Plain:
    total = len(PICTURES) + 1
    progress(0, total)
    numbers = reproduced()
    progress(1, total)
    pictures = []
    for picture in _drawn(folder, workers):
        pictures.append(picture)
        progress(1 + len(pictures), total)
    facts = _facts(numbers, pictures)
    text = json.dumps(facts, indent=2, allow_nan=False) + "\n"
    (folder / FACTS).write_text(text, encoding="utf-8", newline="\n")
    (folder / PAGE).write_text(_page(numbers, facts, folder), encoding="utf-8", newline="\n")
    return facts


def _drawn(folder: Path, workers: int) -> Iterator[Plain]:
    """Every picture, in order, as it is done."""
    if workers <= 1:
        yield from (_draw(number, folder) for number in range(len(PICTURES)))
        return
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(workers, len(PICTURES)), mp_context=fresh) as pool:
        yield from pool.map(_draw, range(len(PICTURES)), [folder] * len(PICTURES))


def _draw(number: int, folder: Path) -> Plain:
    """Files of one picture, and what is to be said of it."""
    picture = PICTURES[number]()
    figure = published_picture(picture)
    files = [save_picture(figure, folder / f"{picture.name}.png").name]
    files.append(save_vector(figure, folder / f"{picture.name}.svg").name)
    claims = [{"says": claim.says, "holds": claim.holds, "ours": claim.ours} for claim in picture.claims]
    return {
        "name": picture.name,
        "number": published_number(picture.name),
        "title": picture.title,
        "note": picture.note,
        "claims": claims,
        "files": files,
    }


def _facts(numbers: Sequence[Reproduction], pictures: Sequence[Plain]) -> Plain:
    counts = Counter(str(one.verdict) for one in numbers)
    claims = Counter(HOLDS[claim["holds"]] for picture in pictures for claim in picture["claims"])
    return {
        "format": FORMAT,
        "source": SOURCE,
        "calibore": version("calibore"),
        "published": sum(one.value.published is not None for one in numbers),
        "counts": {str(verdict): counts[str(verdict)] for verdict in Verdict},
        "claims": {word: claims[word] for word in HOLDS.values()},
        "values": [one.as_plain() for one in numbers],
        "pictures": list(pictures),
        "files": [PAGE, *(name for picture in pictures for name in picture["files"])],
    }


def _page(numbers: Sequence[Reproduction], facts: Plain, folder: Path) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("reproduction.html.jinja").read_text(encoding="utf-8")
    rows = [_row(one) for one in numbers]
    pictures = [
        {**picture, "data": _encoded(folder / picture["files"][0]), "alt": f"{picture['number']}: {picture['title']}"}
        for picture in facts["pictures"]
    ]
    return environment.from_string(template).render(
        facts=facts,
        meanings={str(verdict): meaning for verdict, meaning in MEANINGS.items()},
        published=[row for row in rows if row["published"]],
        extra=[row for row in rows if not row["published"]],
        pictures=pictures,
        holds=HOLDS,
    )


def _encoded(path: Path) -> str:
    return base64.b64encode(path.read_bytes()).decode("ascii")


def _row(one: Reproduction) -> dict[str, str]:
    value = one.value
    shown = value.printed or ""
    if value.scanned:
        shown = f"{shown} (scan: {value.scanned})"
    return {
        "where": value.where,
        "what": value.what,
        "published": shown,
        "ours": f"{one.ours:.6g}",
        "difference": ""
        if one.difference is None
        else f"{one.difference if abs(one.difference) > ROUNDING else 0:+.2g}",
        "unit": value.unit,
        "verdict": str(one.verdict),
        "note": " ".join(part for part in (value.contradiction, value.note) if part),
    }
