"""Which design to build: the one whose tightest requirement has the most room."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from calibore.design._appraisal import Design
from calibore.design._requirement import Requirement


class Costed(Protocol):
    """A design as the grid or as its appraisal sees it."""

    @property
    def costs(self) -> NDArray[np.float64]:
        """(4,) as `Design.costs`."""
        ...

    @property
    def coverage(self) -> float:
        """Share of the circumference."""
        ...


One = TypeVar("One", bound=Costed)


def demands_of(one: Costed, wanted: Requirement, *, budget: float | None = None) -> dict[str, float]:
    """How much of each requirement the design takes up, 1 = all that is allowed, above 1 too much; `budget` [m] in
    place of the required U95.
    """
    u95, smallest, occlusion, length = one.costs.tolist()
    required = wanted.requirement
    demands = {"u95": u95 / (budget or wanted.budget), "length": length / wanted.crawler.length}
    if required.deflection:
        demands["deflection"] = smallest / wanted.smallest_wanted
    if required.occlusion:
        demands["occlusion"] = required.occlusion / -occlusion
    if one.coverage < required.coverage:
        demands["coverage"] = required.coverage / one.coverage
    return demands


def best_of(designs: Sequence[One], wanted: Requirement, *, budget: float | None = None) -> One:
    """The design whose largest demand is least; of equals, the next largest decides, then the smaller U95. Where none
    meets the requirements, it is the one that comes nearest.
    """

    def tightest(one: Costed) -> tuple[float, ...]:
        return (*sorted(demands_of(one, wanted, budget=budget).values(), reverse=True), float(one.costs[0]))

    return min(designs, key=tightest)


@dataclass(frozen=True)
class Option:
    """A design with the `demands` it makes on the requirements, and whether no other of all is better in everything."""

    design: Design
    demands: Mapping[str, float]
    on_front: bool

    @property
    def meets(self) -> bool:
        """All requirements."""
        return max(self.demands.values()) <= 1

    @cached_property
    def binding(self) -> str:
        """The requirement with the least room."""
        return max(self.demands, key=lambda name: self.demands[name])
