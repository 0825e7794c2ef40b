"""Where the time from a file to radii goes, and what no work on our part of it could better.

A speed-up over the peer is its time over ours. If everything behind the line in the picture cost nothing it would be
peer / (reading + line); if reading cost nothing, too, peer / line: whoever wants more needs a faster kernel.
"""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from benchmarks.end_to_end import kinds_in
from benchmarks.peers import opencv_script
from benchmarks.surveys import stated_rig
from benchmarks.timing import compare
from calibore.images import LIMIT, PictureFile, read_image
from calibore.profiling import Job, measure_image
from calibore.profiling._line_ring import line_on_wall
from calibore.profiling._reading import stripes_of
from calibore.profiling._search import find_line
from calibore.stripe import Stripe

PEER, ALL, LINES = "peer", "file to radii", "file to line"
READ, KERNEL, WALL = "reading into an array", "line in an array", "line to radii with u"


def report(rounds: int = 21) -> list[str]:
    """Markdown lines: one thread, processor time, means per picture."""
    cv2.setNumThreads(1)
    rig, nominal = stated_rig()
    job = Job.of(rig, nominal)
    heads = ("files", "peer, ms", "all, ms", READ, KERNEL, WALL, "peer / all", "/ read and found", "/ found")
    lines = ["## Parts of the way from a file to radii: plane-12in, one thread", "", _row(*heads)]
    lines.append("|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder, np.errstate(all="ignore"):
        for number, (kind, paths) in enumerate(kinds_in(Path(folder)).items()):
            raw = kind == "raw"
            ms = _milliseconds(paths, job, raw=raw, rounds=rounds, rng=np.random.default_rng([8, number]))
            each = [f"{ms[name]:.2f}" for name in (PEER, ALL, READ, KERNEL, WALL)]
            lines.append(_row(kind, *each, *(f"{ms[PEER] / ms[name]:.2f}" for name in (ALL, LINES, KERNEL))))
    return [*lines, ""]


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def _milliseconds(paths: list[Path], job: Job, *, raw: bool, rounds: int, rng: np.random.Generator) -> dict[str, float]:
    look = job.looks[0]

    def line(path: Path) -> Stripe:
        return next(iter(stripes_of(PictureFile(path, LIMIT), partial(read_image, path), job, [look])))

    def found(image: np.ndarray) -> Stripe:
        return find_line(image, job.rig, look.search, channel=look.channel, estimator=job.estimator)

    def each(work: Callable[..., object], items: list) -> Callable[[], object]:
        return lambda: [work(item) for item in items]

    images, stripes = [read_image(path) for path in paths], [line(path) for path in paths]
    on_wall = partial(line_on_wall, rig=job.rig, prior_radius=job.nominal_radius)
    peer = opencv_script.profile_raw if raw else opencv_script.profile
    contestants = {
        PEER: lambda: peer(paths),
        ALL: each(partial(measure_image, job=job), paths),
        LINES: each(line, paths),
        READ: each(read_image, paths),
        KERNEL: each(found, images),
        WALL: each(on_wall, stripes),
    }
    result = compare(contestants, peer=PEER, rounds=rounds, rng=rng, clock=time.process_time)
    return {name: ms / len(paths) for name, ms in result.milliseconds.items()}
