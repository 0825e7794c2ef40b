"""Models of NIST's Statistical Reference Datasets (non-linear regression) with derivatives, and their files."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Law = Callable[[Array, Array], tuple[Array, list[Array]]]
FOLDER = Path(__file__).parents[2].parent / "shared" / "data" / "real" / "nist-strd"


class Certified(NamedTuple):
    """`starts` (2, p), certified `values` (p,) and `deviations` (p,), `measured` (n,) at `x` (k, n)."""

    starts: Array
    values: Array
    deviations: Array
    measured: Array
    x: Array


def read_certified(name: str) -> Certified:
    lines = (FOLDER / f"{name}.dat").read_text().splitlines()
    table = np.array([line.split("=")[1].split() for line in lines if re.match(r"\s*b\d+ =\s+\S+\s+\S+\s+\S", line)])
    first = max(number for number, line in enumerate(lines) if line.startswith("Data:")) + 1
    data = np.array([line.split() for line in lines[first:] if line.strip()], dtype=float)
    start_1, start_2, values, deviations = table.astype(float).T
    measured = np.log(data[:, 0]) if name == "Nelson" else data[:, 0]
    return Certified(np.array([start_1, start_2]), values, deviations, measured, data[:, 1:].T)


def model(name: str, certified: Certified) -> Callable[[Array], tuple[Array, Array]]:
    """Residuals, measured minus predicted, and the derivatives of the predictions."""

    def residuals(b: Array) -> tuple[Array, Array]:
        with np.errstate(all="ignore"):
            prediction, slopes = LAWS[name](b, certified.x)
            return certified.measured - prediction, np.column_stack(
                [np.broadcast_to(s, prediction.shape) for s in slopes]
            )

    return residuals


def _bennett(b: Array, x: Array) -> tuple[Array, list[Array]]:
    base = b[1] + x[0]
    power = base ** (-1 / b[2])
    return b[0] * power, [power, -b[0] / b[2] * power / base, b[0] * power * np.log(base) / b[2] ** 2]


def _saturating(b: Array, x: Array) -> tuple[Array, list[Array]]:
    fall = np.exp(-b[1] * x[0])
    return b[0] * (1 - fall), [1 - fall, b[0] * x[0] * fall]


def _chwirut(b: Array, x: Array) -> tuple[Array, list[Array]]:
    below = b[1] + b[2] * x[0]
    y = np.exp(-b[0] * x[0]) / below
    return y, [-x[0] * y, -y / below, -y * x[0] / below]


def _power(b: Array, x: Array) -> tuple[Array, list[Array]]:
    power = x[0] ** b[1]
    return b[0] * power, [power, b[0] * power * np.log(x[0])]


def _enso(b: Array, x: Array) -> tuple[Array, list[Array]]:
    t = 2 * np.pi * x[0]
    year, slow, slower = t / 12, t / b[3], t / b[6]
    y = b[0] + b[1] * np.cos(year) + b[2] * np.sin(year) + b[4] * np.cos(slow) + b[5] * np.sin(slow)
    y = y + b[7] * np.cos(slower) + b[8] * np.sin(slower)
    by_slow = (b[4] * np.sin(slow) - b[5] * np.cos(slow)) * slow / b[3]
    by_slower = (b[7] * np.sin(slower) - b[8] * np.cos(slower)) * slower / b[6]
    waves = [np.cos(year), np.sin(year), by_slow, np.cos(slow), np.sin(slow), by_slower, np.cos(slower), np.sin(slower)]
    return y, [np.ones_like(t), *waves]


def _eckerle(b: Array, x: Array) -> tuple[Array, list[Array]]:
    z = (x[0] - b[2]) / b[1]
    bell = np.exp(-0.5 * z**2) / b[1]
    return b[0] * bell, [bell, b[0] * bell * (z**2 - 1) / b[1], b[0] * bell * z / b[1]]


def _gauss(b: Array, x: Array) -> tuple[Array, list[Array]]:
    fall = np.exp(-b[1] * x[0])
    y, slopes = b[0] * fall, [fall, -b[0] * x[0] * fall]
    for height, centre, width in (b[2:5], b[5:8]):
        z = (x[0] - centre) / width
        bell = np.exp(-(z**2))
        y = y + height * bell
        slopes += [bell, 2 * height * bell * z / width, 2 * height * bell * z**2 / width]
    return y, slopes


def _rational(b: Array, x: Array, *, above: int) -> tuple[Array, list[Array]]:
    """Polynomial of `above` coefficients over 1 + a polynomial without constant."""
    upper = [x[0] ** i for i in range(above)]
    lower = [x[0] ** (i + 1) for i in range(b.size - above)]
    below = 1 + sum(c * term for c, term in zip(b[above:], lower, strict=True))
    y = sum(c * term for c, term in zip(b[:above], upper, strict=True)) / below
    return y, [term / below for term in upper] + [-y * term / below for term in lower]


def _exponentials(b: Array, x: Array) -> tuple[Array, list[Array]]:
    y, slopes = np.zeros_like(x[0]), []
    for height, rate in b.reshape(-1, 2):
        fall = np.exp(-rate * x[0])
        y, slopes = y + height * fall, [*slopes, fall, -height * x[0] * fall]
    return y, slopes


def _mgh09(b: Array, x: Array) -> tuple[Array, list[Array]]:
    above, below = x[0] ** 2 + x[0] * b[1], x[0] ** 2 + x[0] * b[2] + b[3]
    y = b[0] * above / below
    return y, [above / below, b[0] * x[0] / below, -y * x[0] / below, -y / below]


def _mgh10(b: Array, x: Array) -> tuple[Array, list[Array]]:
    shifted = x[0] + b[2]
    rise = np.exp(b[1] / shifted)
    return b[0] * rise, [rise, b[0] * rise / shifted, -b[0] * rise * b[1] / shifted**2]


def _mgh17(b: Array, x: Array) -> tuple[Array, list[Array]]:
    first, second = np.exp(-x[0] * b[3]), np.exp(-x[0] * b[4])
    slopes = [np.ones_like(x[0]), first, second, -b[1] * x[0] * first, -b[2] * x[0] * second]
    return b[0] + b[1] * first + b[2] * second, slopes


def _misra1b(b: Array, x: Array) -> tuple[Array, list[Array]]:
    base = 1 + b[1] * x[0] / 2
    return b[0] * (1 - base**-2), [1 - base**-2, b[0] * x[0] * base**-3]


def _misra1c(b: Array, x: Array) -> tuple[Array, list[Array]]:
    base = 1 + 2 * b[1] * x[0]
    return b[0] * (1 - base**-0.5), [1 - base**-0.5, b[0] * x[0] * base**-1.5]


def _misra1d(b: Array, x: Array) -> tuple[Array, list[Array]]:
    base = 1 + b[1] * x[0]
    return b[0] * b[1] * x[0] / base, [b[1] * x[0] / base, b[0] * x[0] / base**2]


def _nelson(b: Array, x: Array) -> tuple[Array, list[Array]]:
    fall = np.exp(-b[2] * x[1])
    return b[0] - b[1] * x[0] * fall, [np.ones_like(fall), -x[0] * fall, b[1] * x[0] * x[1] * fall]


def _rat42(b: Array, x: Array) -> tuple[Array, list[Array]]:
    e = np.exp(b[1] - b[2] * x[0])
    y = b[0] / (1 + e)
    return y, [1 / (1 + e), -y * e / (1 + e), y * x[0] * e / (1 + e)]


def _rat43(b: Array, x: Array) -> tuple[Array, list[Array]]:
    e = np.exp(b[1] - b[2] * x[0])
    power = (1 + e) ** (-1 / b[3])
    y = b[0] * power
    return y, [power, -y * e / (1 + e) / b[3], y * x[0] * e / (1 + e) / b[3], y * np.log1p(e) / b[3] ** 2]


def _roszman(b: Array, x: Array) -> tuple[Array, list[Array]]:
    away = x[0] - b[3]
    y = b[0] - b[1] * x[0] - np.arctan(b[2] / away) / np.pi
    square = (away**2 + b[2] ** 2) * np.pi
    return y, [np.ones_like(away), -x[0], -away / square, -b[2] / square]


def _cubics(b: Array, x: Array) -> tuple[Array, list[Array]]:
    return _rational(b, x, above=4)


def _quadratics(b: Array, x: Array) -> tuple[Array, list[Array]]:
    return _rational(b, x, above=3)


LAWS: dict[str, Law] = {
    "Bennett5": _bennett, "BoxBOD": _saturating, "Chwirut1": _chwirut, "Chwirut2": _chwirut, "DanWood": _power,
    "ENSO": _enso, "Eckerle4": _eckerle, "Gauss1": _gauss, "Gauss2": _gauss, "Gauss3": _gauss, "Hahn1": _cubics,
    "Kirby2": _quadratics, "Lanczos1": _exponentials, "Lanczos2": _exponentials, "Lanczos3": _exponentials,
    "MGH09": _mgh09, "MGH10": _mgh10, "MGH17": _mgh17, "Misra1a": _saturating, "Misra1b": _misra1b,
    "Misra1c": _misra1c, "Misra1d": _misra1d, "Nelson": _nelson, "Rat42": _rat42, "Rat43": _rat43,
    "Roszman1": _roszman, "Thurber": _cubics,
}  # fmt: skip
