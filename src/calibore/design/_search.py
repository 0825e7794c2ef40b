"""The search for good designs: a dense grid of lengths looked at with every camera and lens, then steps between."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.design._candidates import CONES, HEADS, ON_AXIS, SECOND_CLOCK, Candidate, widest
from calibore.design._head_map import head_map, head_outlook
from calibore.design._pareto import non_dominated
from calibore.design._requirement import CameraChoice, Requirement
from calibore.design._wall_map import Outlook, outlook, wall_map
from calibore.errors import InputError

Array = NDArray[np.float64]
LEAST_BASELINE = {"perpendicular-plane": 0.25, "coaxial-cone": 0.1, "reversed-cone": 0.2}
PROJECTIONS = (0.2, 3.0)
"""Nominal radii."""
TOO_LONG = 1.5
"""Rigs up to this share of the crawler's length are looked at, to say what a longer one would give."""
REFINEMENTS = (0.5, 0.25)
"""Steps of the refinement, in steps of the grid."""


class Task(NamedTuple):
    """One baseline [m] of a configuration, with all `projections` [m] of the grid."""

    configuration: str
    baseline: float
    projections: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Finding:
    """A candidate with its `costs` (4,) as in `Design.costs` and its `coverage`, as the grid sees them."""

    candidate: Candidate
    costs: Array
    coverage: float


