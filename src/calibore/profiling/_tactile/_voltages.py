"""The tables of voltages that a probe's scan names, read and checked."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.errors import InputError
from calibore.scans import TactileTables

Array = NDArray[np.float64]
IMPOSSIBLE = 0.01
"""More impossible voltages than this share are no glitches: the tables are not what scan.toml says."""


def read_ratio(tables: TactileTables) -> Array:
    """Ratio (n rings, m stops) of signal to bias voltage, NaN where a cell is empty or impossible. Raises InputError
    naming file, row and column where the tables cannot be what they should.
    """
    signal, bias = _table(tables.signal), _table(tables.bias)
    if signal.shape != bias.shape:
        raise InputError(
            f"{tables.signal.name} has {_size(signal)}, {tables.bias.name} {_size(bias)}; give the signal and the bias "
            f"of the same readings ({tables.signal.parent})."
        )
    known = np.isfinite(signal) & np.isfinite(bias)
    if not known.any():
        raise InputError(
            f"{tables.signal} and {tables.bias.name} hold no reading with both voltages; record them again."
        )
    wrong = known & ~((bias > 0) & (signal >= 0) & (signal <= bias))
    if wrong.mean() > IMPOSSIBLE:
        raise InputError(_impossible(tables, signal, bias, wrong))
    good = known & ~wrong
    return np.divide(signal, bias, out=np.full(signal.shape, np.nan), where=good)


def _impossible(tables: TactileTables, signal: Array, bias: Array, wrong: NDArray[np.bool_]) -> str:
    row, column = np.argwhere(wrong)[0]
    exchanged = "; are the two files exchanged" if (signal > bias)[wrong].mean() > 0.5 else ""
    return (
        f"{tables.signal}: a signal must lie between 0 V and its bias, but {wrong.sum()} of {wrong.size} do not, the "
        f"first in row {row + 1}, column {column + 1}: {signal[row, column]:g} V of {bias[row, column]:g} "
        f"V{exchanged}? Check the wiring and the keys [tactile] signal and bias."
    )


def _size(table: Array) -> str:
    return f"{len(table)} rows of {table.shape[1]} cells"


def _table(path: Path) -> Array:
    """Numbers of a CSV table of equally long rows; empty cells are NaN, lines that begin with # are left out."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read as text ({error}); save the voltages as CSV.") from error
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        rows.append(_row(line, path, number))
        if len(rows[-1]) != len(rows[0]):
            raise InputError(
                f"{path}, line {number} has {len(rows[-1])} cells, the first row has {len(rows[0])}; give every ring "
                "one cell for each angular stop (empty where there is no reading)."
            )
    if not rows:
        raise InputError(f"{path} holds no numbers; give volts, a row for each ring, a column for each angular stop.")
    return np.array(rows)


def _row(line: str, path: Path, number: int) -> list[float]:
    found = []
    for column, cell in enumerate(line.split(","), start=1):
        try:
            found.append(float(cell) if cell.strip() else np.nan)
        except ValueError:
            raise InputError(
                f'{path}, line {number}, column {column} holds "{cell.strip()[:30]}", which is no number; give volts '
                "separated by commas, and nothing where there is no reading."
            ) from None
    return found
