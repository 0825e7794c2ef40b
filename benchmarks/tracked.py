"""Pictures one after the other, each looked at from the ring of the one before: what is there to gain by tracking?

The whole search, which is what `profile` does; the same in a band about the ring before, which may miss a ring that has
left the band and is blind for what rivals it there; and OpenCV and NumPy in that band, unwrapped once.
"""

import time
from functools import partial
from itertools import pairwise

import cv2
import numpy as np

from benchmarks.kernel import CENTRE, INNER, OUTER
from benchmarks.peers import opencv_warp_polar as peer
from benchmarks.surveys import PLANE
from benchmarks.timing import compare
from calibore.images import read_image
from calibore.stripe import Stripe, detect_ring

BAND = 16.0
"""Pixels beyond the ring before on each side."""
REFERENCE = "OpenCV warpPolar + NumPy parabola in the band, unwrapped once"
WHOLE = "calibore detect_ring, the whole region, from the centre before"
IN_BAND = "calibore detect_ring, in the band"

Band = tuple[tuple[float, float], float, float]
Step = tuple[np.ndarray, Band]


def report(rounds: int | str = 60) -> list[str]:
    """Markdown lines."""
    cv2.setNumThreads(1)
    images = [read_image(path) for path in sorted(PLANE.glob("plane12in * 0.png"))]
    steps = [(image, band(whole(before))) for before, image in pairwise(images)]
    contestants = {
        WHOLE: partial(each, steps, lambda image, place: whole(image, place[0])),
        IN_BAND: partial(each, steps, lambda image, place: detect(image, *place)),
        REFERENCE: partial(each, steps, lambda image, place: peer.ring(image, *rounded(place), 0, most=1)),
    }
    with np.errstate(all="ignore"):
        result = compare(
            contestants, peer=REFERENCE, rounds=int(rounds), rng=np.random.default_rng(5), clock=time.process_time
        )
    apart = np.concatenate([distance(whole(image, place[0]), detect(image, *place)) for image, place in steps])
    return [
        f"## Tracked: {len(steps)} pictures after one another, 1500 rays, one thread",
        "| contestant | median ms, all pictures | peer / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
        f"Points found in the band lie {np.sqrt(np.nanmean(apart**2)):.3f} px (rms) across the line from those of the",
        f"whole search, with its own centre and noise; {100 * np.mean(np.isnan(apart)):.1f} % of these are missing.",
    ]


def each(steps: list[Step], look) -> None:
    for image, place in steps:
        look(image, place)


def whole(image: np.ndarray, centre: tuple[float, float] = CENTRE) -> Stripe:
    return detect(image, centre, INNER, OUTER)


def detect(image: np.ndarray, centre: tuple[float, float], inner: float, outer: float) -> Stripe:
    return detect_ring(image, centre, inner=inner, outer=outer, channel="red")


def band(ring: Stripe) -> Band:
    """Centre, inner and outer radius [px] about a ring."""
    centre = ring.centre or CENTRE
    radius = np.hypot(ring.u - centre[0], ring.v - centre[1])
    return centre, float(np.nanmin(radius)) - BAND, float(np.nanmax(radius)) + BAND


def rounded(place: Band) -> Band:
    """With whole radii, as the peer needs them."""
    return place[0], float(np.floor(place[1])), float(np.ceil(place[2]))


def distance(one: Stripe, other: Stripe) -> np.ndarray:
    """Of `other` across the line [px], on the rays on which `one` has found it; NaN where `other` has not."""
    apart = (other.u - one.u) * one.direction[:, 0] + (other.v - one.v) * one.direction[:, 1]
    return apart[one.found]
