"""A file as nobody would hand it in: bits, numbers, lines and keys changed at random."""

import re
import struct
from collections.abc import Callable, Sequence

import numpy as np

Random = np.random.Generator
TEXT = (".toml", ".csv", ".json", ".txt")
MOST = 4
"""Changes made to one file."""
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
KEY = re.compile(rb"[A-Za-z_][A-Za-z_0-9]*")
HOSTILE = (
    *b"0 -1 -0.0 1 2 0.5 1e308 -1e308 1e-320 1e999 nan -nan inf -inf 65536 2147483648 4294967296 -9223372036854775809 "
    b"9223372036854775807 1e20 0x7fffffff 1_0 00 .5 true false 1979-05-27 07:32:00 12:00 ''".split(),
    b'"',
    b'""',
    b'"0 mm"',
    b'"-3 mm"',
    b'"1e300 m"',
    b'"nan in"',
    b'"1 parsec"',
    b'"90 deg"',
    b"[]",
    b"[[]]",
    b"{}",
    b"{ a = 1 }",
    b"[1, 2, 3]",
    b"null",
    b'"../../../etc/passwd"',
    b'"{station}{take}{x}"',
    b'"{station.__class__}"',
    b'"\\u0000"',
    b'"a\\nb"',
    "\u202eπ\U0001f600".encode(),
    b"\x00",
    b"\xff\xfe",
    b"9" * 5000,
    b"[" * 3000,
    b"{a=" * 400,
    b'"' + b"x" * 70000 + b'"',
)
INTEGERS = (0, 1, 2, 7, 127, 128, 255, 256, 32767, 65535, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**64 - 1)


def mutated(name: str, data: bytes, rng: Random, *, others: Sequence[bytes]) -> bytes:
    """`data` of the file `name` after some changes; pieces of `others` may get into it."""
    kinds = _OF_TEXT if name.endswith(TEXT) and rng.random() < 0.9 else _OF_BYTES
    for _ in range(1 + int(rng.integers(MOST) * (rng.random() < 0.5))):
        change = kinds[rng.integers(len(kinds))]
        data = change(data, rng, others)
    return data


def _place(data: bytes, rng: Random) -> int:
    return int(rng.integers(len(data) + 1))


def _flip(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    changed = bytearray(data)
    for _flipped in range(1 + int(rng.integers(8))):
        if changed:
            changed[int(rng.integers(len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _overwrite(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    """A whole number of 1 to 8 bytes, in either order."""
    size, value = 1 << int(rng.integers(4)), INTEGERS[rng.integers(len(INTEGERS))]
    packed = struct.pack("<Q", value)[:size]
    at = _place(data, rng)
    return data[:at] + (packed if rng.random() < 0.5 else packed[::-1]) + data[at + size :]


def _truncate(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    return data[: _place(data, rng)]


def _cut(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    at = _place(data, rng)
    return data[:at] + data[at + 1 + int(rng.integers(64)) :]


def _repeat(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    at, size = _place(data, rng), 1 + int(rng.integers(256))
    return data[:at] + data[at : at + size] * (2 + int(rng.integers(3))) + data[at + size :]


def _insert(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    at = _place(data, rng)
    return data[:at] + rng.bytes(1 + int(rng.integers(16))) + data[at:]


def _splice(data: bytes, rng: Random, others: Sequence[bytes]) -> bytes:
    other = others[int(rng.integers(len(others)))] if others else b""
    return data[: _place(data, rng)] + other[_place(other, rng) :]


def _number(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    """One number is another, or no number."""
    return _replaced(NUMBER, data, HOSTILE[rng.integers(len(HOSTILE))], rng)


def _value(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    """Whatever stands behind = or : or a comma is something else."""
    return _replaced(re.compile(rb"(?<=[=:,])[^\n,]+"), data, b" " + HOSTILE[rng.integers(len(HOSTILE))], rng)


def _key(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    """One word is another word of the same file, or none that anybody knows."""
    words = KEY.findall(data) or [b"a"]
    return _replaced(KEY, data, (words[rng.integers(len(words))], b"unheard_of", b"")[rng.integers(3)], rng)


def _scaled(data: bytes, rng: Random, _: Sequence[bytes]) -> bytes:
    """One number by a power of ten."""
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    one = found[int(rng.integers(len(found)))]
    power = f"{float(one[0]) * 10.0 ** int(rng.integers(-9, 10)):g}".encode()
    return data[: one.start()] + power + data[one.end() :]


def _replaced(pattern: re.Pattern[bytes], data: bytes, by: bytes, rng: Random) -> bytes:
    found = list(pattern.finditer(data))
    if not found:
        return data + by
    one = found[int(rng.integers(len(found)))]
    return data[: one.start()] + by + data[one.end() :]


def _lines(data: bytes, rng: Random, others: Sequence[bytes]) -> bytes:
    """A line goes, comes twice, moves, or comes from elsewhere."""
    lines = data.split(b"\n")
    at, to = (int(rng.integers(len(lines))) for _ in range(2))
    kind = rng.integers(4)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(to, lines[at])
    elif kind == 2:
        lines[at], lines[to] = lines[to], lines[at]
    elif others:
        more = others[int(rng.integers(len(others)))].split(b"\n")
        lines.insert(to, more[rng.integers(len(more))])
    return b"\n".join(lines)


Change = Callable[[bytes, Random, Sequence[bytes]], bytes]
_OF_BYTES: tuple[Change, ...] = (_flip, _overwrite, _truncate, _cut, _repeat, _insert, _splice)
_OF_TEXT: tuple[Change, ...] = (
    *(_number, _value, _lines),
    *(_number, _value, _lines),
    *(_scaled, _key, _truncate, _flip, _splice),
)
