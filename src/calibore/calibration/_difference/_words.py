"""The verdict on a difference, for people who have to decide whether to go on measuring."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from calibore.calibration._in_words import DEGREE, PIXEL, Unit, plain_number, probability, unit_of, word_of

if TYPE_CHECKING:
    from calibore.calibration._difference._changes import Change
    from calibore.calibration._difference._difference import Difference
    from calibore.calibration._difference._test import Judgement

CHANCE, DOUBTFUL = 0.05, 0.001
"""Probabilities: above the first nothing speaks for a change, below the second chance is out of the question."""
MOST = 0.9
"""Of chi-square: a single parameter that explains as much is named as what changed."""
MISFIT = 3.0
"""Times what is expected: where so much is left that no parameter explains, the models differ."""


def verdict_of(found: "Difference", unit: str) -> str:
    """Same or not, how far apart in the image and on the wall, what changed, what to do."""
    return " ".join(_sentences(found, Unit.of_length(f"1 {unit}")))


def _sentences(found: "Difference", length: Unit) -> Iterator[str]:
    yield _answer(found)
    along = found.directions
    yield (
        f"Directions differ by {PIXEL.roughly(along.rms)} rms over the image, where the stated uncertainties let "
        f"expect {PIXEL.roughly(along.expected)}; a turn of {DEGREE.roughly(float(np.linalg.norm(along.turn)))} is "
        "taken out."
    )
    if found.wall is not None:
        yield _on_wall(found, length)
    misfit = along.judgement.unexplained
    if not found.same_law and misfit > MISFIT * along.expected:
        yield f"{PIXEL.roughly(misfit)} rms no parameter of either lens explains: the lens laws differ."
    if _differs(found):
        yield from _what_changed(found, length)


def _answer(found: "Difference") -> str:
    one = found.judgement
    if not any(found.stated):
        return "Neither calibration states its uncertainty, so nobody can say whether the difference means anything."
    test = f"{probability(one.p)}, {chi_square_of(one)}"
    if one.p >= CHANCE:
        return f"Nothing speaks against this being the same, unchanged camera ({test})."
    if one.p >= DOUBTFUL:
        return f"Doubtful: by chance alone so large a difference would be rare ({test}); calibrate once more."
    return f"This is not the same camera as before: chance does not explain the difference ({test})."


def chi_square_of(one: "Judgement") -> str:
    """Chi-square and its directions."""
    return f"chi-square {plain_number(one.chi_square, 3)} in {one.directions} direction{'s' * (one.directions != 1)}"


def _on_wall(found: "Difference", length: Unit) -> str:
    wall, nominal = found.wall, found.nominal_radius
    assert wall is not None
    assert nominal is not None
    at = int(np.argmin(np.abs(wall.radius - nominal)))
    where = f"On a wall of R = {nominal / length.size:.6g} {length.symbol}"
    if not np.isfinite(wall.mean[at]):
        return f"{where} the two have no common view."
    band, mean = length.roughly(wall.coverage * wall.u_mean[at]), length.roughly(wall.mean[at], sign=True)
    return (
        f"{where} the mean radius differs by {mean} (95 % of unchanged rigs stay within {band}), single radii by "
        f"{length.roughly(wall.rms[at])} rms."
    )


def _what_changed(found: "Difference", length: Unit) -> Iterator[str]:
    if not found.changes:
        return
    first = found.changes[0]
    if first.share >= MOST:
        share = f", {plain_number(100 * first.alone / first.before, 3, sign=True)} %" if first.before else ""
        yield (
            f"A change of {word_of(first.name)} alone by {_amount(first, length)}{share}, explains "
            f"{100 * first.share:.0f} % of it."
        )
    else:
        names = [word_of(one.name) for one in found.changes[:3]]
        yield f"No parameter alone explains it; first come {', '.join(names)}."
    yield "Find out what moved, and use the newer calibration for everything measured since."


def _amount(one: "Change", length: Unit) -> str:
    said = unit_of(one.name, length).said(one.alone, one.u_alone, sign=True)
    if not one.u_alone > 0:
        return said
    return f"{said} ({plain_number(abs(one.alone) / one.u_alone)} standard uncertainties)"


def _differs(found: "Difference") -> bool:
    return any(found.stated) and found.judgement.p < CHANCE
