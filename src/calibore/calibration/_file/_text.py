"""Calibration -> the text of its FILE: a rig file, or the part of one, that says how well it is known."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from math import inf, isinf, isnan
from typing import Any

from calibore import __version__
from calibore.calibration._calibration import Calibration, Comparison
from calibore.calibration._input_files import InputFile
from calibore.errors import InputError
from calibore.rigs import Rig, ValidRegion, parts_toml
from calibore.uncertainty import Quantity


def file_text(calibration: Calibration, *, evidence: str) -> str:
    """The whole file; `evidence`: name of the store beside it. The same calibration gives the same text."""
    part = _without_calibrated(calibration) if calibration.rig else calibration.camera
    lines = [parts_toml(part).rstrip("\n"), *_settings(calibration, whole=part is not None)]
    lines += ["", "[calibration]", *_heading(calibration, evidence)]
    lines += [*_valid(calibration.valid), *_models(calibration.models), *_files(calibration.files)]
    return "\n".join(lines) + "\n"


def _without_calibrated(calibration: Calibration) -> Rig:
    """The rig with what is stated of inputs that were not calibrated."""
    rig: Any = calibration.rig
    if rig.covariance is None:
        return rig
    calibrated = set(calibration.covariance.names)
    rest = [name for name in rig.covariance.names if name not in calibrated]
    return rig.knowing(rig.covariance.restricted(rest))


def _settings(calibration: Calibration, *, whole: bool) -> Iterator[str]:
    """Tables of their own where there is no camera; below [calibration] where there is one, for readers of rigs."""
    if not whole:
        for name, table in calibration.settings.items():
            yield from ("", f"[{_key(name)}]", *_entries(table))


def _heading(calibration: Calibration, evidence: str) -> Iterator[str]:
    covariance = calibration.covariance
    if tuple(calibration.values) != covariance.names:
        raise InputError(
            f"A calibration's values and its covariance must name the same parameters, got "
            f"{', '.join(calibration.values)} and {', '.join(covariance.names)}."
        )
    yield from _entries({"kind": calibration.kind, "created_by": f"calibore {__version__}", "evidence": evidence})
    yield "# in SI (m, rad) or px"
    yield from ("parameters = [", *(f"    {_text(name)}," for name in covariance.names), "]")
    known = zip(calibration.values.values(), covariance.u.tolist(), strict=True)
    yield from ("values = [", *(f"    {_value(float(value))},  # u {u:.3g}" for value, u in known), "]")
    yield from ("covariance = [", *(f"    {_value(row)}," for row in covariance.matrix.tolist()), "]")
    each = [float(freedom) for freedom in covariance.degrees_of_freedom]
    if not all(map(isinf, each)):
        yield from _entries({"parameter_degrees_of_freedom": each})
    freedom = calibration.degrees_of_freedom
    if not isinf(freedom):
        yield from _entries({"degrees_of_freedom": float(freedom)})
    yield f"# of the residuals, {calibration.observations.unit}"
    yield from _entries({"noise": float(calibration.noise), "group_sigma": float(calibration.group_sigma)})
    yield from _sentences("findings", calibration.findings)
    yield from _sentences("warnings", calibration.warnings)
    if calibration.rig or calibration.camera:
        for name, table in calibration.settings.items():
            yield from ("", f"[calibration.settings.{_key(name)}]", *_entries(table))


def _sentences(name: str, sentences: Iterable[str]) -> Iterator[str]:
    rows = [f"    {_text(sentence)}," for sentence in sentences]
    yield from (f"{name} = [", *rows, "]") if rows else (f"{name} = []",)


def _valid(valid: ValidRegion | None) -> Iterator[str]:
    if valid is not None:
        yield from ("", f"[calibration.valid]{'  # ' + valid.said() if valid.said() else ''}")
        for name, unit in (("zenith", "rad"), ("radius", "m")):
            limits = getattr(valid, name)
            if limits:
                yield f"{name} = {_value([f'{float(limit)!r} {unit}' for limit in limits])}"


def _models(models: Iterable[Comparison]) -> Iterator[str]:
    for model in models:
        yield from ("", "[[calibration.model]]")
        plain = {field.name: getattr(model, field.name) for field in fields(model) if field.name != "estimates"}
        yield from _entries({key: value for key, value in plain.items() if not _is_nan(value) and value != ""})
        if model.estimates:
            estimates = ", ".join(f"{_key(name)} = {_quantity(value)}" for name, value in model.estimates.items())
            yield f"estimates = {{ {estimates} }}"


def _quantity(quantity: Quantity) -> str:
    freedom = {} if quantity.degrees_of_freedom == inf else {"degrees_of_freedom": float(quantity.degrees_of_freedom)}
    return _value({"value": float(quantity.value), "u": float(quantity.u), **freedom})


def _files(files: Iterable[InputFile]) -> Iterator[str]:
    for file in files:
        why = {key: text for key in ("refused", "set_aside") if (text := getattr(file, key))}
        yield from ("", "[[calibration.file]]", *_entries({"name": file.name, "sha256": file.sha256} | why))


def _entries(table: Mapping[str, Any]) -> Iterator[str]:
    for key, value in table.items():
        if value is not None:
            yield f"{_key(key)} = {_value(value)}"


def _value(value: Any) -> str:
    """`value` as TOML: text, numbers to their last bit, lists, tables."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {_value(item)}' for key, item in value.items())} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and isnan(value)


def _key(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() and name.isascii() else _text(name)


def _text(text: str) -> str:
    """Text in quotes; a file's name may hold bytes that are no text."""
    readable = text.encode("utf-8", "backslashreplace").decode("utf-8")
    return json.dumps(readable, ensure_ascii=False).replace("\x7f", "\\u007f")
