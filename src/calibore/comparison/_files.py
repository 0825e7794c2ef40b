"""A comparison on disk: which folder is what, and difference.zarr, rings.csv, the numbers of summary.json."""

import csv
import json
import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from calibore.comparison._agreement import Errors
from calibore.comparison._compared import Compared
from calibore.comparison._region import Region
from calibore.errors import InputError
from calibore.registration import Motion
from calibore.uncertainty import Quantity

if TYPE_CHECKING:
    import xarray

FORMAT = "calibore-difference/1"
ON_STATIONS = ("station", "clock")
SCAN, RESULT = "scan.toml", "profile.zarr"


def kind_of(folder: Path) -> str:
    """What a folder is, "result" or "scan"; raises InputError for anything else."""
    if (folder / RESULT).exists():
        return "result"
    if folder.is_file() or (folder / SCAN).is_file():
        return "scan"
    there = "is neither a result folder (profile.zarr) nor a scan folder (scan.toml)"
    raise InputError(
        f"{folder} {there if folder.is_dir() else 'does not exist'}; give what `calibore profile` wrote, or the "
        "folder of a scan."
    )


def is_tactile_result(folder: Path) -> bool:
    """Whether a result folder is that of a tactile scan, by what its summary counts."""
    with suppress(OSError, ValueError, RecursionError):
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        counts = summary.get("counts") if isinstance(summary, dict) else None
        return isinstance(counts, dict) and "readings" in counts
    return False


def difference_dataset(found: Compared) -> "xarray.Dataset":
    """Everything by station and clock position, on the grid of the moving profile; SI."""
    import xarray

    one, change = found.difference, found.changes
    registration = found.registration
    weight = np.full(one.value.shape, np.nan)
    weight[registration.cloud.ring, registration.cloud.position] = registration.weights
    grids = {
        "difference": (one.value, "m", f"radius of {found.names[0]}, moved, minus that of {found.names[1]}"),
        "u_independent": (one.u_independent, "m", "standard uncertainty of difference from noise"),
        "missed": (one.missed, "m", "standard deviation of what lies between points and beside edges"),
        "u": (one.u, "m", "standard uncertainty of difference, calibration of both and alignment included"),
        "adjusted": (one.adjusted, "m", "difference without what errors of both calibrations explain"),
        "u_adjusted": (one.u_adjusted, "m", "standard uncertainty of adjusted"),
        "normalised_error": (found.agreement.normalised, "", "difference over its 95 % uncertainty (En)"),
        "axial_on_reference": (one.axial, "m", "axial position of the moved point on the reference"),
        "clock_on_reference": (one.clock, "rad", "clock position of the moved point on the reference"),
        "weight": (weight, "", "robust weight of the point in the registration"),
    }
    if change is not None:
        said = "greatest mean around a point in its standard uncertainties, signed"
        grids["significance"] = (change.significance, "", said)
        said = "least change of the best window around a point that is found with 95 % probability"
        grids["level_of_detection"] = (change.level_of_detection, "m", said)
    variables: dict[str, Any] = {
        name: (ON_STATIONS, values, {"long_name": said} | ({"units": unit} if unit else {}))
        for name, (values, unit, said) in grids.items()
    }
    for name, modes in (("modes", one.modes), ("adjusted_modes", one.adjusted_modes)):
        said = f"common part: cov = diag(u_independent^2) + sum over {name} of m m^T (and missed, of neighbours)"
        variables[name] = ((f"{name[:-1]}", *ON_STATIONS), modes, {"long_name": said, "units": "m"})
    if change is not None:
        number = np.zeros(one.value.shape, dtype=np.int32)
        for at, region in enumerate(change.regions, start=1):
            number[region.cells] = at
        variables["region"] = (ON_STATIONS, number, {"long_name": "number of the region of change, 0: none"})
    coordinates = {
        "axial": ("station", found.moving.axial, {"long_name": "axial position of the rig origin", "units": "m"}),
        "clock": ("clock", found.moving.clock, {"long_name": "clock of the moving profile", "units": "rad"}),
    }
    attributes = {"format": FORMAT, "moving": found.names[0], "reference": found.names[1]}
    return xarray.Dataset(variables, coords=coordinates, attrs=attributes)


