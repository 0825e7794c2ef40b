"""The verdict on a difference, for people who have to decide whether to go on measuring."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from calibore.calibration._in_words import Unit, unit_of, word_of

if TYPE_CHECKING:
    from calibore.calibration._difference._changes import Change
    from calibore.calibration._difference._difference import Difference

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
        f"Directions differ by {along.rms:.2g} px rms over the image, where the stated uncertainties let expect "
        f"{along.expected:.2g} px; a turn of {np.degrees(np.linalg.norm(along.turn)):.2g} deg is taken out."
    )
    if found.wall is not None:
        yield _on_wall(found, length)
    misfit = along.judgement.unexplained
    if not found.same_law and misfit > MISFIT * along.expected:
        yield f"{misfit:.2g} px rms no parameter of either lens explains: the lens laws differ."
    if _differs(found):
        yield from _what_changed(found, length)


def _answer(found: "Difference") -> str:
    one = found.judgement
    if not any(found.stated):
        return "Neither calibration states its uncertainty, so nobody can say whether the difference means anything."
    test = f"p {_probability(one.p)}, chi-square {one.chi_square:.3g} in {one.directions} directions"
    if one.p >= CHANCE:
        return f"Nothing speaks against this being the same, unchanged camera ({test})."
    if one.p >= DOUBTFUL:
        return f"Doubtful: by chance alone so large a difference would be rare ({test}); calibrate once more."
    return f"This is not the same camera as before: chance does not explain the difference ({test})."


def _on_wall(found: "Difference", length: Unit) -> str:
    wall, nominal, metres, unit = found.wall, found.nominal_radius, length.size, length.symbol
    assert wall is not None
    assert nominal is not None
    at = int(np.argmin(np.abs(wall.radius - nominal)))
    where = f"On a wall of R = {nominal / metres:.4g} {unit}"
    if not np.isfinite(wall.mean[at]):
        return f"{where} the two have no common view."
    band = wall.coverage * wall.u_mean[at] / metres
    return (
        f"{where} the mean radius differs by {wall.mean[at] / metres:+.2g} {unit} (95 % of unchanged rigs stay within "
        f"{band:.2g} {unit}), single radii by {wall.rms[at] / metres:.2g} {unit} rms."
    )


def _what_changed(found: "Difference", length: Unit) -> Iterator[str]:
    if not found.changes:
        return
    first = found.changes[0]
    if first.share >= MOST:
        share = f", {100 * first.alone / first.before:+.3g} %" if first.before else ""
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
    sigmas = abs(one.alone) / one.u_alone if one.u_alone > 0 else np.inf
    return f"{said} ({sigmas:.2g} standard uncertainties)"


def _differs(found: "Difference") -> bool:
    return any(found.stated) and found.judgement.p < CHANCE


def _probability(p: float) -> str:
    return f"= {p:.2g}" if p >= DOUBTFUL else f"< {DOUBTFUL:g}"