def tasks_of(configuration: str, wanted: Requirement) -> list[Task]:
    """None where camera and laser do not fit beside each other, or the crawler is too short."""
    least, most = baselines(configuration, wanted)
    if not least < most:
        return []
    steps = wanted.search.steps
    if configuration not in (*CONES, *ON_AXIS):
        return [Task(configuration, float(at), (0.0,)) for at in np.geomspace(least, most, steps**2 // 2)]
    low, high = wanted.search.projection or (wanted.nominal_radius * share for share in PROJECTIONS)
    projections = tuple(np.geomspace(low, high, steps).tolist())
    return [Task(configuration, float(at), projections) for at in np.geomspace(least, most, steps)]


def baselines(configuration: str, wanted: Requirement) -> tuple[float, float]:
    """Least and most baseline [m] that can be built and carried; least above most where there is none."""
    bodies, laser = wanted.camera, wanted.laser
    if configuration in (*CONES, *HEADS):
        least = (min(body.body_diameter for body in bodies) + laser.diameter) / 2
        most = (widest(wanted) - (laser.diameter if configuration in CONES else 0.0)) / 2
    else:
        least = LEAST_BASELINE[configuration] * wanted.nominal_radius
        most = TOO_LONG * wanted.crawler.length - min(body.body_length for body in bodies)
    asked = wanted.search.baseline or (least, most)
    return max(least, asked[0]), min(most, asked[1])


def look(task: Task, wanted: Requirement) -> tuple[list[Finding], Finding | None]:
    """The designs of this baseline that cover enough and that no other with the same camera beats in everything; and
    the best of those that do not cover enough.
    """
    sights = [(at, sight_of(task.configuration, task.baseline, at, wanted)) for at in task.projections]
    covering: list[Finding] = []
    partly: list[Finding] = []
    for camera in wanted.camera:
        seen = _Seen.joined(
            [
                seen_with(sight, Candidate(task.configuration, camera, lens, task.baseline, at, 1.0), wanted)
                for at, sight in sights
                for lens in camera.lenses
            ]
        )
        enough = np.flatnonzero(seen.coverage >= wanted.requirement.coverage)
        covering += [seen.finding(int(enough[i])) for i in non_dominated(seen.costs[enough])]
        if len(enough) < len(seen.coverage):
            rest = np.where(seen.coverage < wanted.requirement.coverage, seen.coverage, -1.0)
            partly.append(seen.finding(int(np.lexsort((seen.costs[:, 0], -rest))[0])))
    return covering, min(partly, key=lambda one: (-one.coverage, one.costs[0]), default=None)


def refined(finding: Finding, wanted: Requirement) -> Finding:
    """Moves baseline and projection by parts of a grid step as long as the design gets better in something and worse
    in nothing.
    """
    tasks = tasks_of(finding.candidate.configuration, wanted)
    if len(tasks) < 2 or len(tasks[0].projections) < 2:
        return finding
    first, second = tasks[0].projections[:2]
    ratios = np.array([[tasks[1].baseline / tasks[0].baseline, 1.0], [1.0, second / first]])
    for step in (ratios**part for part in REFINEMENTS):
        for by_baseline, by_projection in (*step, *(1 / step)):
            at = finding.candidate
            near = replace(at, baseline=at.baseline * by_baseline, projection=at.projection * by_projection)
            seen = seen_with(sight_of(at.configuration, near.baseline, near.projection, wanted), near, wanted)
            no_worse = (seen.costs <= finding.costs).all(axis=1) & (seen.coverage >= finding.coverage)
            better = np.flatnonzero(no_worse & (seen.costs < finding.costs).any(axis=1))
            if better.size:
                finding = seen.finding(int(better[np.lexsort(seen.costs[better].T[::-1])[0]]))
    return finding


@dataclass(frozen=True, eq=False)
class _Seen:
    """Candidates by number: `k`, `coverage` (n,), `costs` (n, 4), and the `made_of` (n,) of `candidates`."""

    candidates: tuple[Candidate, ...]
    made_of: NDArray[np.intp]
    k: Array
    costs: Array
    coverage: Array

    @classmethod
    def joined(cls, parts: "list[_Seen]") -> "_Seen":
        starts = np.cumsum([0, *(len(part.candidates) for part in parts)])
        return cls(
            tuple(candidate for part in parts for candidate in part.candidates),
            np.concatenate([part.made_of + start for part, start in zip(parts, starts, strict=False)]),
            np.concatenate([part.k for part in parts]),
            np.concatenate([part.costs for part in parts]),
            np.concatenate([part.coverage for part in parts]),
        )

    def finding(self, i: int) -> Finding:
        candidate = replace(self.candidates[self.made_of[i]], k=float(self.k[i]))
        return Finding(candidate, self.costs[i], float(self.coverage[i]))


def seen_with(sight: "Sight | None", candidate: Candidate, wanted: Requirement) -> _Seen:
    """What the candidate's camera makes of it, at all scales worth having that fit and measure something."""
    found = sight and sight(candidate.camera, candidate.lens)
    if not found:
        return _Seen((), np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros((0, 4)), np.zeros(0))
    view, aims = found
    fits = np.array([candidate.fits(wanted, aim) for aim in aims])
    if fits.size == 1:
        fits = np.repeat(fits, view.k.size)
    diameters = np.broadcast_to([candidate.diameter(wanted.laser, aim) for aim in aims], view.k.shape)
    length = np.full(view.k.shape, candidate.length(wanted.laser))
    costs = np.stack([view.u95, np.maximum(view.smallest, diameters / 2), -view.occlusion, length], axis=1)
    kept = fits & (view.coverage > 0)
    return _Seen((candidate,), np.zeros(int(kept.sum()), np.intp), view.k[kept], costs[kept], view.coverage[kept])


Sight = Callable[[CameraChoice, str], tuple[Outlook, list[float]] | None]
"""From a camera and the name of a lens: what they see, and the aim at every scale (or one for all)."""


def sight_of(configuration: str, baseline: float, projection: float, wanted: Requirement) -> Sight | None:
    """None where the geometry is impossible."""
    if configuration in HEADS:
        head = head_map(baseline, wanted)

        def of_head(camera: CameraChoice, lens: str) -> tuple[Outlook, list[float]] | None:
            found = head_outlook(head, camera, lens, wanted)
            return found and (found[0], found[1].tolist())

        return of_head
    try:
        one = wall_map("single-cone" if configuration == "dual-cone" else configuration, baseline, projection, wanted)
    except InputError:
        return None
    maps = [one, one.turned(SECOND_CLOCK)] if configuration == "dual-cone" else [one]

    def of_wall(camera: CameraChoice, lens: str) -> tuple[Outlook, list[float]] | None:
        found = outlook(maps, camera, lens, wanted)
        return found and (found, [0.0])

    return of_wall
