"""What was done: executions, minutes of the processor and faults of every entry, over all runs."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

LEDGER = "ledger.json"


@dataclass(frozen=True)
class Done:
    """Of one entry, since its ledger was begun."""

    executions: int = 0
    seconds: float = 0.0
    faults: int = 0
    runs: int = 0

    def __add__(self, other: "Done") -> "Done":
        return Done(*(a + b for a, b in zip(asdict(self).values(), asdict(other).values(), strict=True)))


def ledger(home: Path) -> dict[str, Done]:
    """By entry."""
    path = home / LEDGER
    return {name: Done(**one) for name, one in json.loads(path.read_text()).items()} if path.is_file() else {}


def add(home: Path, name: str, done: Done) -> None:
    """Note one more run."""
    every = ledger(home)
    every[name] = every.get(name, Done()) + done
    partial = home / f".{LEDGER}.partial"
    partial.write_text(json.dumps({name: asdict(one) for name, one in every.items()}, indent=1), encoding="utf-8")
    partial.replace(home / LEDGER)


def table(home: Path) -> list[str]:
    """Markdown lines."""
    rows = [
        f"| {name} | {one.executions} | {one.seconds / 60:.1f} | {one.faults} |" for name, one in ledger(home).items()
    ]
    return ["| entry | executions | minutes of the processor | faults |", "|---|---|---|---|", *rows]
