"""TOML documents checked against a pydantic model: a mistake is named with file, key and what is allowed."""

import re
import tomllib
from pathlib import Path
from string import Formatter
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, ValidationError

from calibore.errors import InputError
from calibore.units import parse_quantity


class Document(BaseModel):
    """A table of a TOML file: unknown keys, NaN and infinity are mistakes."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)


def _quantity(dimension: str) -> Any:
    def parse(value: Any) -> float:
        if not isinstance(value, str):
            raise ValueError(f'{value!r} has no unit; write it as text with one, e.g. "{value} {_UNIT[dimension]}"')
        try:
            return parse_quantity(value, dimension)
        except InputError as error:
            raise ValueError(str(error)) from error

    return BeforeValidator(parse)


_UNIT = {"length": "mm", "angle": "deg", "time": "s"}
Length = Annotated[float, _quantity("length")]
Angle = Annotated[float, _quantity("angle")]

LONGEST_NAME, LONGEST_PATH = 255, 1000
"""Bytes of one part of a name, and of all its parts: what systems take, room left for the folder before it."""


def _file_name(text: str) -> str:
    parts = [len(part.encode()) for part in text.split("/")]
    if "\0" in text or max(parts) > LONGEST_NAME or sum(parts) + len(parts) > LONGEST_PATH:
        raise ValueError(
            f"a name of a file has at most {LONGEST_NAME} bytes, {LONGEST_PATH} with its folders, and none of them is "
            "0; write the name as the file has it"
        )
    return text


FileName = Annotated[str, AfterValidator(_file_name)]
"""The name of a file or folder, or a pattern of names: one that a system can look for."""

Model = TypeVar("Model", bound=BaseModel)
_WIDE = re.compile(r"\d{4,}")
"""The width or precision of a field, in characters: memory is set aside for them."""


def filled(pattern: str, **values: object) -> str:
    """`pattern.format(**values)` of a pattern that stands in a file; ValueError or LookupError where it cannot be."""
    for _, _, form, _ in Formatter().parse(pattern):
        if _WIDE.search(form or ""):
            raise ValueError(f'a field of the form "{form}" is wider than any name')
    return pattern.format(**values)


def read_document(path: Path, model: type[Model]) -> Model:
    """`path` parsed as TOML and validated as `model`; raises InputError naming file, key, value and what is allowed."""
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{path} does not exist; give the path of an existing file.") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror or error}); check its permissions.") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} cannot be read (byte {error.start} is {error.object[error.start]:#04x}, which is not UTF-8 text); "
            "give a TOML file saved as UTF-8."
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path} is not valid TOML: {error}. Correct that line.") from error
    except RecursionError as error:
        raise InputError(
            f"{path} cannot be read: its tables or lists are nested too deeply; make them flat."
        ) from error
    except ValueError as error:
        raise InputError(
            f"{path} cannot be read: it holds an impossible number or date ({error}); correct it."
        ) from error
    return validate(data, model, path=path)


def validate(data: dict[str, Any], model: type[Model], *, path: Path) -> Model:
    """`data` as `model`; the first mistake becomes one sentence."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        mistake = error.errors()[0]
        others = error.error_count() - 1
        more = f" ({others} more mistake{'s' * (others > 1)} in this file.)" if others else ""
        raise InputError(f"{path}: {_sentence(mistake, model)}{more}") from error


UNNAMED = "function-"
"""Parts of a place that begin so are no keys of the document: pydantic's own, and the tags of alternatives."""
SHOWN = 60
"""Characters of a wrong value that are worth repeating."""
REWORDED = {
    "Value error, ": "",
    "Input should be": "it must be",
    "a valid integer": "a whole number without quotes",
    "a valid number": "a number without quotes",
    "a valid string": "text in quotes",
    "a valid tuple": "a list in square brackets",
    "Tuple should have": "it must have",
    " after validation": "",
}


def _sentence(mistake: Any, model: type[BaseModel]) -> str:
    where = tuple(part for part in mistake["loc"] if not str(part).startswith(UNNAMED))
    key = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in where).removeprefix(".")
    if mistake["type"] == "missing":
        return f"key {key} is missing; add it."
    if mistake["type"] == "extra_forbidden":
        allowed = ", ".join(sorted(_keys_at(model, where[:-1])))
        return f"key {key} is not known; allowed here: {allowed}."
    value = repr(mistake["input"])
    shown = value if len(value) <= SHOWN else f"{value[:SHOWN]}..."
    return f"key {key} = {shown} is wrong: {_reworded(mistake)}".rstrip(".") + "."


def _reworded(mistake: Any) -> str:
    """What pydantic says of a value, in the words of somebody who writes TOML."""
    if mistake["type"] in ("model_type", "dict_type"):
        return "it must be a table with keys of its own"
    message = mistake["msg"]
    for said, meant in REWORDED.items():
        message = message.replace(said, meant)
    return f"{message[:1].lower()}{message[1:]}"


def _keys_at(model: Any, where: tuple[Any, ...]) -> list[str]:
    for part in where:
        if isinstance(part, int):
            continue
        field = model.model_fields.get(part) if hasattr(model, "model_fields") else None
        model = field.annotation if field else None
        model = next((arg for arg in getattr(model, "__args__", ()) if hasattr(arg, "model_fields")), model)
    return [field.alias or name for name, field in model.model_fields.items()] if hasattr(model, "model_fields") else []
