"""Tables 7.1 and 8.1: the side-facing head as designed, as calibrated on the bench, as calibrated in the pipe."""

from dataclasses import dataclass

import numpy as np

from calibore.calibration import Calibration
from calibore.experiment import DESIGNED, DRIFTED, EXTRINSIC, HEAD_CHANGE, IN_SITU, INCH, Head, Outcome
from calibore.reports._comparison_words import with_u
from calibore.uncertainty import Quantity


@dataclass(frozen=True)
class Table:
    """`rows` of text under `columns`; `left` columns from the left are words."""

    name: str
    title: str
    note: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    left: int = 1


HEAD_ROWS = (("D [in]", "laser.baseline"), ("aim [deg]", "laser.aim"), ("f [deg/px]", "camera.k"))


def head_table(found: Outcome) -> Table:
    known = found.calibrations[DRIFTED, "side-2.4in"]
    rows = tuple(
        (words, f"{designed:g}", f"{theirs:g}", with_u(ours), f"{theirs:g}")
        for (words, _), designed, theirs, ours in zip(HEAD_ROWS, DESIGNED, EXTRINSIC, _head_of(known), strict=True)
    )
    columns = ("Parameter", "designed", "regression, published", "ours", "true, ours")
    note = "The flat at 0.1 in steps, its slide uncertain by 0.003 in, which nobody states; ± standard uncertainties."
    return Table("table_7_1", "Table 7.1: designed versus actual parameters", note, columns, rows)


def in_situ_table(found: Outcome) -> Table:
    before, after = (found.calibrations[variant, "side-2.4in"] for variant in (DRIFTED, IN_SITU))
    truth = [true * (1 + change / 100) for true, change in zip(EXTRINSIC, HEAD_CHANGE, strict=True)]
    rows = tuple(
        (
            words,
            with_u(one),
            with_u(two),
            f"{true:.4g}",
            f"{theirs:+.2f}",
            f"{100 * (two.value / one.value - 1):+.2f} ± {_percent(one, two):.2f}",
        )
        for (words, _), one, two, true, theirs in zip(
            HEAD_ROWS, _head_of(before, drift=False), _head_of(after), truth, HEAD_CHANGE, strict=True
        )
    )
    columns = (
        "Parameter",
        "extrinsic, ours",
        "intrinsic, ours",
        "true at the scan",
        "change, published [%]",
        "change, ours [%]",
    )
    note = (
        "The head changed by the published per cents between its calibration on the bench and the scan; intrinsic: "
        "fitted to one stop's pictures and the tactile profile. D, aim and f hang together: judge them with their "
        "covariance."
    )
    return Table("table_8_1", "Table 8.1: extrinsic versus intrinsic calibration", note, columns, rows)


def _percent(one: Quantity, two: Quantity) -> float:
    return 100 * abs(two.value / one.value) * float(np.hypot(one.u / one.value, two.u / two.value))


def _head_of(known: Calibration, *, drift: bool = True) -> tuple[Quantity, ...]:
    """In the units of the tables; the scale of the lens as degrees per pixel."""
    u = dict(zip(known.covariance.names, known.covariance.u.tolist(), strict=True))
    D, aim, k = ((known.values[name], u[name]) for _, name in HEAD_ROWS)
    per_pixel = float(np.degrees(1 / k[0]))
    values = Head(D[0] / INCH, float(np.degrees(aim[0])), per_pixel)
    widths = Head(D[1] / INCH, float(np.degrees(aim[1])), per_pixel * k[1] / k[0])
    return tuple(Quantity(*pair) for pair in zip(values, widths, strict=True))