def write_arrays(found: Compared, folder: Path) -> None:
    """difference.zarr (Zarr v3) and rings.csv into `folder`."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # zarr remarks on its own format
        difference_dataset(found).to_zarr(folder / "difference.zarr", zarr_format=3, consolidated=True)
    columns = ("ring", "axial_m", "points", "rms_m", "mean_m", "predicted_rms_m", "inside_95", "outliers")
    with (folder / "rings.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for row, ring in found.rings.items():
            values = _errors(ring, "axial_m").values()
            writer.writerow([row, *(f"{one:.9g}" if isinstance(one, float) else one for one in values)])


def numbers(found: Compared) -> dict[str, Any]:
    """What summary.json holds, SI."""
    registration, agreed = found.registration, found.agreement
    plain: dict[str, Any] = {
        "question": "change" if found.changes is not None else "error",
        "moving": found.names[0],
        "reference": found.names[1],
        "registration": {
            "motion": dict(zip(Motion.names, registration.motion.values.tolist(), strict=True)),
            "pivot": float(registration.motion.pivot),
            "u": {name: registration.u(name) for name in registration.names},
            "covariance": {"names": list(registration.names), "matrix": registration.covariance.matrix},
            "untold": list(registration.untold),
            "scatter": registration.scatter,
            "independent_points": registration.points,
            "degrees_of_freedom": registration.degrees_of_freedom,
            "common_modes": registration.modes,
        },
        "compared": {
            "points": agreed.overall.points,
            "of": int(found.moving.measured.sum()),
            "degrees_of_freedom": agreed.degrees_of_freedom,
        },
        "errors": _errors(agreed.overall, "radius_m"),
        "errors_away_from_edges": _errors(found.away_from_edges(), "axial_m"),
        "outlier_rule": {"limit_m": agreed.rule.limit, "sigma": agreed.rule.sigma},
        "by_radius": [_errors(one, "radius_m") for one in agreed.by_radius],
        "rings": [{"ring": row, **_errors(one, "axial_m")} for row, one in found.rings.items()],
    }
    if registration.drift is not None:
        plain["registration"]["drift"] = registration.drift
        plain["registration"]["u_drift"] = registration.u_drift
    return plain | _change(found)


def _change(found: Compared) -> dict[str, Any]:
    change = found.changes
    if change is None:
        return {}
    least = change.level_of_detection[np.isfinite(change.level_of_detection)]
    return {
        "false_alarm": change.false_alarm,
        "threshold": change.threshold,
        "level_of_detection_m": {
            f"{100 * share:.0f} %": float(np.quantile(least, share)) if least.size else None
            for share in (0.05, 0.5, 0.95)
        },
        "years": found.years,
        "regions": [_region(one, number, found.years) for number, one in enumerate(change.regions, start=1)],
    }


def _region(region: Region, number: int, years: float | None) -> dict[str, Any]:
    lengths = {"depth": region.depth, "mean": region.mean, "measured_depth": region.measured_depth}
    said: dict[str, Any] = {
        "number": number,
        "axial_m": _quantity(region.axial),
        "clock_rad": _quantity(region.clock),
        "area_m2": region.area,
        "points": region.points,
        **{f"{name}_m": _quantity(one) for name, one in lengths.items()},
        "volume_m3": _quantity(region.volume),
        "shaped": region.shaped,
    }
    if years is not None:
        said["per_year"] = {
            "depth_m": _quantity(per_year(region.depth, years)),
            "mean_m": _quantity(per_year(region.mean, years)),
            "volume_m3": _quantity(per_year(region.volume, years)),
        }
    return said


def per_year(quantity: Quantity, years: float) -> Quantity:
    """A rate: dates are exact."""
    return Quantity(quantity.value / years, quantity.u / years)


def _quantity(one: Quantity) -> dict[str, float]:
    return {"value": one.value, "u": one.u}


def _errors(one: Errors, place: str) -> dict[str, Any]:
    return {
        place: one.place,
        "points": one.points,
        "rms_m": one.rms,
        "mean_m": one.mean,
        "predicted_rms_m": one.predicted,
        "inside_95": one.inside,
        "outliers": one.outliers,
    }
