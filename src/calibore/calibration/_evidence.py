"""The evidence beside a calibration's FILE: every residual, where it was seen and what it depends on (Zarr v3)."""

import hashlib
import json
import warnings
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from calibore.calibration._calibration import Observations
from calibore.errors import InputError
from calibore.fitting import Fit

EVIDENCE_FORMAT = "calibore-evidence/1"
ROW, PARAMETER = "row", "parameter"
DIMENSIONS = {"prior": ("prior_row", "prior_column"), "whitened": ("white_row", PARAMETER)}
PLAIN = ("names", "unit", "known_noise", "known_group_sigma")
UNIT = "unit"
SAID = {
    "file": ("", "number of the file in [[calibration.file]], from 0"),
    "u": ("pixel", "column"),
    "v": ("pixel", "row"),
    "residual": (UNIT, "measured minus predicted"),
    "sigma": (UNIT, "standard deviation of the residual"),
    "weight": ("", "0 where it was left out"),
    "group": ("", "residuals of one group share an error"),
    "jacobian": ("", "derivative of the prediction by each of the parameters `names`, SI or px"),
    "load": ("", "what a unit of the error of its group does to the residual"),
    "chain": ("", "residuals of one chain are neighbours in their order, -1 for none"),
    "prior": ("", "known before: columns by parameter and a last one, rows of unit variance"),
    "whitened": ("", "the same in units of the scatter, whose inverse square is the covariance of `names`"),
}
"""Unit and meaning of every array."""
DIGITS = 12
"""Of the hash in the name of a store."""


def evidence_hash(observations: Observations) -> str:
    """A fingerprint of the evidence's content."""
    found = hashlib.sha256(json.dumps(_plain(observations)).encode())
    for name, values in _arrays(observations).items():
        found.update(f"{name} {values.dtype.str} {values.shape}".encode())
        found.update(np.ascontiguousarray(values).tobytes())
    return found.hexdigest()[:DIGITS]


def write_evidence(observations: Observations, folder: Path) -> None:
    """A new Zarr v3 group `folder`; the same evidence gives the same bytes."""
    import xarray as xr

    variables = {}
    for name, values in _arrays(observations).items():
        unit, meaning = SAID.get(name, ("", name))
        attributes = {"long_name": meaning} | ({"units": observations.unit if unit is UNIT else unit} if unit else {})
        variables[name] = (DIMENSIONS.get(name, (ROW, PARAMETER))[: values.ndim], values, attributes)
    attributes = {"format": EVIDENCE_FORMAT, **_plain(observations)}
    with warnings.catch_warnings():
        # Zarr warns that consolidated metadata is not in the v3 specification yet; xarray reads and writes it.
        warnings.simplefilter("ignore")
        xr.Dataset(variables, attrs=attributes).to_zarr(folder, mode="w-", zarr_format=3, consolidated=True)
    _order_metadata(folder / "zarr.json")


def read_evidence(folder: Path) -> Observations:
    """The evidence in `folder`; raises InputError where it is none, or is not what was written."""
    import xarray as xr

    try:
        with xr.open_zarr(folder, consolidated=True) as store:
            if store.attrs.get("format") != EVIDENCE_FORMAT:
                raise InputError(f"{folder} is no evidence of a calibration; put back what `calibore calibrate` wrote.")
            arrays = {str(name): store[name].to_numpy() for name in store.data_vars}
            plain = {name: store.attrs[name] for name in PLAIN if name in store.attrs}
        plain["names"] = tuple(plain["names"])
        return Observations(**arrays, **plain)
    except InputError:
        raise
    except Exception as error:  # zarr, xarray and the codecs raise what they like on a damaged store
        raise InputError(f"{folder} cannot be read ({error}); put back what `calibore calibrate` wrote.") from error


def of_fit(fit: Fit) -> dict[str, Any]:
    """What `Observations` takes from a fit: `Observations(file=..., u=..., v=..., **of_fit(fit))`."""
    found: dict[str, Any] = {name: getattr(fit, name) for name in ("sigma", "jacobian", "names")}
    ties = {} if fit.ties is None else fit.ties._asdict()
    return found | {"residual": fit.residuals, "weight": fit.weights} | ties


def _plain(observations: Observations) -> dict[str, Any]:
    found = {name: getattr(observations, name) for name in PLAIN}
    found["names"] = list(observations.names)
    return {name: value for name, value in found.items() if value is not None}


def _arrays(observations: Observations) -> dict[str, Any]:
    values = {field.name: getattr(observations, field.name) for field in fields(observations)}
    return {name: np.asarray(value) for name, value in values.items() if name not in PLAIN and value is not None}


def _order_metadata(path: Path) -> None:
    """Zarr lists members in the order in which the file system and its threads return them."""
    document = json.loads(path.read_text(encoding="utf-8"))
    members = document["consolidated_metadata"]["metadata"]
    document["consolidated_metadata"]["metadata"] = dict(sorted(members.items()))
    path.write_text(json.dumps(document, separators=(",", ":")), encoding="utf-8")
