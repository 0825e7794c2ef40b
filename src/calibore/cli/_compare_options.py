"""What the options of `calibore compare` mean; a mistake in them is wrong usage."""

import math
from datetime import date
from typing import TYPE_CHECKING, Any

from calibore.errors import InputError

if TYPE_CHECKING:
    from calibore.comparison import OutlierRule
    from calibore.registration import Motion

ANGLES = ("roll", "tilt_x", "tilt_y")
LENGTHS = ("shift_x", "shift_y", "axial")
PURE = ("stretch", "scale")
START = 'write e.g. --start "roll=0.3 deg, axial=2 mm"'
YEAR = 365.2425
"""Days."""


def alignment_of(free: str, start: str, *, search: bool, per_ring: bool) -> dict[str, Any]:
    """Arguments of a registration."""
    from calibore.registration import RIGID

    names = RIGID if free == "rigid" else () if free == "none" else tuple(one.strip() for one in free.split(","))
    known = (*ANGLES, *LENGTHS, *PURE)
    for name in names:
        if name not in known:
            raise InputError(f'--free knows no "{name}"; it may name {", ".join(known)}, or be rigid or none.')
    if not names and per_ring:
        raise InputError("--per-ring lets rings move, --free none lets nothing move; leave one of them out.")
    return {"free": names, "start": _start(start), "search": search and bool(names), "per_ring": per_ring}


def _start(text: str) -> "Motion":
    from calibore.registration import Motion
    from calibore.units import parse_quantity

    values: dict[str, float] = {}
    for part in filter(None, (one.strip() for one in text.split(","))):
        name, equals, written = (one.strip() for one in part.partition("="))
        if not equals or name not in (*ANGLES, *LENGTHS, *PURE):
            raise InputError(f'--start does not understand "{part}"; {START}.')
        if name in PURE:
            values[name] = _number(written, f"--start {name}")
        else:
            angle = parse_quantity(written, "angle" if name in ANGLES else "length")
            values[name] = math.tan(angle) if name.startswith("tilt") else angle
    if not values.get("scale", 1.0) > 0:
        raise InputError(f"--start scale must be positive, got {values['scale']:g}.")
    return Motion(**values)


def outlier_rule_of(text: str) -> "OutlierRule":
    """A length, or "4 sigma"."""
    from calibore.comparison import OutlierRule
    from calibore.units import parse_quantity

    if text.strip().endswith("sigma"):
        return OutlierRule(sigma=_number(text.strip().removesuffix("sigma"), "--outliers"))
    return OutlierRule(limit=parse_quantity(text, "length"))


def years_between(before: date | None, after: date | None) -> float | None:
    """Between the days of A and B; None where one of them is not known."""
    if before is None or after is None:
        return None
    days = (after - before).days
    if days <= 0:
        raise InputError(
            f"B ({after}) is not later than A ({before}); A is the earlier epoch: exchange both, or correct date in "
            "scan.toml, --date-a, --date-b."
        )
    return days / YEAR


def date_of(text: str | None, option: str) -> date | None:
    """Of an option such as 2024-05-31."""
    if text is None:
        return None
    try:
        return date.fromisoformat(text)
    except ValueError as error:
        raise InputError(f'{option} "{text}" is no date; write e.g. 2024-05-31.') from error


def _number(text: str, option: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise InputError(f'{option} must be a number, got "{text.strip()}".') from error
    if not math.isfinite(value):
        raise InputError(f'{option} must be a finite number, got "{text.strip()}".')
    return value
