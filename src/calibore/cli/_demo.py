"""`calibore demo`: simulates a small pipe, measures it, and shows truth beside measurement."""

from pathlib import Path
from typing import Annotated, Any

import typer

from calibore.cli._failure import wrong_usage
from calibore.cli._profile import UnitName, Workers, as_json, progress_bar, tell

SCAN, RESULT = "scan", "result"
ROWS = (
    ("mean diameter", "diameter_mean", "_m"),
    ("smallest diameter", "diameter_min", "_m"),
    ("largest diameter", "diameter_max", "_m"),
    ("ovality (2nd harmonic)", "ovality_harmonic", "_percent"),
)


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the simulated scan and its result.")] = Path(
        "calibore-demo"
    ),
    seed: Annotated[int, typer.Option(help="Another seed, another pipe.")] = 1,
    workers: Workers = None,
    unit: UnitName = "mm",
    open_report: Annotated[bool, typer.Option("--open", help="Open the report in the browser.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print truth and measurement as JSON.")] = False,
) -> None:
    """Simulate a short 12 in pipe with features, profile it, and compare with the truth. Needs no input."""
    from calibore.profiling import profile_scan
    from calibore.reports import finisher
    from calibore.simulation import demo_scan

    with wrong_usage():
        finish = finisher(unit=unit)
    with progress_bar("Simulating", quiet=json) as progress:
        scan = demo_scan(out / SCAN, seed=seed, progress=progress)
    with progress_bar("Profiling", quiet=json) as progress:
        summary = profile_scan(scan, out / RESULT, workers=workers, progress=progress, finisher=finish)
    rows = compare(out)
    if json:
        typer.echo(as_json({"summary": summary, "comparison": rows}))
        return
    show(rows, unit)
    tell(summary, out / RESULT, unit=unit, json=False)
    if open_report:
        typer.launch(str((out / RESULT / "report.html").absolute()))


def compare(out: Path) -> list[dict[str, Any]]:
    """Truth, measurement and U95 of every station and quantity of `ROWS`, SI and percent."""
    import numpy as np

    from calibore.scans import read_rings

    rings = read_rings(out / RESULT)
    rows = []
    with np.load(out / SCAN / "truth.npz") as truth:
        for i, station in enumerate(rings["station"]):
            at = int(np.flatnonzero(truth["stop"] == station)[0])
            for label, name, suffix in ROWS:
                true, measured = float(truth[f"true_{name}"][at]), float(rings[name + suffix][i])
                expanded = 2 * float(rings[f"u_{name}{suffix}"][i])
                rows.append(
                    {
                        "station": int(station),
                        "quantity": label,
                        "unit": "%" if suffix == "_percent" else "m",
                        "truth": true,
                        "measured": measured,
                        "expanded_uncertainty": expanded,
                        "contained": bool(abs(measured - true) <= expanded),
                    }
                )
    return rows


def show(rows: list[dict[str, Any]], unit: str) -> None:
    """The comparison as a table, one line per station, and how many intervals hold the truth."""
    from rich.console import Console
    from rich.table import Table

    from calibore.units import parse_quantity

    scale = parse_quantity(f"1 {unit}", "length")
    shown = [row for row in rows if row["quantity"] in (ROWS[0][0], ROWS[3][0])]
    table = Table(title="Truth against measurement (U95: expanded uncertainty, k = 2)")
    table.add_column("station", justify="right")
    table.add_column("quantity")
    for name in ("truth", "measured", "U95"):
        table.add_column(name, justify="right")
    table.add_column("truth inside")
    for row in shown:
        factor, symbol, digits = (1.0, "%", 3) if row["unit"] == "%" else (1 / scale, unit, 4 if unit == "in" else 3)
        cells = (f"{row[key] * factor:.{digits}f} {symbol}" for key in ("truth", "measured", "expanded_uncertainty"))
        table.add_row(str(row["station"]), row["quantity"], *cells, "yes" if row["contained"] else "no")
    Console().print(table)
    measured = [row for row in rows if row["measured"] == row["measured"] and row["truth"] == row["truth"]]
    inside = sum(row["contained"] for row in measured)
    typer.echo(f"{inside} of {len(measured)} intervals of mean, smallest, largest diameter and ovality hold the truth.")
