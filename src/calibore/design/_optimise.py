"""`optimise`: the Pareto set of rigs for a requirement, and which of them to build."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from calibore.design._appraisal import Design, appraise
from calibore.design._candidates import Candidate, widest
from calibore.design._choice import Costed, Option, best_of, demands_of
from calibore.design._pareto import non_dominated, spread
from calibore.design._requirement import CameraChoice, Requirement
from calibore.design._search import Finding, baselines, look, refined, tasks_of
from calibore.errors import InputError

SHOWN = 24
"""Designs of each configuration that stand for its Pareto set, beside the recommended ones."""
BUDGETS = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Of the required U95, for which a recommendation is given too."""
Progress = Callable[[int, int], None]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Optimised:
    """`options`: designs that cover enough of the circumference, by configuration and U95, of each configuration its
    Pareto set; `partly`: of each configuration that never does, the one that covers most; `impossible`: why a
    configuration has none at all. `recommended`, the best `by_configuration`, `by_camera` (None: nothing found) and
    `by_budget` [m]: entries of `options`.
    """

    wanted: Requirement
    options: tuple[Option, ...]
    partly: tuple[Option, ...]
    impossible: dict[str, str]
    recommended: Option
    by_configuration: dict[str, Option]
    by_camera: dict[str, Option | None]
    by_budget: tuple[tuple[float, Option], ...]


def optimise(wanted: Requirement, *, workers: int = 1, progress: Progress | None = None) -> Optimised:
    """Searches every configuration with every camera and lens; `workers` processes, whose number changes nothing.

    Raises InputError where no configuration fits the crawler's envelope.
    """
    tell = progress or (lambda done, total: None)
    configurations = wanted.search.configurations
    tasks = [task for name in configurations for task in tasks_of(name, wanted)]
    with _pool(workers) as run:
        found = run(partial(look, wanted=wanted), tasks, lambda done: tell(done, len(tasks)))
        chosen, partly = _chosen([(task.configuration, *one) for task, one in zip(tasks, found, strict=True)], wanted)
        total = len(tasks) + len(chosen) + len(partly)
        jobs = [*chosen, *partly]
        designs = run(partial(_settled, wanted=wanted), jobs, lambda done: tell(len(tasks) + done, total))
    covering = [one for one in designs if one is not None and one.coverage >= wanted.requirement.coverage]
    rest = [one for one in designs if one is not None and one.coverage < wanted.requirement.coverage]
    return _concluded(wanted, covering, rest)


def _chosen(found: list[tuple[str, list[Finding], Finding | None]], wanted: Requirement) -> tuple[list[Finding], ...]:
    """Of each configuration, findings that stand for its Pareto set, and those that some requirement, budget or camera
    asks for; and the best of the configurations that cover too little.
    """
    chosen: dict[int, Finding] = {}
    partly: list[Finding] = []
    for name in wanted.search.configurations:
        covering = [one for configuration, some, _ in found if configuration == name for one in some]
        if not covering:
            some = [one for configuration, _, one in found if configuration == name and one is not None]
            partly += [min(some, key=lambda one: (-one.coverage, one.costs[0]))] if some else []
            continue
        front = [covering[i] for i in non_dominated(_costs(covering))]
        wished = [front[i] for i in spread(_costs(front), SHOWN)]
        wished += [best_of(front, wanted, budget=share * wanted.budget) for share in BUDGETS]
        by_camera = ([one for one in covering if one.candidate.camera == camera] for camera in wanted.camera)
        wished += [best_of(some, wanted) for some in by_camera if some]
        chosen |= {id(one): one for one in wished}
    return list(chosen.values()), partly


def _settled(finding: Finding, wanted: Requirement) -> Design | None:
    return appraise(refined(finding, wanted).candidate, wanted)


