"""Is the estimator at the bound? `python -m benchmarks estimator`: rms of every named estimator over the Cramer-Rao
bound and over the uncertainty it reports, and how far it is drawn to whole pixels.

Pictures of a straight line that crosses pixel columns at a small angle, every ray with its true place. The bound is
that of an unbiased place on one ray whose amplitude and background are free: inverse Fisher information under the full
covariance of the samples. Speckle enters it by its first two moments (variance contrast^2 of the mean squared,
correlation exp(-d^2 / 4 grain^2)) as if it were normal; of gamma-distributed speckle without correlation that is exact.
"""

import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from calibore.errors import ImageError
from calibore.simulation import Sensor, speckle_field
from calibore.stripe import detect_line

Array = np.ndarray[Any, np.dtype[np.float64]]
COLUMNS, ROWS, BACKGROUND = 1536, 64, 8.0
SLOPE = 0.0213
"""Rows per column: the line passes every sub-pixel phase thirty times in a picture."""
ESTIMATORS = ("zero-crossing", "correlation", "centroid", "threshold", "parabola", "maximum")
UNSEEN = 5000
"""Seeds from here on were used for nothing else."""
GROSS = 3.0
"""px: a place further off belongs to another peak, and is counted as one."""
SENSOR = Sensor(psf_sigma=0.9, background=BACKGROUND, full_well=12000.0, read_noise=18.0)


@dataclass(frozen=True)
class Scene:
    """A line of Gaussian `width` [px] and `peak` [of 255]; `contrast`, `grain` [px] of its speckle (correlation
    exp(-d^2 / 4 grain^2)); `skew`: how much wider its lower side is; `bits` of the picture; `quality` of JPEG, 0: none.
    """

    width: float
    peak: float
    contrast: float = 0.0
    grain: float = 1.0
    skew: float = 0.0
    bits: int = 8
    quality: int = 0

    def draw(
        self, seed: int, *, middle: float = ROWS / 2, wave: Array | float = 0.0
    ) -> tuple[np.ndarray[Any, Any], Array]:
        """(picture (ROWS, COLUMNS), true row (COLUMNS,) of the line); it strays by `wave` [px] from a straight one."""
        rng = np.random.default_rng([seed, 7])
        straight = middle + rng.uniform(-0.5, 0.5) + SLOPE * (np.arange(COLUMNS) - COLUMNS / 2)
        row = np.asarray(straight + wave, dtype=np.float64)
        distance = np.arange(ROWS)[:, None] - row
        width = self.width * (1 + self.skew * np.sign(distance))
        light = self.peak / 255 * np.exp(-(distance**2) / (2 * width**2))
        field = speckle_field(light.shape, contrast=self.contrast, grain=2 * self.grain, rng=rng)
        grey = replace(SENSOR, bits=self.bits).read_out((light * field)[:, :, None], rng)[:, :, 0]
        return (_compressed(grey, self.quality) if self.quality else grey), row

    def bound(self) -> float:
        """Cramer-Rao bound [px] of the place on one ray, root mean square over sub-pixel phases."""
        variances = []
        for phase in np.linspace(-0.5, 0.5, 8, endpoint=False):
            _, covariance, jacobian = self.model(phase)
            variances.append(np.linalg.inv(jacobian.T @ np.linalg.solve(covariance, jacobian))[0, 0])
        return float(np.sqrt(np.mean(variances)))

    def model(self, phase: float) -> tuple[Array, Array, Array]:
        """Mean (m,) and covariance (m, m) of the samples of one ray, and what they change by (m, 3) with the place, the
        relative height and the background.
        """
        distance = np.arange(-24, 25) - phase
        bell = np.exp(-(distance**2) / (2 * self.width**2))
        line = self.peak * bell
        apart = distance[:, None] - distance
        covariance = self.contrast**2 * np.outer(line, line) * np.exp(-(apart**2) / (4 * self.grain**2))
        grey = 255 / SENSOR.full_well
        rounding = 1 / 12 * (255 / (2**self.bits - 1)) ** 2
        covariance += np.diag((line + BACKGROUND) * grey + (SENSOR.read_noise * grey) ** 2 + rounding)
        jacobian = np.stack([line * distance / self.width**2, line, np.ones_like(bell)], axis=1)
        return line + BACKGROUND, covariance, jacobian


def _compressed(grey: np.ndarray[Any, Any], quality: int) -> np.ndarray[Any, Any]:
    import io

    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(grey).save(buffer, "JPEG", quality=quality)
    return np.array(Image.open(buffer))


@dataclass(frozen=True)
class Score:
    """`rms`, `bias` [px] of the places, `ratio` of rms to the uncertainty reported, `locking` [px]: amplitude of the
    mean error against the sub-pixel phase (with speckle: its noise too); `lost`: share of rays without a place or with
    one of another peak.
    """

    rms: float
    bias: float
    ratio: float
    locking: float
    lost: float


def score(scene: Scene, estimator: str, pictures: int, *, middle: float = ROWS / 2, first: int = 0) -> Score:
    """Of `estimator` on so many `pictures` of `scene`, drawn with the seeds from `first` on."""
    errors, u, phase = [], [], []
    for seed in range(first, first + pictures):
        picture, row = scene.draw(seed, middle=middle)
        try:
            stripe = detect_line(picture, estimator=estimator)
        except ImageError:
            continue
        errors.append(stripe.v - row)
        u.append(stripe.u_position)
        phase.append(row % 1)
    error, doubt, of_row = np.concatenate(errors), np.concatenate(u), np.concatenate(phase)
    good = np.abs(error) < GROSS
    error, doubt, of_row = error[good], doubt[good], of_row[good]
    bias, rms = float(error.mean()), float(np.sqrt(np.mean(error**2)))
    waves = [2 * abs(np.mean((error - bias) * np.exp(2j * np.pi * k * of_row))) for k in (1, 2)]
    ratio = rms / float(np.sqrt(np.mean(doubt**2)))
    return Score(rms, bias, ratio, float(max(waves)), 1 - good.sum() / (pictures * COLUMNS))


