"""File names that carry numbers: `"plane12in {station:03d} {take}.png"` read backwards."""

import re
from dataclasses import dataclass
from functools import cached_property
from string import Formatter

from calibore.errors import InputError

FIELDS = ("station", "angular", "take")
"""Fields of a pattern; `station` must be there, the others are 0 where absent."""

_SPEC = re.compile(
    r"(?:(?P<fill>[^{}/])?(?P<align>[<>=^]))?(?P<sign>[-+ ])?(?P<base_prefix>#)?(?P<zero>0)?(?P<width>\d{1,3})?"
    r"(?P<group>[_,])?(?P<type>[bdoxX])?"
)
_LARGEST = 2**63  # stations are stored as 64 bit numbers
_BASES = {"b": 2, "o": 8, "d": 10, "x": 16, "X": 16}
_DIGITS = {2: "01b", 8: "0-7o", 10: "0-9", 16: "0-9a-fA-FxX"}


@dataclass(frozen=True)
class _Number:
    """One field with its format specification."""

    name: str
    spec: str

    @property
    def _parts(self) -> dict[str, str]:
        match = _SPEC.fullmatch(self.spec)
        assert match is not None
        return {key: value or "" for key, value in match.groupdict().items()}

    @property
    def _fill(self) -> str:
        parts = self._parts
        return parts["fill"] or ("0" if parts["zero"] else " " if parts["width"] else "")

    @property
    def expression(self) -> str:
        parts = self._parts
        characters = "".join(map(re.escape, f"-+{self._fill}{parts['group']}{parts['sign'].strip('-+')}"))
        return f"([{characters}{_DIGITS[_BASES[parts['type'] or 'd']]}]{{{max(int(parts['width'] or 1), 1)},}}?)"

    def value(self, text: str) -> int | None:
        """The number that is written as `text`; None if there is none."""
        parts = self._parts
        fill = self._fill or " "
        for candidate in (text, text.strip(fill), text.lstrip(fill), text.replace(fill, "")):
            try:
                number = int(candidate.replace(parts["group"] or ",", ""), _BASES[parts["type"] or "d"])
            except ValueError:
                continue
            if abs(number) < _LARGEST and format(number, self.spec) == text:
                return number
        return None


@dataclass(frozen=True)
class NamePattern:
    """A Python format string with the integer fields `{station}`, `{angular}`, `{take}` (any integer format).

    A name matches only if formatting its numbers gives that name again, so two names never mean the same picture.
    """

    text: str

    def __post_init__(self) -> None:
        fields = [number.name for number in self._pieces if isinstance(number, _Number)]
        if "station" not in fields:
            raise self._error("has no field {station}")

    def _error(self, what: str) -> InputError:
        return InputError(
            f'Image name pattern "{self.text}" {what}; allowed fields are {{station}}, {{angular}} and {{take}} with '
            'an integer format, as in "ring {station:03d} {take}.png", and {station} is needed.'
        )

    @cached_property
    def _pieces(self) -> tuple[str | _Number, ...]:
        pieces: list[str | _Number] = []
        try:
            parsed = list(Formatter().parse(self.text))
        except ValueError as error:
            raise self._error(f"cannot be read ({error})") from error
        for literal, name, spec, conversion in parsed:
            pieces.append(literal)
            if name is None:
                continue
            if name not in FIELDS:
                raise self._error(f"has the unknown field {{{name}}}")
            if conversion or not _SPEC.fullmatch(spec or ""):
                raise self._error(
                    f'formats {name} with "{"!" + conversion if conversion else spec}", not an integer format'
                )
            pieces.append(_Number(name, spec or ""))
        return tuple(pieces)

    @cached_property
    def _expression(self) -> re.Pattern[str]:
        return re.compile(
            "".join(p.expression if isinstance(p, _Number) else re.escape(p) for p in self._pieces), re.DOTALL
        )

    @cached_property
    def folders(self) -> tuple[re.Pattern[str] | str, ...]:
        """What each sub-folder on the way must look like: its name, or an expression where it carries numbers."""
        parts: list[tuple[str, bool]] = [("", False)]
        for piece in self._pieces:
            if isinstance(piece, _Number):
                parts[-1] = (parts[-1][0] + piece.expression, True)
                continue
            for index, text in enumerate(piece.split("/")):
                if index:
                    parts.append(("", False))
                parts[-1] = (parts[-1][0] + re.escape(text), parts[-1][1])
        names = self.text.replace("{{", "{").replace("}}", "}").split("/")
        return tuple(re.compile(part) if varies else name for (part, varies), name in zip(parts, names, strict=True))[
            :-1
        ]

    def match(self, name: str) -> dict[str, int] | None:
        """The numbers in `name` (sub-folders separated by "/"), absent fields 0; None if it does not match."""
        match = self._expression.fullmatch(name)
        if match is None:
            return None
        numbers = [piece for piece in self._pieces if isinstance(piece, _Number)]
        found: dict[str, int] = {}
        for number, text in zip(numbers, match.groups(), strict=True):
            value = number.value(text)
            if value is None or found.setdefault(number.name, value) != value:
                return None
        return {field: found.get(field, 0) for field in FIELDS}
