"""Is the line taken and nothing else? `python -m benchmarks line_choice` over random scenes with light that is not the
line: missed and false clock positions against the truth, and what the confidence of the choice is worth.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from benchmarks.glare_scenes import KINDS, Scene, scenes
from calibore.errors import ImageError
from calibore.profiling import Job, measure_image
from calibore.rigs import triangulate
from calibore.status import Status
from calibore.stripe import detect_ring

MEASURABLE = 0.05
"""Signal from which a point counts (data README)."""
GROSS = 0.025
"""Of the nominal radius; farther off is false."""
EDGE = 2
"""Clock positions."""
BINS = np.array([0.2, 0.4, 0.6, 0.8, 0.95, 1.0])


class Counted(NamedTuple):
    """Clock positions of some pictures: `wanted`, of these `missed`; `false`, of these `plain` with status OK; and how
    many pictures were `refused`.
    """

    wanted: int
    missed: int
    false: int
    plain: int
    refused: int


def report(count: str = "40", rig_kind: str = "perpendicular-plane", first: str = "1000", *kinds: str) -> list[str]:
    """Markdown lines: a row per kind of scene, from `count` pictures each by random rigs of one kind, drawn from the
    seed `first` on; then how often points of some confidence are wrong.

    The constants of the choice were found on the seeds from 0 to 23: those from 1000 on have seen none of it.
    """
    lines = [f"## {count} pictures of every kind, {rig_kind}, seeds from {first} on", ""]
    lines += ["| scene | missed | false | of these OK | refused |", "|---" * 5 + "|"]
    rays, wrong = np.zeros((2, BINS.size - 1), dtype=int)
    for kind in kinds or KINDS:
        drawn = scenes(kind, int(count), first=int(first), rig_kind=rig_kind)
        total = Counted(*(sum(column) for column in zip(*(counted(one) for one in drawn), strict=True)))
        shares = [100 * part / max(total.wanted, 1) for part in (total.missed, total.false, total.plain)]
        lines.append(f"| {kind} | {' | '.join(f'{share:.2f} %' for share in shares)} | {total.refused} |")
        if not kind.startswith("water"):  # told by the ring's shape, not by the choice
            some = [by_confidence(one) for one in drawn]
            rays, wrong = rays + sum(one[0] for one in some), wrong + sum(one[1] for one in some)
    lines += ["", "| confidence | points | wrong |", "|---" * 3 + "|"]
    names = [f"{low:g} ... {high:g}" for low, high in pairwise(BINS)]
    return lines + [f"| {n} | {r} | {100 * w / max(r, 1):.2f} % |" for n, r, w in zip(names, rays, wrong, strict=True)]


def counted(one: Scene) -> Counted:
    """What profiling makes of one picture."""
    want = one.truth.visible & (one.truth.signal > MEASURABLE)
    try:
        ring = measure_image(one.image, Job.of(one.rig, one.nominal_radius))
    except ImageError:
        return Counted(int(want.sum()), int(want.sum()), 0, 0, 1)
    found = np.isfinite(ring.radius)
    false = found & ~_right(ring.radius, np.arange(found.size), one)
    plain = false & (ring.status == Status.OK)
    return Counted(int(want.sum()), int((want & ~found).sum()), int(false.sum()), int(plain.sum()), 0)


def by_confidence(one: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Points of one picture in each bin of confidence, and how many of them are wrong."""
    search = Job.of(one.rig, one.nominal_radius).looks[0].search
    try:
        stripe = detect_ring(one.image, search.centre, inner=search.inner, outer=search.outer, channel="red")
    except ImageError:
        return np.zeros(BINS.size - 1, dtype=int), np.zeros(BINS.size - 1, dtype=int)
    points = triangulate(one.rig, stripe.u, stripe.v, prior_radius=one.nominal_radius)
    clocks = one.truth.clock.size
    home = np.nan_to_num(np.rint(points.clock * clocks / (2 * np.pi))).astype(np.intp) % clocks
    found = stripe.found & np.isfinite(points.radius)
    wrong = found & ~_right(points.radius, home, one)
    confidence = np.asarray(stripe.confidence)
    return np.histogram(confidence[found], BINS)[0], np.histogram(confidence[wrong], BINS)[0]


def _right(radius: np.ndarray, home: np.ndarray, one: Scene) -> np.ndarray:
    """Which `radius` (n,) at the clock positions `home` (n,) are of the wall seen there or, across an edge of the
    light, `EDGE` steps away.
    """
    seen = np.where(one.truth.visible, one.truth.radius, np.nan)
    near = np.stack([np.roll(seen, step)[home] for step in range(-EDGE, EDGE + 1)])
    return np.any(np.abs(near - radius) < GROSS * one.nominal_radius, axis=0)
