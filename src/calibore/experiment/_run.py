"""The whole experiment, step by step; a step that is done is not done again."""

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TypeVar

from calibore.calibration import Calibration, read_calibration
from calibore.crews import Cluster, Workers
from calibore.experiment._calibrations import calibrated, prepared
from calibore.experiment._in_situ import VARIANT, in_situ_job
from calibore.experiment._instruments import instrument_named
from calibore.experiment._outcome import Judgement, LaserOutcome, read_laser
from calibore.experiment._plan import Plan, settle
from calibore.experiment._scans import EXACT, scan_sections, steps_of, variants_of
from calibore.experiment._touch import STEPS, judged_touch, profile_of, touch
from calibore.experiment._workshop import Progress, Workshop
from calibore.scans import Profile, read_profile

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class Outcome:
    """What the experiment of `plan` found: every laser's errors, the tactile profile and its own errors against the
    truth, calibrations by (rig file, instrument).
    """

    plan: Plan
    lasers: tuple[LaserOutcome, ...]
    touched: Profile
    touch_errors: Judgement
    calibrations: dict[tuple[str, str], Calibration]

    def of_kind(self, kind: str) -> list[LaserOutcome]:
        """Those that are a "plane", a "cone" or a head, "side"."""
        return [one for one in self.lasers if one.instrument.kind == kind]


def run_experiment(
    out: Path | str,
    plan: Plan,
    *,
    crew: Workers = 1,
    keep_pictures: bool = False,
    progress: Progress | None = None,
) -> Outcome:
    """Chapters 6 to 8 of Swanbom 2007 on a simulated pipe, in the folder `out`, where an interrupted run goes on.

    `crew` simulates and profiles; `progress(done, total)` counts pictures taken and measured, and other steps. Raises
    OutputError where `out` holds anything else, or the experiment of another plan.
    """
    out = Path(out).absolute()
    settle(out, plan)
    workshop = Workshop(out, plan, crew, keep_pictures, progress)
    every = [instrument_named(name) for name in plan.instruments]
    files = [(one.name, variant) for one in every for variant in variants_of(one)]
    workshop.total = STEPS + 2 * len(files) + sum(steps_of(one, workshop) for one in every) + len(every)
    with _processes(crew) as apart:
        touch(workshop)
        for name, variant in files:
            prepared(instrument_named(name), variant, workshop)
        for _ in apart(partial(_calibrated, _alone(workshop)), files):
            workshop.count(1)
        for instrument in every:
            besides = partial(in_situ_job, instrument, workshop)
            scan_sections(instrument, workshop, besides=besides)
        touched = read_profile(profile_of(workshop))
        lasers = []
        for found in apart(partial(_read, _alone(workshop), touched), [one.name for one in every]):
            lasers.append(found)
            workshop.count(1)
    return Outcome(plan, tuple(lasers), touched, judged_touch(workshop, touched), _calibrations(workshop))


def _calibrated(workshop: Workshop, item: tuple[str, str]) -> None:
    calibrated(instrument_named(item[0]), item[1], workshop)


def _read(workshop: Workshop, touched: Profile, name: str) -> LaserOutcome:
    return read_laser(instrument_named(name), workshop, touched)


def _alone(workshop: Workshop) -> Workshop:
    """For another process: it counts nothing and works by itself."""
    return replace(workshop, crew=1, progress=None)


def _calibrations(workshop: Workshop) -> dict[tuple[str, str], Calibration]:
    found = {}
    for instrument in map(instrument_named, workshop.plan.instruments):
        for variant in (*variants_of(instrument), VARIANT):
            place = workshop.calibration(variant, instrument.name)
            if variant != EXACT and place.exists():
                found[variant, instrument.name] = read_calibration(place)
    return found


def _keep_to_one_core() -> None:
    """Linear algebra of every process would take all cores, and wait for the others'."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(limits=1, user_api="blas")


Apart = Callable[[Callable[[Item], Result], Sequence[Item]], Iterator[Result]]


@contextmanager
def _processes(crew: Workers) -> Iterator[Apart]:
    """A map over processes of this machine, in order, for what threads would do one after the other."""
    hands = multiprocessing.cpu_count() if isinstance(crew, Cluster) else crew
    if hands <= 1:
        yield map  # type: ignore[misc]
        return
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(hands, mp_context=fresh, initializer=_keep_to_one_core) as pool:
        yield pool.map  # type: ignore[misc]
