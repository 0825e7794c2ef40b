"""What an optimisation found as plain data: numbers in SI, units in the names."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

from calibore.design._choice import Option
from calibore.design._optimise import Optimised
from calibore.design._verification import Verification

PARETO_FORMAT = "calibore-pareto/1"


def numbered(found: Optimised) -> dict[str, Option]:
    """Every design by its name: configuration and number, in the order of the options; then those that cover a part,
    then the best of cameras that are beaten everywhere.
    """
    extra = (*found.by_configuration.values(), *(one for one in found.by_camera.values() if one))
    every = {id(one): one for one in (*found.options, *found.partly, *extra)}
    counts: Counter[str] = Counter()
    names: dict[str, Option] = {}
    for option in every.values():
        configuration = option.design.candidate.configuration
        counts[configuration] += 1
        names[f"{configuration}-{counts[configuration]:02d}"] = option
    return names


def plain_optimisation(found: Optimised, verified: Mapping[str, Verification]) -> dict[str, Any]:
    """For pareto.json; `verified` by configuration."""
    names = numbered(found)
    name_of = {id(option): name for name, option in names.items()}

    def name(option: Option | None) -> str | None:
        return name_of[id(option)] if option else None

    return {
        "format": PARETO_FORMAT,
        "name": found.wanted.name,
        "requirement": _requirement(found),
        "recommended": name(found.recommended),
        "by_configuration": {key: name(option) for key, option in found.by_configuration.items()},
        "by_camera": {key: name(option) for key, option in found.by_camera.items()},
        "by_budget": [{"u95_m": budget, "recommended": name(option)} for budget, option in found.by_budget],
        "impossible": found.impossible,
        "verification": {key: vars(one) for key, one in verified.items()},
        "designs": [_design(key, option, found) for key, option in names.items()],
    }


def _requirement(found: Optimised) -> dict[str, Any]:
    wanted = found.wanted
    return {
        "nominal_radius_m": wanted.nominal_radius,
        "least_radius_m": wanted.radii[0],
        "most_radius_m": wanted.radii[1],
        "u95_m": wanted.budget,
        "smallest_radius_m": wanted.smallest_wanted if wanted.requirement.deflection else None,
        "coverage": wanted.requirement.coverage,
        "occlusion_rad": wanted.requirement.occlusion,
        "length_m": wanted.crawler.length,
        "diameter_m": wanted.crawler.diameter,
        "stripe_px": wanted.noise.stripe,
        "length_limit_m": wanted.noise.length.at(wanted.nominal_radius),
    }


def _design(name: str, option: Option, found: Optimised) -> dict[str, Any]:
    design, candidate = option.design, option.design.candidate
    return {
        "name": name,
        "configuration": candidate.configuration,
        "camera": candidate.camera.name,
        "lens": candidate.lens,
        "k_px": candidate.k,
        "baseline_m": candidate.baseline,
        "projection_m": candidate.projection or None,
        "u95_m": design.u95,
        "u95_percent_of_radius": 100 * design.u95 / found.wanted.nominal_radius,
        "smallest_radius_m": design.smallest_radius,
        "occlusion_rad": design.occlusion,
        "length_m": design.length,
        "diameter_m": design.diameter,
        "coverage": design.coverage,
        "worst_clock_rad": design.worst_clock,
        "worst_radius_m": design.worst_radius,
        "on_front": option.on_front,
        "meets": option.meets,
        "demands": dict(option.demands),
        "binding": option.binding,
        "rig": f"rigs/{name}.toml",
    }
