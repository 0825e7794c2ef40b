"""One picture to a centred ring: our kernel against OpenCV with vectorised NumPy, truth checked in the same run."""

from functools import partial

import cv2
import numpy as np

from benchmarks.peers import opencv_warp_polar as peer
from benchmarks.surveys import one_image
from benchmarks.timing import compare
from calibore.stripe import detect_ring

CENTRE, INNER, OUTER = (512.0, 384.0), 120, 320
REFERENCE = "OpenCV warpPolar + NumPy parabola"


def report(rounds: int = 200) -> list[str]:
    """Markdown lines."""
    cv2.setNumThreads(1)
    one = one_image()

    def ours() -> tuple[np.ndarray, np.ndarray]:
        stripe = detect_ring(one.image, CENTRE, inner=INNER, outer=OUTER, channel="red")
        return stripe.u, stripe.v

    search = (one.image, CENTRE, INNER, OUTER, 0)
    contestants = {
        "calibore detect_ring, with noise model and uncertainty": ours,
        REFERENCE: partial(peer.ring, *search),
        "OpenCV warpPolar + centre of gravity": partial(peer.ring, *search, peer.gravity_peaks),
    }
    with np.errstate(all="ignore"):
        result = compare(contestants, peer=REFERENCE, rounds=rounds, rng=np.random.default_rng(1))
        truth = [f"| {name} | {rms:.3f} | {100 * f:.1f} |" for name, (rms, f) in _truth(contestants, one)]
    return [
        "## Kernel: 1024 x 768 RGB, 1500 rays x 200 samples, re-centred to 0.5 px, one thread",
        "| contestant | median ms | peer / contestant (95 %) |",
        "|---|---|---|",
        *result.rows(),
        "",
        "| contestant | rms error px | rays measured % |",
        "|---|---|---|",
        *truth,
    ]


def _truth(contestants, one):
    return [(name, one.error(*call())) for name, call in contestants.items()]
