"""What a designer reads first: sentences and key numbers of an analysed design."""

from collections.abc import Iterator
from math import isfinite, isinf

import numpy as np

from calibore.design import STRIPE, Analysis, Region
from calibore.plotting import LengthUnit, length_unit, parameter_words

SHALLOW = np.radians(20)
"""Below, a bump hides nearly three times its height and more."""


def verdicts(design: Analysis, *, unit: str = "mm") -> list[str]:
    """One sentence per question: how well, how much of the pipe, what hides, does it fit, how well to build."""
    scale = length_unit(unit)
    return [
        *_how_well(design, scale),
        *_how_much(design, scale),
        *_what_hides(design, scale),
        _does_it_fit(design, scale),
        *_how_to_build(design, scale),
    ]


def key_facts(design: Analysis, *, unit: str = "mm") -> list[dict[str, str]]:
    """Name, value and remark of the numbers on top of the page."""
    scale, k = length_unit(unit), design.assumptions.coverage_factor
    least, most = design.limits.everywhere
    camera = min(_least(one.camera) for one in design.occlusion)
    light = min(_least(one.light) for one in design.occlusion)
    one = design.deployment
    return [
        _fact("U of R, worst useful clock", _text(k * design.u_worst, scale), f"k = {k:g}, nominal wall"),
        _fact("U of R, middle clock", _text(k * _middle(design), scale), _percent(_middle(design) * k, design)),
        _fact("Nominal wall measured", f"{100 * design.limits.fraction:.0f} %", "of the clock, at first order"),
        _fact("Measured at every clock", f"{_text(least, scale)} to {_most(most, scale)}", "radius of the wall"),
        _fact("Occlusion angle", f"{np.degrees(camera):.1f} deg", f"of the light {np.degrees(light):.1f} deg"),
        _fact("Through the manhole", "fits" if one.fits else "does not fit", f"longest {_text(one.longest, scale)}"),
    ]


def _how_well(design: Analysis, scale: LengthUnit) -> Iterator[str]:
    k = design.assumptions.coverage_factor
    if not isfinite(design.u_worst):
        yield "The nominal wall is nowhere measured at first order; change baseline, projection or field of view."
        return
    first = next(iter(design.shares), "")
    yield (
        f"On the nominal wall the expanded uncertainty of R (k = {k:g}) is {_text(k * _middle(design), scale)} at the "
        f"middle clock and {_text(k * design.u_worst, scale)} at the worst useful one; "
        f"{100 * design.shares.get(first, 0):.0f} % of the variance comes from {_words(first)}."
    )


def _how_much(design: Analysis, scale: LengthUnit) -> Iterator[str]:
    share, (least, most) = design.limits.fraction, design.limits.everywhere
    if share < 1:
        yield (
            f"{100 * (1 - share):.0f} % of the nominal wall is not measured: the camera ray only grazes the light "
            "there, or the image does not see it."
        )
    if isfinite(least):
        yield f"Radii from {_text(least, scale)} to {_most(most, scale)} are measured at every clock."
    doubt = max((one.fraction(Region.AMBIGUOUS) for one in design.maps), default=0.0)
    if doubt > 0:
        yield (
            f"On up to {100 * doubt:.0f} % of the image a line could come from two walls; "
            "the neighbouring points and the expected radius decide."
        )


def _what_hides(design: Analysis, scale: LengthUnit) -> Iterator[str]:
    along, around = float(design.bump_shadow.along[0]), float(design.bump_shadow.around[0])
    yield (
        f"A bump {_text(design.bump, scale)} high hides up to {_text(along, scale)} of wall behind it along the pipe, "
        f"and up to {_text(around, scale)} beside it."
    )
    if min(min(_least(one.camera), _least(one.light)) for one in design.occlusion) < SHALLOW:
        yield "Some rays are shallow (below 20 deg): joints and corrugations will hide much behind them."


def _does_it_fit(design: Analysis, scale: LengthUnit) -> str:
    one = design.deployment
    what = f"rig {_text(one.rig_length, scale)} + body {_text(one.body_length, scale)}, {_text(one.height, scale)} high"
    if one.fits:
        spare = _text(one.longest - one.length, scale)
        return f"It passes a manhole of {_text(one.manhole, scale)} ({what}), with {spare} to spare."
    return (
        f"It does not pass a manhole of {_text(one.manhole, scale)} ({what}): the longest body of that height is "
        f"{_text(one.longest, scale)}; shorten baseline or body, or hinge it."
    )


def _how_to_build(design: Analysis, scale: LengthUnit) -> Iterator[str]:
    asked = design.tolerances
    if asked is None or not isfinite(design.u_worst):
        return
    k = design.assumptions.coverage_factor
    target, now = k * asked.target, k * design.u_worst
    word = "meets" if now <= target else "misses"
    yield (
        f"With the stated inputs it {word} the target of {_text(target, scale)} ({_text(now, scale)} predicted at the "
        "worst useful clock); the table of tolerances says what each parameter is allowed."
    )


def _words(inputs: str) -> str:
    return ", ".join(
        "the noise of the line" if name == STRIPE else parameter_words(name) for name in inputs.split(" + ")
    )


def _middle(design: Analysis) -> float:
    """Standard uncertainty of R [m] on the nominal wall at the middle clock."""
    nearest = int(np.argmin(np.abs(design.radius.values - 1)))
    return float(design.radius.middle[nearest])


def _least(values: np.ndarray) -> float:
    return float(np.nanmin(values)) if np.isfinite(values).any() else float("nan")


def _text(metres: float, scale: LengthUnit) -> str:
    return f"{metres / scale.metres:.3g} {scale.symbol}" if isfinite(metres) else "none"


def _most(metres: float, scale: LengthUnit) -> str:
    return "any" if isinf(metres) else _text(metres, scale)


def _percent(metres: float, design: Analysis) -> str:
    return f"{100 * metres / design.nominal_radius:.2g} % of the radius"


def _fact(name: str, value: str, remark: str) -> dict[str, str]:
    return {"name": name, "value": value, "remark": remark}
