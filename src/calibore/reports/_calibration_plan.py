"""`write_plan_page`: which picture of a target to take next, and what it brings on the wall."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from calibore.calibration import Plan, Step
from calibore.plotting import COVERAGE_FACTOR, length_unit, plain_text, plan_pictures
from calibore.reports._calibration_page import write_page
from calibore.reports._calibration_words import Fact

LISTED = 20
"""Of the ranking that the page shows; plan.json has all."""
METHOD = (
    "What a picture tells does not depend on what will be seen on it: the sensitivities of its marks at the rig's "
    "present parameters, less what its unknown pose and the errors of the target's making take up, are added to "
    "what is known now. u is the standard uncertainty that all points of a scan share, root of the mean variance "
    "round the clock. Distances of rings and boards are from the entrance pupil to the target's middle, its top as it "
    "is seen in the image; ranges of a side-facing head are those of the slide."
)


def write_plan_page(plan: Plan, out: Path | str, *, unit: str = "mm") -> Path:
    """`out`/plan.html with all pictures and numbers (plan.json) beside it, all or nothing; its path."""
    scale = length_unit(unit)
    words = {
        "title": "What to photograph next",
        "subtitle": f"For a wall of R = {plan.nominal_radius / scale.metres:.4g} {unit}; "
        f"{len(plan.ranking)} pictures considered.",
        "facts": _facts(plan, unit),
        "sentences": [plan.advice(unit)],
        "steps": _rows(plan, plan.steps, unit),
        "ranking": _rows(plan, plan.ranking[:LISTED], unit),
        "method": METHOD,
    }
    return write_page(out, "plan", words=words, data=_data(plan), pictures=plan_pictures(plan, unit=unit))


def _facts(plan: Plan, unit: str) -> list[Fact]:
    size = length_unit(unit).metres
    there = f"U (k = {COVERAGE_FACTOR:g}) at R = {plan.nominal_radius / size:.4g} {unit}"
    shown = [("After the best next picture", plan.ranking[0])]
    if len(plan.steps) > 1:
        shown.append((f"After {len(plan.steps)} pictures", plan.steps[-1]))
    return [
        {"name": "Now", "value": _u(plan.before, unit, COVERAGE_FACTOR), "remark": there},
        *(
            {"name": name, "value": _u(step.u, unit, COVERAGE_FACTOR), "remark": f"{_less(plan, step)} less"}
            for name, step in shown
        ),
    ]


def _rows(plan: Plan, steps: Iterable[Step], unit: str) -> list[Fact]:
    size = length_unit(unit).metres
    return [
        {"number": f"{number}.", "picture": step.shot.said(unit), "u": plain_text(step.u / size), "unit": unit,
         "less": _less(plan, step)}
        for number, step in enumerate(steps, start=1)
    ]  # fmt: skip


def _u(u: float, unit: str, k: float) -> str:
    return f"{plain_text(k * u / length_unit(unit).metres)} {unit}"


def _less(plan: Plan, step: Step) -> str:
    part = 100 * (1 - step.u / plan.before)
    return f"{part:.{0 if part >= 10 else 1}f} %"


def _data(plan: Plan) -> dict[str, Any]:
    known = plan.covariance
    return {
        "units": "SI (m, rad); standard uncertainties (k = 1)",
        "advice": plan.advice(),
        "nominal_radius": plan.nominal_radius,
        "u_now": plan.before,
        "steps": [_step(step) for step in plan.steps],
        "ranking": [_step(step) for step in plan.ranking],
        "wall": {"radius": plan.radius, "u_now": plan.u_before, "u_after": plan.u_after},
        "covariance_after": {"names": known.names, "matrix": known.matrix},
    }


def _step(step: Step) -> dict[str, Any]:
    shot = step.shot
    return {
        "picture": shot.said(), "u": step.u, "distance": shot.distance, "tilt": shot.tilt, "towards": shot.towards,
        "place": shot.place, "diameter": shot.diameter, "in_light": shot.in_light,
    }  # fmt: skip
