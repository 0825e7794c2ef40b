"""Every published number computed anew, and what is to be said of the two."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from calibore.published._quantities import QUANTITIES
from calibore.published._values import PublishedValue, published_values

ROUNDING = 1e-9  # of a number that lies on the edge of its digits


class Verdict(StrEnum):
    """What is to be said of a published number."""

    REPRODUCED = "reproduced"
    APPROXIMATELY = "approximately"
    INCONSISTENT = "inconsistent in the source"
    DAMAGED = "damaged in the scan"
    DIFFERENT = "not reproduced"
    NOT_PUBLISHED = "not published"


MEANINGS: dict[Verdict, str] = {
    Verdict.REPRODUCED: "ours rounds to the printed digits",
    Verdict.APPROXIMATELY: "within what the wording can carry, but not to the last printed digit",
    Verdict.INCONSISTENT: "the source contradicts itself; the reason stands in the note",
    Verdict.DAMAGED: "the scanned digits are wrong; the corrected print is reproduced",
    Verdict.DIFFERENT: "outside the tolerance",
    Verdict.NOT_PUBLISHED: "explains a number that is",
}


@dataclass(frozen=True)
class Reproduction:
    """A published `value` and `ours`, in its unit."""

    value: PublishedValue
    ours: float

    @property
    def difference(self) -> float | None:
        """Ours minus published."""
        return None if self.value.published is None else self.ours - self.value.published

    @property
    def verdict(self) -> Verdict:
        value, difference = self.value, self.difference
        if difference is None:
            return Verdict.NOT_PUBLISHED
        if not abs(difference) <= value.tolerance * (1 + ROUNDING):
            return Verdict.DIFFERENT
        if value.contradiction:
            return Verdict.INCONSISTENT
        if value.scanned:
            return Verdict.DAMAGED
        return Verdict.REPRODUCED if abs(difference) <= value.half_digit * (1 + ROUNDING) else Verdict.APPROXIMATELY

    def as_plain(self) -> dict[str, Any]:
        """For reproduction.json."""
        value = self.value
        return {
            "id": value.id,
            "where": value.where,
            "what": value.what,
            "unit": value.unit,
            "published": value.published,
            "as_printed": value.printed,
            "as_scanned": value.scanned,
            "ours": self.ours,
            "difference": self.difference,
            "tolerance": value.tolerance,
            "verdict": str(self.verdict),
            "note": value.note,
            "contradiction": value.contradiction,
        }


def reproduced(progress: Callable[[int, int], None] | None = None) -> tuple[Reproduction, ...]:
    """Every published number beside ours; `progress` is told how many are done, of how many."""
    return tuple(_one_by_one(published_values(), progress))


def _one_by_one(
    values: tuple[PublishedValue, ...], progress: Callable[[int, int], None] | None
) -> Iterator[Reproduction]:
    for done, value in enumerate(values, start=1):
        yield Reproduction(value, float(QUANTITIES[value.quantity](**value.inputs)))
        if progress:
            progress(done, len(values))
