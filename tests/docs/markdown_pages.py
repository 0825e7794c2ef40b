"""Markdown as the documentation tests see it: pages, fenced blocks, links, and the comparison of printed numbers."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?!\w)")
LAST_DIGITS = 2
"""Units of the last printed digit by which a number may differ: rounding, and another processor's arithmetic."""


@dataclass(frozen=True)
class Block:
    """A fenced block with its language and first line; it `follows` if only blank lines part it from the last one."""

    language: str
    text: str
    line: int
    follows: bool


def pages() -> list[Path]:
    """Every Markdown page of the repository."""
    return [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of `page` in order."""
    text = page.read_text(encoding="utf-8")
    found, end = [], 0
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        found.append(Block(match[1], match[2], line, bool(found) and not text[end : match.start()].strip()))
        end = match.end()
    return found


def prose(page: Path) -> str:
    """The text of `page` without its fenced blocks."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


def differences(promised: str, printed: str) -> list[str]:
    """What is printed otherwise than promised: one sentence per line; a promised line `...` stands for any lines."""
    wanted, got = _lines(promised), _lines(printed)
    if "..." in wanted:
        gap = wanted.index("...")
        after = len(wanted) - gap - 1
        wanted, got = wanted[:gap] + wanted[gap + 1 :], got[:gap] + got[max(len(got) - after, gap) :]
    if len(wanted) != len(got):
        return [f"{len(wanted)} lines are promised, {len(got)} are printed:\n{printed}"]
    return [f"promised: {w}\nprinted:  {g}" for w, g in zip(wanted, got, strict=True) if not _same(w, g)]


def _lines(text: str) -> list[str]:
    return [" ".join(line.split()) for line in text.strip().splitlines()]


def _same(wanted: str, got: str) -> bool:
    numbers, others = NUMBER.findall(wanted), NUMBER.findall(got)
    if NUMBER.sub("#", wanted) != NUMBER.sub("#", got) or len(numbers) != len(others):
        return False
    return all(_close(w, g) for w, g in zip(numbers, others, strict=True))


def _close(wanted: str, got: str) -> bool:
    """Whole numbers are counts and equal; others agree to `LAST_DIGITS` of their last digit."""
    decimals = len(wanted.partition(".")[2])
    if decimals == 0 or len(got.partition(".")[2]) != decimals:
        return wanted == got
    return abs(float(wanted) - float(got)) <= (LAST_DIGITS + 1e-6) * 10.0**-decimals
