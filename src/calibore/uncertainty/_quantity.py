"""A number with its standard uncertainty."""

from dataclasses import dataclass
from math import inf

from calibore.errors import InputError
from calibore.uncertainty._coverage import PROBABILITY, coverage_factor

COVERAGE_95 = 1.959963984540054  # of the normal distribution


@dataclass(frozen=True)
class Quantity:
    """`value` with standard uncertainty `u` (k = 1), both in one unit; NaN where not measured."""

    value: float
    u: float
    degrees_of_freedom: float = inf

    def __post_init__(self) -> None:
        if self.u < 0:
            raise InputError(f"A standard uncertainty must not be negative, got {self.u}; give its absolute value.")
        if not self.degrees_of_freedom > 0:
            raise InputError(
                f"Degrees of freedom must be above 0, got {self.degrees_of_freedom}; give inf where u is well known."
            )

    def interval(self, coverage_factor: float | None = None) -> tuple[float, float]:
        """The interval value -+ coverage_factor x u; by default 95 % for its degrees of freedom."""
        half_width = self.expanded() if coverage_factor is None else coverage_factor * self.u
        return self.value - half_width, self.value + half_width

    def expanded(self, probability: float = PROBABILITY) -> float:
        """Expanded uncertainty: u times Student's t (JCGM 100, G.3.2)."""
        if self.degrees_of_freedom == inf and probability == PROBABILITY:
            return COVERAGE_95 * self.u
        return float(coverage_factor(probability, self.degrees_of_freedom)) * self.u