def without_speckle() -> dict[str, Scene]:
    """Scenes on which shot noise, read noise and rounding are all there is."""
    return {f"width {w}, peak {p:.0f}": Scene(w, p) for w in (1.5, 2.0, 3.0) for p in (60.0, 150.0, 200.0)}


def with_speckle() -> dict[str, Scene]:
    """Scenes with speckle, the contrast and grain of which nobody tells the estimator."""
    kinds = ((w, c, g) for w in (1.5, 2.0, 3.0) for c in (0.1, 0.25, 0.5) for g in (0.7, 1.0, 1.5))
    return {f"width {w}, contrast {c}, grain {g}": Scene(w, 100.0, c, g) for w, c, g in kinds}


def unseen(count: int) -> list[Scene]:
    """Random scenes, every third without speckle, on which no constant of the estimator was chosen."""
    rng = np.random.default_rng(77)

    def scene(number: int) -> Scene:
        contrast = rng.uniform(0.05, 0.5) if number % 3 else 0.0
        return Scene(rng.uniform(1.4, 3.0), rng.uniform(60, 200), contrast, rng.uniform(0.8, 1.5))

    return [scene(number) for number in range(count)]


def harder() -> dict[str, tuple[Scene, float]]:
    """Scenes that are not what the model says, and the row where the line lies; the bound is that of the model."""
    usual, middle = Scene(1.5, 150.0, 0.25), ROWS / 2
    return {
        "16 bits": (replace(usual, bits=16), middle),
        "16 bits, no speckle": (Scene(1.5, 150.0, bits=16), middle),
        "skewed by 10 %": (replace(usual, skew=0.1), middle),
        "skewed by 20 %": (replace(usual, skew=0.2), middle),
        "near the edge (rows 2 to 34)": (usual, SLOPE * COLUMNS / 2 + 2.0),
        "JPEG, quality 90": (replace(usual, quality=90), middle),
        "JPEG, quality 60": (replace(usual, quality=60), middle),
    }


def report(pictures: str = "6") -> list[str]:
    """Markdown tables from so many pictures of each scene."""
    from benchmarks.clipped import clipped_table

    count = int(pictures)
    lines = ["## Over the Cramer-Rao bound", ""]
    lines += _table("no speckle", without_speckle(), count)
    lines += _table("speckle, contrast and grain learnt from the picture", with_speckle(), count)
    lines += _spread(count)
    head = " | ".join(ESTIMATORS)
    lines += ["", "## Where the model does not hold", "", f"| rms over bound (bias [px]) | {head} | rms / u | lost |"]
    lines += ["|---" * (len(ESTIMATORS) + 3) + "|"]
    for name, (scene, middle) in harder().items():
        scores = [score(scene, estimator, count, middle=middle) for estimator in ESTIMATORS]
        numbers = " | ".join(f"{one.rms / scene.bound():.2f} ({one.bias:+.3f})" for one in scores)
        lines.append(f"| {name} | {numbers} | {scores[0].ratio:.2f} | {100 * scores[0].lost:.2f} % |")
    return [*lines, "", *clipped_table(count)]


def _spread(pictures: int) -> list[str]:
    """How far the default estimator is from the bound in scenes that it has never seen."""
    scenes = unseen(60)
    scores = [score(scene, ESTIMATORS[0], pictures, first=UNSEEN) for scene in scenes]
    over = np.array([got.rms / scene.bound() for got, scene in zip(scores, scenes, strict=True)])
    told, contrast = np.array([got.ratio for got in scores]), np.array([scene.contrast for scene in scenes])
    lines = ["", f"| {len(scenes)} random scenes | rms over bound: least, median, largest | rms / u: least, largest |"]
    lines += ["|---" * 3 + "|"]
    for name, low, high in (("no speckle", -1.0, 0.0), ("contrast below 0.3", 0.0, 0.3), ("0.3 to 0.5", 0.3, 1.0)):
        some = (contrast > low) & (contrast <= high)
        ends = f"{over[some].min():.2f}, {np.median(over[some]):.2f}, {over[some].max():.2f}"
        lines.append(f"| {name} ({some.sum()}) | {ends} | {told[some].min():.2f}, {told[some].max():.2f} |")
    return lines


def _table(title: str, scenes: dict[str, Scene], pictures: int) -> list[str]:
    head = f"| {title} | bound [px] | " + " | ".join(ESTIMATORS) + " | rms / u | locking [px] | lost |"
    lines = ["", head, "|---" * (len(ESTIMATORS) + 5) + "|"]
    for name, scene in scenes.items():
        bound, scores = scene.bound(), [score(scene, estimator, pictures) for estimator in ESTIMATORS]
        first, ratios = scores[0], " | ".join(f"{one.rms / bound:.2f}" for one in scores)
        told = f"{first.ratio:.2f} | {first.locking:.4f} | {100 * first.lost:.2f} %"
        lines.append(f"| {name} | {bound:.4f} | {ratios} | {told} |")
        print(lines[-1], file=sys.stderr)
    return lines
