"""What makes the files of an archive a Zarr v3 group: written when all pictures are in, read when it is opened."""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from calibore.errors import InputError
from calibore.images._archived_picture import BLOSC_LEVEL, CHANNELS, ZSTD_LEVEL, Form

FORMAT = "calibore-archive/1"
REFUSED = -1
NUMBERS = ("station", "angular", "take", "form")

Key = tuple[int, int, int]
"""Station, angular stop, take."""


@dataclass(frozen=True)
class Contents:
    """What an archive holds: of each picture its numbers and its form, None where it was refused; why, by number."""

    keys: Sequence[Key]
    forms: Sequence[Form | None]
    reasons: Mapping[int, str]


def write_metadata(store: Path, contents: Contents) -> None:
    """Make the folder `store`, which holds the pictures' files, a Zarr group; what was written before is replaced."""
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec

    _remove_metadata(store)
    forms = sorted({form for form in contents.forms if form}, key=lambda form: form.name)
    reasons = {str(number): reason for number, reason in sorted(contents.reasons.items())}
    attributes = {"format": FORMAT, "pictures": len(contents.keys), "forms": [form.name for form in forms]}
    attributes |= {"refused": reasons}
    group = zarr.create_group(store, zarr_format=3, attributes=attributes)
    numbers = np.array(contents.keys, dtype=np.int64).reshape(-1, 3)
    codes = [forms.index(form) if form else REFUSED for form in contents.forms]
    for name, values in zip(NUMBERS, (*numbers.T, np.array(codes, dtype=np.int64)), strict=True):
        array = group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype="int64",
            compressors=[ZstdCodec(level=3), Crc32cCodec()],
            dimension_names=("picture",),
        )
        array[:] = values
    for form in forms:
        _create_array(group, form, len(numbers))


def _create_array(group: Any, form: Form, count: int) -> None:
    from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, ZstdCodec

    small = form.bits == 8
    zstd = ZstdCodec(level=ZSTD_LEVEL) if small else BloscCodec(cname="zstd", clevel=BLOSC_LEVEL, shuffle="shuffle")
    bands, size = (len(CHANNELS),) * form.colour, (form.height, form.width)
    group.create_array(
        form.name,
        shape=(count, *bands, *size),
        chunks=(1, *(1,) * form.colour, *size),
        shards=(1, *bands, *size),
        dtype=f"uint{form.bits}",
        serializer=BytesCodec(endian=None if small else "little"),
        compressors=[zstd, Crc32cCodec()],
        fill_value=0,
        dimension_names=("picture", *("channel",) * form.colour, "row", "column"),
        attributes={"channels": list(CHANNELS)} if form.colour else {},
    )


def _remove_metadata(store: Path) -> None:
    """What a run has left that died while it wrote this; the pictures stay."""
    for name in NUMBERS:
        shutil.rmtree(store / name, ignore_errors=True)
    for path in (store / "zarr.json", *store.glob("*/zarr.json")):
        path.unlink(missing_ok=True)


@dataclass(frozen=True)
class _Attributes:
    """What the group says of itself."""

    format: str = ""
    pictures: int = 0
    forms: tuple[str, ...] = ()
    reasons: Mapping[int, str] = field(default_factory=dict)

    @classmethod
    def of(cls, store: Path) -> "_Attributes":
        said = json.loads((store / "zarr.json").read_bytes())["attributes"]
        forms, refused = said.get("forms", []), said.get("refused", {})
        if not isinstance(forms, list) or not isinstance(refused, dict):
            raise ValueError("its zarr.json lists no pictures")
        reasons = {int(number): str(why) for number, why in refused.items()}
        return cls(said.get("format", ""), int(said.get("pictures", 0)), tuple(forms), reasons)


def _listed(numbers: Any, pictures: int) -> list[Any]:
    """The `numbers` of an array, one for each of the `pictures`."""
    if numbers.shape != (pictures,):
        raise ValueError("the numbers of its pictures contradict each other")
    return np.asarray(numbers).tolist()


def read_metadata(store: Path) -> Contents:
    """What the archive `store` holds; raises InputError where it is none, or is damaged."""
    import zarr

    try:
        said = _Attributes.of(store)
        if said.format != FORMAT:
            raise InputError(f'"{store}" is no archive of format "{FORMAT}"; import the pictures with this version.')
        group = zarr.open_group(store, mode="r", zarr_format=3)
        *numbers, codes = (_listed(group[name], said.pictures) for name in NUMBERS)
        keys = list(zip(*numbers, strict=True))
        if keys != sorted(set(keys)) or not len(keys) == len(codes) == said.pictures:
            raise ValueError("the numbers of its pictures contradict each other")
        forms = [_form(store, name) for name in said.forms]
        found = [None if code == REFUSED else forms[code] for code in codes]
    except FileNotFoundError as error:
        raise InputError(f'"{store}" is no archive of pictures; name one that calibore import has made.') from error
    except (OSError, ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        why = str(error).split("\n")[0].rstrip(".") or type(error).__name__
        raise InputError(
            f'Archive "{store}" is damaged: what lists its pictures cannot be read ({why}); restore it from a copy, or '
            "import the pictures again."
        ) from error
    return Contents(keys, found, said.reasons)


def _form(store: Path, name: str) -> Form:
    """The form called `name`, if its array is laid out as this program reads it."""
    form, metadata = Form.named(name), json.loads((store / name / "zarr.json").read_bytes())
    outer = metadata["codecs"][0]
    inner = outer["configuration"]
    codecs = [codec["name"] for codec in inner["codecs"]]
    index = [codec["name"] for codec in inner["index_codecs"]]
    if form is None or (outer["name"], codecs, index, inner.get("index_location", "end")) != (
        "sharding_indexed",
        ["bytes", "zstd" if form.bits == 8 else "blosc", "crc32c"],
        ["bytes", "crc32c"],
        "end",
    ):
        raise InputError(f'Array "{name}" of archive "{store}" is laid out in another way; import the pictures again.')
    return form
