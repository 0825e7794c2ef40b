"""A number with its standard uncertainty."""

from dataclasses import dataclass

from calibore.errors import InputError

COVERAGE_95 = 1.959963984540054  # of the normal distribution


@dataclass(frozen=True)
class Quantity:
    """`value` with standard uncertainty `u` (k = 1), both in one unit; NaN where not measured."""

    value: float
    u: float

    def __post_init__(self) -> None:
        if self.u < 0:
            raise InputError(f"A standard uncertainty must not be negative, got {self.u}; give its absolute value.")

    def interval(self, coverage_factor: float = COVERAGE_95) -> tuple[float, float]:
        """The interval value -+ coverage_factor x u; by default 95 % for a normal distribution."""
        return self.value - coverage_factor * self.u, self.value + coverage_factor * self.u
