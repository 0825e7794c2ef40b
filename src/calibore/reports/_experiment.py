"""`write_experiment`: numbers, pictures and one page of the experiment, in the folder that it grew in."""

import json
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import Any

from calibore import __version__
from calibore.experiment import INCH, Judgement, Outcome
from calibore.plotting import experiment_pictures
from calibore.reports._calibration_page import plain_numbers, saved_picture
from calibore.reports._experiment_tables import experiment_tables
from calibore.reports._experiment_words import answers, claims

FORMAT, FACTS, PAGE = "calibore-experiment/1", "experiment.json", "experiment.html"
HOLDS = {True: "holds", False: "does not hold", None: "in part"}


def write_experiment(found: Outcome, out: Path | str) -> dict[str, Any]:
    """Writes experiment.json, experiment.html and the pictures into `out`; returns what the JSON file holds."""
    out = Path(out)
    said, tables, texts = answers(found), list(experiment_tables(found)), claims(found)
    shown = [saved_picture(one, out) for one in experiment_pictures(found)]
    plain = plain_numbers(
        {
            "format": FORMAT,
            "calibore": __version__,
            "plan": found.plan.as_plain(),
            "answer": said,
            "instruments": {laser.name: _laser(laser) for laser in found.lasers},
            "tactile": _judgement(found.touch_errors),
            "claims": [asdict(claim) for claim in texts],
            "tables": [asdict(table) for table in tables],
        }
    )
    _write(out / FACTS, json.dumps(plain, indent=1, allow_nan=False) + "\n")
    words = {
        "sentences": said,
        "claims": [{**asdict(claim), "verdict": HOLDS[claim.holds]} for claim in texts],
        "tables": tables,
        "pictures": shown,
        "plan": found.plan,
        "version": __version__,
    }
    _write(out / PAGE, _page(words))
    return plain


def _laser(laser: Any) -> dict[str, Any]:
    motion = laser.registration
    return {
        "against_truth": {name: _judgement(one) for name, one in laser.by_truth.items()},
        "against_tactile": {name: _judgement(one) for name, one in laser.by_touch.items()},
        "on_plain_wall": _judgement(laser.on_plain_wall),
        "missed": laser.missed,
        "scale": None if laser.scale is None else [laser.scale.value, laser.scale.u],
        "motion": {name: [getattr(motion.motion, name), motion.u(name)] for name in motion.names},
    }


def _judgement(one: Judgement) -> dict[str, float]:
    return {
        "points": one.value.size,
        "outliers": one.outliers,
        "rms_in": one.rms / INCH,
        "predicted_in": one.predicted / INCH,
        "spread_in": one.spread / INCH,
        "relative": one.relative,
        "inside_95": one.inside,
    }


def _write(path: Path, text: str) -> None:
    """A reader finds the old page or the new one."""
    partial = path.with_name(f".{path.name}.partial")
    partial.write_text(text, encoding="utf-8", newline="\n")
    partial.replace(path)


def _page(words: dict[str, Any]) -> str:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    template = files("calibore.reports").joinpath("experiment.html.jinja").read_text(encoding="utf-8")
    return environment.from_string(template).render(**words)
