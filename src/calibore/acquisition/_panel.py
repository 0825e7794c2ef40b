"""A run in a few lines of a terminal, or in one line for a log."""

import math
from collections.abc import Iterator

from calibore.acquisition._vitals import Vitals
from calibore.units import parse_quantity

DIGITS = {"mm": 3, "in": 4}
WIDTH = 78
K = 2
"""Coverage factor: what stands behind +- holds in 95 of 100 cases."""


def panel(vitals: Vitals, *, unit: str) -> list[str]:
    """The lines of the panel, none wider than `WIDTH`; +- is U95 (k = 2)."""
    rows = {
        "source": f"{vitals.source}  [{_state(vitals)}]",
        "time": f"{_clock(vitals.seconds)}   ring {_station(vitals)}",
        "pictures": f"{_number(vitals.arriving.per_second, 1)} /s in   "
        f"{_number(vitals.measuring.per_second, 1)} /s measured   {vitals.rings} rings",
        "waiting": f"{vitals.backlog}   dropped {vitals.dropped}   refused {vitals.refused}",
        "latency": f"{_milliseconds(vitals.latency)}   median {_milliseconds(vitals.latencies.quantile(0.5))}"
        f"   95 % {_milliseconds(vitals.latencies.quantile(0.95))}",
        **dict(_measured(vitals, unit)),
    }
    lines = [f"{name:<9} {text}"[:WIDTH] for name, text in rows.items()]
    return [*lines, vitals.sentence[:WIDTH]] if vitals.sentence else lines


def plain_line(vitals: Vitals, *, unit: str) -> str:
    """One line for a log."""
    said = "; ".join(f"{name} {text}" for name, text in _measured(vitals, unit))
    return (
        f"{_clock(vitals.seconds)} ring {_station(vitals)}: {said or 'nothing measured yet'}; "
        f"{_number(vitals.measuring.per_second, 1)} /s, waiting {vitals.backlog}, dropped {vitals.dropped}, "
        f"refused {vitals.refused}, latency {_milliseconds(vitals.latency)}"
    )


def _measured(vitals: Vitals, unit: str) -> Iterator[tuple[str, str]]:
    row = vitals.row
    if row is None:
        return
    scale, digits = parse_quantity(f"1 {unit}", "length"), DIGITS.get(unit, 3)
    yield "valid", f"{100 * row['fraction']:.1f} %"
    x, y = (f"{axis} {_number(row[f'centre_{axis}_m'] / scale, digits)}" for axis in "xy")
    yield "centre", f"{x}  {y} {unit} +- {_number(K * _longer(row, 'centre_x_m', 'centre_y_m') / scale, digits)}"
    diameter, u = row["diameter_mean_m"] / scale, row["u_diameter_mean_m"] / scale
    yield "diameter", f"{_number(diameter, digits)} {unit} +- {_number(K * u, digits)}"
    form = max(("max", "min"), key=lambda one: row[f"ovality_f1216_{one}_percent"])
    name = f"ovality_f1216_{form}_percent"
    yield "ovality", f"{_number(row[name], 2)} % +- {_number(K * row[f'u_{name}'], 2)}"


def _longer(row: object, *names: str) -> float:
    return max(row[f"u_{name}"] for name in names)  # pyright: ignore[reportIndexIssue]


def _state(vitals: Vitals) -> str:
    return "coming" if vitals.connected else "waiting for pictures"


def _station(vitals: Vitals) -> str:
    return "-" if vitals.row is None else str(vitals.row["station"])


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"


def _milliseconds(seconds: float) -> str:
    return f"{1000 * seconds:.0f} ms" if math.isfinite(seconds) else "-"


def _clock(seconds: float) -> str:
    whole = int(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
