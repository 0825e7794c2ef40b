"""The bound of a line whose top is clipped: a clipped sample says that it is at least as bright as the picture can
show, and no more (a Tobit likelihood).

Without speckle, samples are independent, and the information of each is known in closed form. With speckle, what a
clipped sample says depends on its neighbours: what is lost is the variance of the score of complete samples about what
is seen, from pairs of draws of the clipped samples given the others (Gibbs sampling).
"""

import sys
from typing import Any

import numpy as np

from benchmarks.estimator import Scene, score

Array = np.ndarray[Any, np.dtype[np.float64]]
CEILING = 254.5
"""What is brighter is rounded or clipped to 255."""
DRAWS, SWEEPS, FORGOTTEN = 150, 40, 10
COMPARED = ("zero-crossing", "threshold", "centroid")
PEAKS = (260.0, 300.0, 400.0, 600.0, 1000.0)


def clipped_scenes() -> dict[str, Scene]:
    """Lines up to four times as bright as their pictures can show."""
    kinds = ((w, c, p) for w in (1.5, 2.0, 3.0) for c in (0.0, 0.1, 0.3) for p in PEAKS)
    scenes = {f"width {w}, contrast {c}, peak {p:.0f}": Scene(w, p, c) for w, c, p in kinds}
    return scenes | {f"16 bits, peak {p:.0f}": Scene(2.0, p, 0.1, bits=16) for p in PEAKS}


def clipped_table(pictures: int) -> list[str]:
    """Markdown table of the default estimator and two others, over the bound of the clipped line."""
    lines = ["## Where the top is clipped", ""]
    head = "| | bound, not clipped [px] | bound [px] | " + " | ".join(COMPARED) + " | rms / u | locking [px] | lost |"
    lines += [head, "|---" * (len(COMPARED) + 6) + "|"]
    for name, scene in clipped_scenes().items():
        bound, scores = clipped_bound(scene), [score(scene, estimator, pictures) for estimator in COMPARED]
        first, over = scores[0], " | ".join(f"{one.rms / bound:.2f}" for one in scores)
        told = f"{first.ratio:.2f} | {first.locking:.4f} | {100 * first.lost:.2f} %"
        lines.append(f"| {name} | {scene.bound():.4f} | {bound:.4f} | {over} | {told} |")
        print(lines[-1], file=sys.stderr)
    return lines


def clipped_bound(scene: Scene, seed: int = 0) -> float:
    """Cramer-Rao bound [px] of the place on one ray of `scene`, clipped: root mean square over sub-pixel phases."""
    rng = np.random.default_rng(seed)
    phases = np.linspace(-0.5, 0.5, 8, endpoint=False)
    return float(np.sqrt(np.mean([np.linalg.inv(_information(*scene.model(phase), rng))[0, 0] for phase in phases])))


def _information(mean: Array, covariance: Array, jacobian: Array, rng: np.random.Generator) -> Array:
    """Fisher information of place, height and background in clipped samples of that `mean` (m,)."""
    if np.count_nonzero(covariance) == len(mean):
        return jacobian.T @ (jacobian * (_kept(mean, np.diag(covariance)) / np.diag(covariance))[:, None])
    weighted: Array = np.linalg.solve(covariance, jacobian).astype(np.float64)
    return jacobian.T @ weighted - _lost(mean, covariance, weighted, rng)


def _kept(mean: Array, variance: Array) -> Array:
    """Share of the information of independent normal samples that is left when they are clipped."""
    from scipy.stats import norm

    z = (CEILING - mean) / np.sqrt(variance)
    density = norm.pdf(z)
    return norm.cdf(z) - z * density + density * np.exp(norm.logpdf(z) - norm.logsf(z))


def _lost(mean: Array, covariance: Array, weighted: Array, rng: np.random.Generator) -> Array:
    """Information that clipping costs: mean covariance of the score of complete samples, given what is seen."""
    seen = mean + rng.normal(size=(DRAWS, len(mean))) @ np.linalg.cholesky(covariance).T
    clipped, precision = seen >= CEILING, np.linalg.inv(covariance)
    one, other, total = seen.copy(), np.where(clipped, np.maximum(mean, CEILING), seen), np.zeros((3, 3))
    for sweep in range(SWEEPS):
        for samples in (one, other):
            for k in np.flatnonzero(clipped.any(axis=0)):
                spread = 1 / np.sqrt(precision[k, k])
                middle = samples[:, k] - (samples - mean) @ precision[k] * spread**2
                samples[clipped[:, k], k] = _at_least(middle, spread, rng)[clipped[:, k]]
        if sweep >= FORGOTTEN:
            score = (one - other) @ weighted
            total += score.T @ score / (2 * DRAWS * (SWEEPS - FORGOTTEN))
    return total


def _at_least(middle: Array, spread: float, rng: np.random.Generator) -> Array:
    """Normal draws about `middle` (n,) of those that are clipped."""
    from scipy.special import ndtr, ndtri

    z = (CEILING - middle) / spread
    tail = np.maximum(rng.uniform(size=len(z)) * ndtr(-z), 1e-300)
    return np.maximum(middle - spread * ndtri(tail), CEILING)
