"""How large the experiment is, and the note in its folder that says so."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from calibore.errors import InputError, OutputError
from calibore.experiment._published import INCH, INSTRUMENTS

FORMAT, NOTE = "calibore-experiment-plan/1", "plan.json"


@dataclass(frozen=True)
class Plan:
    """`rings` of a forward-looking scan `ring_step` [m] apart, photographed `takes` times; a head that stops `stops`
    times `stop_step` [m] apart and at `angles` clocks; `touched` = (rings, angles) of the tactile scan. `section`:
    rings of a forward-looking scan that are simulated and profiled at a time; of a head it is one stop. Photographs of
    rings and gauges are taken `target_takes` times; of the stops of a flat, 0.1 in apart, every `flat_every`th.
    """

    name: str
    rings: int
    ring_step: float
    takes: int
    angles: int
    stops: int
    stop_step: float
    side_takes: int
    touched: tuple[int, int]
    section: int
    target_takes: int = 2
    flat_every: int = 1
    seed: int = 1
    instruments: tuple[str, ...] = INSTRUMENTS

    def __post_init__(self) -> None:
        counts = (
            *(self.rings, self.takes, self.angles, self.stops, self.side_takes, *self.touched),
            *(self.section, self.target_takes, self.flat_every),
        )
        if min(counts) < 1 or self.seed < 0 or not self.instruments or not set(self.instruments) <= set(INSTRUMENTS):
            raise InputError(
                f"An experiment needs at least one of everything, instruments of {', '.join(INSTRUMENTS)}, and a seed "
                f">= 0, got {self}."
            )

    def sections(self, count: int, *, size: int) -> list[range]:
        """`count` stations cut into sections of `size`."""
        return [range(first, min(first + size, count)) for first in range(0, count, size)]

    def as_plain(self) -> dict[str, Any]:
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return {"format": FORMAT, "calibore": version("calibore"), **plain}


REDUCED = Plan(
    name="reduced",
    rings=25,
    ring_step=0.4 * INCH,
    takes=1,
    angles=24,
    stops=8,
    stop_step=1.2 * INCH,
    side_takes=1,
    touched=(100, 400),
    section=25,
    flat_every=3,
)
FULL = Plan(
    name="full",
    rings=100,
    ring_step=0.1 * INCH,
    takes=10,
    angles=400,
    stops=50,
    stop_step=0.2 * INCH,
    side_takes=10,
    touched=(100, 400),
    section=20,
)
"""The dissertation's: 400 angles x 50 stops x 10 takes of the head alone are 200 000 pictures."""
PLANS = {plan.name: plan for plan in (REDUCED, FULL)}


def settle(out: Path, plan: Plan) -> None:
    """Makes the folder `out` the place of this plan; raises OutputError where it is that of anything else."""
    note = out / NOTE
    if note.is_file():
        _check_same(note, plan)
        return
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OutputError(f"{out} holds something else; choose an empty or new folder for the experiment.")
    out.mkdir(parents=True, exist_ok=True)
    written = out / f".{NOTE}.partial"
    written.write_text(json.dumps(plan.as_plain(), indent=2) + "\n", encoding="utf-8")
    written.replace(note)


def _check_same(note: Path, plan: Plan) -> None:
    try:
        found = json.loads(note.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict) or found.get("format") != FORMAT:
        raise OutputError(f"{note} is no plan of an experiment; choose an empty or new folder.")
    wanted = plan.as_plain()
    differs = [key for key in wanted if found.get(key) != wanted[key]]
    if differs:
        raise OutputError(
            f"{note.parent} holds an experiment of another {_listed(differs)} "
            f"({', '.join(f'{key} {found.get(key)}' for key in differs)}); give the same again, or another folder."
        )


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
