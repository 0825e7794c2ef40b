"""One picture to a centred ring: our kernel against OpenCV with vectorised NumPy, truth checked in the same run.

Once from a rough centre, and once warm: from the centre that the picture before has shown.
"""

from collections.abc import Callable, Mapping
from functools import partial

import cv2
import numpy as np

from benchmarks.peers import opencv_warp_polar as peer
from benchmarks.surveys import PLANE, STATION, OneImage, one_image
from benchmarks.timing import compare
from calibore.images import read_image
from calibore.stripe import detect_ring

CENTRE, INNER, OUTER = (512.0, 384.0), 120, 320
REFERENCE = "OpenCV warpPolar + NumPy parabola"
WARM = "OpenCV warpPolar + NumPy parabola, unwrapped once"

Ring = tuple[np.ndarray, np.ndarray]


def report(rounds: int = 200) -> list[str]:
    """Markdown lines."""
    cv2.setNumThreads(1)
    one = one_image()
    search = (one.image, CENTRE, INNER, OUTER, 0)
    cold: Mapping[str, Callable[[], Ring]] = {
        "calibore detect_ring, with noise model and uncertainty": partial(ours, one, CENTRE),
        "calibore detect_ring, the same without vector instructions": partial(ours, one, CENTRE, kernel="scalar"),
        "calibore detect_ring, parabola as the peer, with uncertainty": partial(ours, one, CENTRE, "parabola"),
        "calibore detect_ring, centre of gravity, with uncertainty": partial(ours, one, CENTRE, "centroid"),
        REFERENCE: partial(peer.ring, *search),
        "OpenCV warpPolar + centre of gravity": partial(peer.ring, *search, peer.gravity_peaks),
    }
    before = read_image(PLANE / f"plane12in {STATION:03d} 1.png")
    start = detect_ring(before, CENTRE, inner=INNER, outer=OUTER, channel="red").centre or CENTRE
    search = (one.image, start, INNER, OUTER, 0)
    warm: Mapping[str, Callable[[], Ring]] = {
        "calibore detect_ring, with noise model and uncertainty": partial(ours, one, start),
        WARM: partial(peer.ring, *search, most=1),
        "OpenCV warpPolar + NumPy parabola, re-centred once": partial(peer.ring, *search, most=2),
    }
    return [
        "## Kernel: 1024 x 768 RGB, 1500 rays x 200 samples, re-centred to 0.5 px, one thread",
        *_table(one, cold, REFERENCE, rounds),
        "",
        "### The same from the centre of the picture before",
        *_table(one, warm, WARM, rounds),
    ]


def ours(one: OneImage, centre: tuple[float, float], how: str = "zero-crossing", kernel: str = "native") -> Ring:
    stripe = detect_ring(one.image, centre, inner=INNER, outer=OUTER, channel="red", estimator=how, kernel=kernel)
    return stripe.u, stripe.v


def _table(one: OneImage, contestants: Mapping[str, Callable[[], Ring]], reference: str, rounds: int) -> list[str]:
    with np.errstate(all="ignore"):
        result = compare(contestants, peer=reference, rounds=rounds, rng=np.random.default_rng(1))
        truth = [(name, one.error(*call())) for name, call in contestants.items()]
    return [
        "| contestant | median ms | peer / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
        "| contestant | rms error px | rays measured % |",
        "|---|---|---|",
        *(f"| {name} | {rms:.3f} | {100 * found:.1f} |" for name, (rms, found) in truth),
    ]
