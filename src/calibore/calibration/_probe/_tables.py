"""target.toml of a tactile probe and its two tables: lengths under a caliper, diameters in the pipe."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from calibore.calibration._in_words import Unit
from calibore.calibration._input_files import InputFile, input_file
from calibore.documents import Document, FileName, Length, read_document
from calibore.errors import InputError

Array = NDArray[np.float64]
Whole = NDArray[np.intp]
INCH = 0.0254
DEFAULT_U_CALIPER = 0.0005 * INCH / np.sqrt(3)
"""m; limits of 0.0005 in (Swanbom 2007, 8.2.3), anywhere between them."""
DEFAULT_U_CONTACT = 0.001 * INCH
"""m; how far the spot that a ball touches differs from the one that a caliper's jaw touches, on a wall not polished:
what the dissertation aims at (8.2)."""
FEWEST_LENGTHS = 4
LARGEST = 1e6
"""Of any number in a table: more is no stop, ratio or length."""
METRES = {"in": INCH, "inch": INCH, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
_UNIT = re.compile(r"_(in|inch|mm|cm|m)\b", flags=re.IGNORECASE)


class ProbeTarget(Document):
    """[m]. `adc_bits`, `adc_range` [V] and `bias_voltage` [V] of the voltmeter give a least noise; noise itself comes
    from the data. `u_caliper`: of one reading; `u_contact`: of one contact in the pipe.
    """

    format: Literal["calibore-target/1"]
    kind: Literal["probe"]
    probe_calibration: FileName
    diameters: FileName
    u_caliper: Annotated[Length, Field(ge=0)] = float(DEFAULT_U_CALIPER)
    u_contact: Annotated[Length, Field(ge=0)] = DEFAULT_U_CONTACT
    adc_bits: Annotated[int, Strict(), Field(gt=0, le=32)] | None = None
    adc_range: Annotated[float, Strict(), Field(gt=0)] | None = None
    bias_voltage: Annotated[float, Strict(), Field(gt=0)] = 5.0

    @property
    def u_digit(self) -> float:
        """Standard uncertainty of a ratio below 1 from the voltmeter's last digit."""
        if self.adc_bits is None or self.adc_range is None:
            return 0.0
        return self.adc_range / 2**self.adc_bits / np.sqrt(12) / self.bias_voltage


@dataclass(frozen=True, eq=False)
class ProbeTables:
    """`ratio` (n,) and `length` (n,) [m] in the order they were taken; of m diameters the angular `stops` (m, 2), the
    two ratios `raw` (m, 2) and the caliper's `diameter` (m,) [m]; the workshop's `unit`.
    """

    target: ProbeTarget
    ratio: Array
    length: Array
    stops: Whole
    raw: Array
    diameter: Array
    unit: Unit
    files: tuple[InputFile, ...]


def read_probe_tables(path: Path) -> ProbeTables:
    """Raises InputError naming the file and what its table must hold."""
    toml = path / "target.toml" if path.is_dir() else path
    target = read_document(toml, ProbeTarget)
    if (target.adc_bits is None) != (target.adc_range is None):
        raise InputError(f"{toml}: adc_bits and adc_range [V] belong together; give both or neither.")
    lengths, diameters = toml.parent / target.probe_calibration, toml.parent / target.diameters
    line, unit = _table(lengths, 2, "raw_ratio,caliper_length_in")
    pairs, _ = _table(diameters, 5, "angular_index_1,angular_index_2,raw_1,raw_2,caliper_diameter_in")
    if len(np.unique(line[:, 0])) < FEWEST_LENGTHS:
        raise InputError(
            f"{lengths} has {len(np.unique(line[:, 0]))} different lengths; measure at least {FEWEST_LENGTHS}, better "
            "20, spread over the probe's stroke."
        )
    return ProbeTables(
        target,
        ratio=line[:, 0],
        length=line[:, 1],
        stops=np.rint(pairs[:, :2]).astype(np.intp),
        raw=pairs[:, 2:4],
        diameter=pairs[:, 4],
        unit=unit,
        files=(input_file(lengths), input_file(diameters)),
    )


def _table(path: Path, columns: int, header: str) -> tuple[Array, Unit]:
    """The rows (n, columns), the last column in metres by the unit that the header gives it, and that unit."""
    example = f'Its first line is "# {header}" (or _mm, _m for the unit), then numbers separated by commas.'
    try:
        lines = [line.strip() for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
    except FileNotFoundError:
        raise InputError(f"{path} is not there; copy the table there, or name it in target.toml. {example}") from None
    except (OSError, UnicodeDecodeError) as error:
        why = "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else error.strerror
        raise InputError(f"{path} cannot be read ({why}); name an existing table of text.") from error
    words = [line for line in lines if re.search(r"[A-Za-z_]{2}", line)]
    found = _UNIT.search(words[0].split(",")[-1]) if words else None
    if found is None:
        raise InputError(f"{path} does not say the unit of its lengths. {example}")
    try:
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines if line not in words])
    except ValueError as error:
        raise InputError(f"{path} holds something that is no table of numbers ({error}). {example}") from error
    if rows.ndim != 2 or rows.shape[1] != columns or not (np.abs(rows) <= LARGEST).all():
        raise InputError(f"{path} needs rows of {columns} finite numbers up to {LARGEST:.0f}, at least one. {example}")
    unit = Unit(found[1].lower(), METRES[found[1].lower()])
    rows[:, -1] *= unit.size
    return rows, unit