def _concluded(wanted: Requirement, covering: list[Design], rest: list[Design]) -> Optimised:
    if not covering and not rest:
        raise InputError(" ".join(why_none(name, wanted) for name in wanted.search.configurations))
    front = set(_front(covering))
    option = {id(one): Option(one, demands_of(one, wanted), number in front) for number, one in enumerate(covering)}
    option |= {id(one): Option(one, demands_of(one, wanted), on_front=False) for one in rest}

    def best(designs: list[Design], budget: float | None = None) -> Option:
        return option[id(best_of(designs, wanted, budget=budget))]

    groups = {name: _of(covering, name) or _of(rest, name) for name in wanted.search.configurations}
    fronts = {name: [group[i] for i in _front(group)] for name, group in groups.items()}
    shown = [one for group in fronts.values() for one in group if one.coverage >= wanted.requirement.coverage]
    cameras = {camera.name: [one for one in covering if one.candidate.camera == camera] for camera in wanted.camera}
    return Optimised(
        wanted,
        tuple(option[id(one)] for one in shown),
        tuple(option[id(one)] for one in rest),
        {name: why_none(name, wanted) for name, group in groups.items() if not group},
        best(shown or rest),
        {name: best(group) for name, group in fronts.items() if group},
        {name: best(designs) if designs else None for name, designs in cameras.items()},
        tuple((share * wanted.budget, best(shown or rest, share * wanted.budget)) for share in BUDGETS),
    )


def why_none(configuration: str, wanted: Requirement) -> str:
    """Why there is no design at all."""
    least, most = baselines(configuration, wanted)
    if not least < most:
        return (
            f"{configuration}: bodies and search ask for a baseline of at least {1e3 * least:.0f} mm, and envelope, "
            f"pipe and search leave at most {1e3 * most:.0f} mm; choose smaller bodies or a larger envelope."
        )
    size = min(_slimmest(configuration, camera, least, wanted) for camera in wanted.camera)
    if size > widest(wanted):
        return (
            f"{configuration}: with the smallest camera the rig is at least {1e3 * size:.0f} mm across, and only "
            f"{1e3 * widest(wanted):.0f} mm pass the envelope and the smallest pipe; choose a shorter camera."
        )
    return f"{configuration}: no camera that fits sees any of the wall well enough; offer other lenses or lengths."


def _slimmest(configuration: str, camera: CameraChoice, baseline: float, wanted: Requirement) -> float:
    candidate = Candidate(configuration, camera, camera.lenses[0], baseline, 0.0, 1.0)
    return min(candidate.diameter(wanted.laser, aim) for aim in np.linspace(0, np.pi / 2, 19)[:-1])


def _of(designs: list[Design], configuration: str) -> list[Design]:
    return [one for one in designs if one.candidate.configuration == configuration]


def _front(designs: list[Design]) -> list[int]:
    """Indices of those no other beats, by U95."""
    front = non_dominated(_costs(designs)).tolist() if designs else []
    return sorted(front, key=lambda i: tuple(designs[i].costs))


def _costs(designs: Sequence[Costed]) -> NDArray[np.float64]:
    return np.stack([one.costs for one in designs])


@contextmanager
def _pool(workers: int) -> Iterator[Callable[..., list]]:
    """How jobs are run: here, or in fresh processes; results in the order of the jobs."""

    def counted(results: Iterator[Result], tell: Callable[[int], None]) -> list[Result]:
        gathered = []
        for result in results:
            gathered.append(result)
            tell(len(gathered))
        return gathered

    if workers == 1:
        yield lambda work, jobs, tell: counted(map(work, jobs), tell)
        return
    import multiprocessing
    import signal
    from concurrent.futures import ProcessPoolExecutor

    undisturbed = partial(signal.signal, signal.SIGINT, signal.SIG_IGN)  # the parent tells of an interrupt, once
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=undisturbed)
    try:
        yield lambda work, jobs, tell: counted(pool.map(work, jobs), tell)
    finally:
        pool.shutdown(cancel_futures=True)
