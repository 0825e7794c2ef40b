"""What an optimisation says to the one who has to build and pay."""

from collections.abc import Iterator

import numpy as np

from calibore.design import Optimised, Option
from calibore.plotting import LengthUnit, length_unit

REQUIREMENTS = {
    "u95": "the accuracy (U95)",
    "length": "the length",
    "deflection": "the smallest radius",
    "occlusion": "the occlusion angle",
    "coverage": "the coverage of the circumference",
}


def recommendation(found: Optimised, *, unit: str = "mm") -> list[str]:
    """Which rig, why, what it costs, and what binds; where nothing meets the requirements, what to relax."""
    scale, best = length_unit(unit), found.recommended
    if best.meets:
        return [f"Build {_built(best, scale)}.", _achieved(found, best, scale), _room(best)]
    nearest = f"No design meets all requirements. Nearest is {_built(best, scale)}."
    return [nearest, _achieved(found, best, scale), *_relax(found, best, scale)]


def alternatives(found: Optimised, *, unit: str = "mm") -> list[str]:
    """One sentence for every other configuration: what it would gain and cost, or why it cannot be."""
    scale = length_unit(unit)
    others = [one for one in found.by_configuration.values() if one is not found.recommended]
    sentences = [_partly(one, scale) if one in found.partly else _compared(found, one, scale) for one in others]
    return [*sentences, *(f"{reason[:1].upper()}{reason[1:]}" for reason in found.impossible.values())]


def budgets(found: Optimised, *, unit: str = "mm") -> list[dict[str, str]]:
    """What would be recommended for other budgets of U95."""
    scale = length_unit(unit)
    return [
        {"budget": _length(budget, scale), "meets": _meets(found, option, budget), **row(option, scale)}
        for budget, option in found.by_budget
    ]


def row(option: Option, scale: LengthUnit) -> dict[str, str]:
    """A design as text, for tables."""
    design, candidate = option.design, option.design.candidate
    return {
        "configuration": candidate.configuration,
        "camera": candidate.camera.name,
        "lens": f"{candidate.lens}, {np.degrees(field_of_view(option)):.0f} deg",
        "baseline": _length(candidate.baseline, scale),
        "projection": _length(candidate.projection, scale) if candidate.projection else "-",
        "u95": _length(design.u95, scale),
        "smallest": _length(design.smallest_radius, scale),
        "occlusion": f"{np.degrees(design.occlusion):.0f} deg",
        "length": _length(design.length, scale),
        "diameter": _length(design.diameter, scale),
        "coverage": f"{100 * design.coverage:.0f} %",
        "meets": "yes" if option.meets else f"no: {', '.join(_missed(option))}",
    }


def field_of_view(option: Option) -> float:
    """[rad] the whole angle across the longer side of the image."""
    from calibore.optics import Lens

    candidate = option.design.candidate
    side = max(candidate.camera.width, candidate.camera.height) / 2
    return 2 * float(np.nan_to_num(Lens(candidate.lens, candidate.k, 1.0).zenith(side), nan=np.pi))


def _built(option: Option, scale: LengthUnit) -> str:
    candidate = option.design.candidate
    projection = f" and a projection of {_length(candidate.projection, scale)}" if candidate.projection else ""
    lens = f"{candidate.lens} lens of {np.degrees(field_of_view(option)):.0f} deg across the longer side"
    return (
        f"a {candidate.configuration} rig with a baseline of {_length(candidate.baseline, scale)}{projection}, with "
        f'the camera "{candidate.camera.name}" and its {lens} (k = {candidate.k:.0f} px)'
    )


def _achieved(found: Optimised, option: Option, scale: LengthUnit) -> str:
    design, wanted = option.design, found.wanted
    least, most, budget = (_length(value, scale) for value in (*wanted.radii, wanted.budget))
    share = f"{100 * design.u95 / wanted.nominal_radius:.2f} % of the nominal radius (budget {budget})"
    return (
        f"From {least} to {most} it measures every radius with a U95 of {_length(design.u95, scale)} or better, "
        f"{share}; it measures radii down to {_length(design.smallest_radius, scale)}, wall and rays meet at "
        f"{np.degrees(design.occlusion):.0f} deg or more, and the rig is {_length(design.length, scale)} long and "
        f"{_length(design.diameter, scale)} across."
    )


def _room(option: Option) -> str:
    used = f"{100 * option.demands[option.binding]:.0f} %"
    return (
        f"The binding requirement is {REQUIREMENTS[option.binding]}: {used} of what is allowed is used up. No other "
        "design found leaves its tightest requirement more room."
    )


def _relax(found: Optimised, option: Option, scale: LengthUnit) -> Iterator[str]:
    design, wanted = option.design, found.wanted
    needed = {
        "u95": f"allow a U95 of {_length(design.u95, scale)} instead of {_length(wanted.budget, scale)}",
        "length": f"give it {_length(design.length, scale)} of length, not {_length(wanted.crawler.length, scale)}",
        "deflection": f"measure no smaller radius than {_length(design.smallest_radius, scale)} instead of "
        f"{_length(wanted.smallest_wanted, scale)}",
        "occlusion": f"accept an occlusion angle of {np.degrees(design.occlusion):.0f} deg",
        "coverage": f"accept that {100 * design.coverage:.0f} % of the circumference is measured",
    }
    yield f"To build it, {', and '.join(needed[name] for name in sorted(_missed_names(option)))}."
    if "u95" in _missed_names(option):
        yield "Otherwise offer a camera with more pixels, find the line better (noise.stripe), or build more exactly."


def _compared(found: Optimised, option: Option, scale: LengthUnit) -> str:
    best, one = found.recommended.design, option.design
    longer = one.length - best.length
    length = f"{_length(abs(longer), scale)} {'longer' if longer > 0 else 'shorter'}"
    u95 = f"{one.u95 / best.u95:.2g} times that U95 ({_length(one.u95, scale)})"
    verdict = "it meets all requirements" if option.meets else f"it misses {' and '.join(_missed(option))}"
    return (
        f'The best {one.candidate.configuration} rig, with the camera "{one.candidate.camera.name}", has {u95}, is '
        f"{length}, measures radii down to {_length(one.smallest_radius, scale)} at an occlusion angle of "
        f"{np.degrees(one.occlusion):.0f} deg; {verdict}."
    )


def _partly(option: Option, scale: LengthUnit) -> str:
    design = option.design
    return (
        f"A {design.candidate.configuration} rig covers at most {100 * design.coverage:.0f} % of the circumference: "
        "elsewhere rays run along the light or leave the image, and a point there is not measurable to first order. "
        f"Where it measures, its U95 is {_length(design.u95, scale)} or better; a second laser fills the gaps."
    )


def _meets(found: Optimised, option: Option, budget: float) -> str:
    from calibore.design import demands_of

    return "yes" if max(demands_of(option.design, found.wanted, budget=budget).values()) <= 1 else "no"


def _missed_names(option: Option) -> list[str]:
    return [name for name, demand in option.demands.items() if demand > 1]


def _missed(option: Option) -> list[str]:
    return [REQUIREMENTS[name] for name in _missed_names(option)]


def _length(value: float, scale: LengthUnit) -> str:
    """Three digits, four from 100 on."""
    number = value / scale.metres
    return f"{number:.{3 if number < 100 else 4}g} {scale.symbol}"
