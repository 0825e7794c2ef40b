"""The lines in one picture: by one call of compiled code that reads and measures, or in two steps."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from calibore.images import PictureFile, Pixels, StationImages
from calibore.profiling._job import Job
from calibore.profiling._lasers import Look
from calibore.profiling._search import find_line
from calibore.rigs import Rig
from calibore.stripe import RingPlace, Stripe, detect_line_in, detect_rings_in


def stripes_in(images: StationImages, take: int, job: Job, looks: Sequence[Look]) -> Iterator[Stripe]:
    """The line of each of the `looks` in the picture of `take`; raises ImageError at the first that is not there."""
    return stripes_of(images.file(take), partial(images.read, take), job, looks)


def stripes_of(
    file: PictureFile | None, read: Callable[[], Pixels], job: Job, looks: Sequence[Look]
) -> Iterator[Stripe]:
    """The line of each of the `looks` in the picture that is in `file`, or that `read` gives.

    The one call gives the same lines and no reasons: where it gives none, the picture is read once more to say why.
    """
    found = _rings_in_file(file, job, looks) if file is not None else None
    if found is not None:
        yield from found
        return
    picture = read()
    for look in looks:
        yield find_line(picture, job.rig, look.search, channel=look.channel, estimator=job.estimator)


def _rings_in_file(file: PictureFile, job: Job, looks: Sequence[Look]) -> list[Stripe] | None:
    places = [RingPlace(look.search.centre, look.search.inner, look.search.outer, look.channel) for look in looks]
    return detect_rings_in(file.path, places, size=size_of(job.rig), limit=file.limit, estimator=job.estimator)


def line_down(images: StationImages, take: int, rig: Rig, *, channel: str, estimator: str) -> Stripe | None:
    """The line down the picture of `take` by the one call; None where that gives none."""
    file = images.file(take)
    if file is None:
        return None
    how = {"channel": channel, "estimator": estimator}
    return detect_line_in(file.path, size=size_of(rig), limit=file.limit, down=True, **how)


def size_of(rig: Rig) -> tuple[int, int]:
    """Width and height [px] of the rig's pictures."""
    return rig.camera.width, rig.camera.height
