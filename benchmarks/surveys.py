"""The simulated survey the benchmarks run on, and its truth."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calibore.images import ImageFolder, read_image
from calibore.rigs import read_rig
from calibore.scans import read_scan

SHARED = Path(__file__).parents[1].parent / "shared" / "data" / "simulated"
PLANE = SHARED / "plane-12in"
STATION = 55
GROSS = 3.0
"""Pixels beyond which a peak is not a measurement of the line."""


@dataclass(frozen=True)
class OneImage:
    """One picture of the survey (h, w, 3) with the true line (n, 2) [px]."""

    image: np.ndarray
    line: np.ndarray

    def error(self, u: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        """(rms distance [px] of the points to the line along rays from the ring's middle, fraction found)."""
        centre = self.line.mean(axis=0)
        true, found = self.line - centre, np.stack([u, v], axis=1) - centre
        order = np.argsort(np.arctan2(true[:, 1], true[:, 0]))
        azimuth = np.arctan2(true[:, 1], true[:, 0])[order]
        expected = np.interp(np.arctan2(found[:, 1], found[:, 0]), azimuth, np.hypot(*true.T)[order], period=2 * np.pi)
        error = np.hypot(*found.T) - expected
        good = np.abs(error) < GROSS
        return float(np.sqrt(np.mean(error[good] ** 2))), float(good.mean())


def one_image() -> OneImage:
    """Station 55, take 0, of plane-12in."""
    image = read_image(PLANE / f"plane12in {STATION:03d} 0.png")
    with np.load(PLANE / "truth.npz") as truth:
        row = int(np.flatnonzero(truth["stop"] == STATION)[0])
        seen = truth["line_visible"][row, 0]
        line = np.stack([truth["line_u"][row, 0], truth["line_v"][row, 0]], axis=1)[seen]
    return OneImage(image, line.astype(np.float64))


def image_paths() -> list[Path]:
    """All pictures of plane-12in in order."""
    spec = read_scan(PLANE)
    return list(ImageFolder(spec.folder, spec.pattern or "").paths.values())


def stated_rig():
    """The rig of plane-12in with the default uncertainty, and the nominal radius [m]."""
    spec = read_scan(PLANE)
    assert spec.rig_path is not None
    return read_rig(spec.rig_path).with_default_uncertainty(spec.nominal_radius), spec.nominal_radius
