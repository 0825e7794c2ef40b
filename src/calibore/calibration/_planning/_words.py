"""What a plan advises, for people who are about to set up the target."""

from collections.abc import Iterator
from math import floor, inf, log10
from typing import TYPE_CHECKING

from calibore.calibration._in_words import Unit

if TYPE_CHECKING:
    from calibore.calibration._planning._plan import Plan

HARDLY = 0.02
"""Of the uncertainty on the wall: pictures that take away no more are not worth the work."""
NOTHING = 5e-4


def advice_of(plan: "Plan", unit: str) -> str:
    """Which picture is next, what it and all planned ones bring on the wall, and whether that is worth the work."""
    return " ".join(_sentences(plan, Unit.of_length(f"1 {unit}")))


def _sentences(plan: "Plan", length: Unit) -> Iterator[str]:
    first, now, gain = plan.steps[0], plan.before, 1 - plan.after / plan.before
    wall = f"u of the radius on a wall of R = {plan.nominal_radius / length.size:.4g} {length.symbol}"
    yield (
        f"The best next picture of the target: {first.shot.said(length.symbol)}. It brings {wall} from "
        f"{_said(now, length)} to {_said(first.u, length)} ({_less(1 - first.u / now)})."
    )
    if len(plan.steps) > 1:
        yield f"All {len(plan.steps)} pictures planned bring it to {_said(plan.after, length)} ({_less(gain)})."
    if gain < HARDLY:
        yield "More pictures of this target hardly help; what is left needs another target, or is known well enough."


def _said(value: float, length: Unit) -> str:
    value = value / length.size
    decimals = max(0, 2 - floor(log10(value))) if 0 < value < inf else 0
    return f"{value:.{decimals}f} {length.symbol}"


def _less(part: float) -> str:
    return f"{100 * part:.{0 if part >= 0.1 else 1}f} % less" if part >= NOTHING else "no less"
