"""What a calibration means: uncertainty on the wall and over the image, what cannot be told apart, its evidence."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from calibore.cli._calibrate_words import METRES, aligned, significant

if TYPE_CHECKING:
    from calibore.calibration import Calibration

CLOSE = 0.99
"""Correlation coefficient from which on two parameters are hardly told apart."""
RADII = 7
INNERMOST = 0.1
"""Of the largest radius: nearer to the axis there is no wall."""
SPREAD = (0.7, 1.3)
"""Of the nominal radius, where the calibration has no radii of its own."""


def meaning(
    found: "Calibration", *, inputs: Path | None, radius: float | None, file: Path, length: str
) -> dict[str, Any]:
    """Plain data, SI or px, sentences with lengths in `length`; parts that this calibration cannot have are None."""
    return {
        "wall": _on_wall(found, radius),
        "image": _over_image(found),
        "hardly_told_apart": _close_pairs(found),
        "halves": _halves(found, radius, length),
        "evidence": _evidence(found, file),
        "changed_inputs": _changed(file, inputs),
    }


def _on_wall(found: "Calibration", radius: float | None) -> dict[str, Any] | None:
    import numpy as np

    from calibore.calibration import wall_uncertainty

    limits = found.valid.radius if found.valid else None
    if radius is not None:
        limits = (SPREAD[0] * radius, SPREAD[1] * radius)
    if found.rig is None or found.rig.covariance is None or limits is None:
        return None
    wall = wall_uncertainty(found.rig, radii=np.linspace(max(limits[0], INNERMOST * limits[1]), limits[1], RADII))
    columns = {"radius_m": wall.radius, "u_m": wall.mean, "u_uncorrelated_m": wall.mean_uncorrelated}
    return {name: column.tolist() for name, column in columns.items()}


def _over_image(found: "Calibration") -> dict[str, float] | None:
    """Uncertainty [px] of the direction behind a pixel in the middle of the image, at the end of what was calibrated
    towards a corner, and half-way.
    """
    import numpy as np

    from calibore.calibration import projection_uncertainty

    if found.camera is None or not any(name.startswith("camera.") for name in found.covariance.names):
        return None
    camera = found.camera
    (u, v), ends = camera.principal_point, (camera.width - 1, camera.height - 1)
    corner = np.hypot(ends[0] - u, ends[1] - v)
    calibrated = found.valid and found.valid.zenith and float(camera.lens.image_radius(found.valid.zenith[1]))
    parts = min(calibrated / corner, 1.0) * np.array([0.0, 0.5, 1.0]) if calibrated else np.array([0.0, 0.5, 1.0])
    pixels = u + parts * (ends[0] - u), v + parts * (ends[1] - v)
    sd = projection_uncertainty(camera, found.covariance, *pixels, valid=found.valid).sd
    return dict(zip(("in the middle", "half-way", "at the edge"), sd.tolist(), strict=True))


def _close_pairs(found: "Calibration") -> list[dict[str, Any]]:
    names, r = found.covariance.names, found.covariance.correlations
    pairs = [(i, j) for i in range(len(names)) for j in range(i) if abs(r[i, j]) > CLOSE]
    return [{"first": names[j], "second": names[i], "correlation": float(r[i, j])} for i, j in pairs]


def _halves(found: "Calibration", radius: float | None, length: str) -> dict[str, Any] | None:
    """Half of the pictures against the other half, where there are enough."""
    from calibore.calibration import halves
    from calibore.errors import InputError

    try:
        half = halves(found, nominal_radius=radius)
    except InputError:
        return None
    return {"verdict": half.verdict(length), "rms_px": half.rms, "expected_px": half.expected, "p": half.p}


def _evidence(found: "Calibration", file: Path) -> dict[str, Any] | None:
    """How many residuals it rests on, and how far the covariance recomputed from them is from the stated one."""
    import numpy as np

    from calibore.calibration import recomputed_covariance

    seen = found.observations
    if not seen.residual.size:
        return None
    again, stated = recomputed_covariance(file), found.covariance
    change = float(np.abs((again.matrix - stated.matrix) / np.outer(stated.u, stated.u)).max())
    used = int((seen.weight > 0).sum())
    return {"residuals": seen.residual.size, "used": used, "largest_change_of_covariance": change}


def _changed(file: Path, inputs: Path | None) -> dict[str, str] | None:
    from calibore.calibration import verify_inputs

    return None if inputs is None else verify_inputs(file, inputs)


def meaning_lines(said: dict[str, Any], length: str) -> Iterator[str]:
    """The same for people."""
    for part, lines in (
        ("wall", lambda one: _wall_lines(one, length)),
        ("image", _image_lines),
        ("hardly_told_apart", _pair_lines),
        ("halves", lambda one: [f"Checked by halves: {one['verdict']}"]),
        ("evidence", _evidence_lines),
        ("changed_inputs", _input_lines),
    ):
        if said[part] is not None:
            yield from lines(said[part])


def _wall_lines(wall: dict[str, Any], length: str) -> Iterator[str]:
    size = METRES[length]
    yield from ("", f"On the wall, u of the radius shared by a whole scan [{length}]:")
    rows = zip(*(wall[key] for key in ("radius_m", "u_m", "u_uncorrelated_m")), strict=True)
    cells = [(f"{row[0] / size:.4g}", *(significant(value / size) for value in row[1:])) for row in rows]
    yield from aligned([("radius", "u", "u if correlations were ignored"), *cells], left=0)


def _image_lines(image: dict[str, float]) -> Iterator[str]:
    said = ", ".join(f"{significant(value)} px {place}" for place, value in image.items())
    yield from ("", f"Over the image, u of the direction behind a pixel: {said}.")


def _pair_lines(pairs: list[dict[str, Any]]) -> Iterator[str]:
    for pair in pairs:
        yield f"{pair['first']} and {pair['second']} are hardly told apart: correlation {pair['correlation']:+.4f}."


def _evidence_lines(evidence: dict[str, Any]) -> Iterator[str]:
    change, left = evidence["largest_change_of_covariance"], evidence["residuals"] - evidence["used"]
    yield (
        f"Evidence: {evidence['residuals']} residuals, {left} of them left out; the covariance computed from them "
        f"again differs by {change:.1g} of the stated variances at most."
    )


def _input_lines(changed: dict[str, str]) -> Iterator[str]:
    if not changed:
        yield "Inputs: all are what the calibration was made from."
    yield from (f"Inputs: {name} is {what}." for name, what in changed.items())
