"""Files that were damaged: what of a sound file is changed follows from a seed alone, so that a failure can be made again."""

from __future__ import annotations

import io
import random
import re
import struct
from collections.abc import Callable
from typing import Any

import pandas as pd
import pyarrow as pa

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?")
WORD = re.compile(rb"[^\s,:;{}\[\]\"]+")
NUMBERS = (
    b"0", b"-1", b"1", b"2", b"1e-320", b"1e-30", b"1e30", b"1e300", b"1e999", b"-1e308", b"nan", b"inf", b"-inf", b".inf",
    b".nan", b"99999999999", b"4294967296", b"9223372036854775808", b"0x10", b"1_000", b"1,5", b"007", b"1e", b"", b"true",
    b"null", b"9" * 400,
)  # fmt: skip
BYTES = (
    b"\0",
    b"\xff\xfe",
    b"\xc3",
    b"\xe9",
    b"\xed\xa0\x80",
    b"\r",
    b"\t",
    b"\x1b[31m",
    b"\xef\xbb\xbf",
    b"\xe2\x80\xa8",
    b'"',
    b"#",
    b"&a ",
    b"*a",
    b"- ",
    b"!!x ",
)
INTEGERS = (0, 1, 2, 255, 2**31 - 1, 2**31, 2**32 - 1)


def mangled(data: bytes, seed: int, suffix: str = "") -> bytes:
    """A sound file's bytes with one to three changes; of two tables of three the change is one of its content."""
    rng = random.Random(seed)
    if suffix == ".parquet" and rng.random() < 0.67:
        return _table(data, rng)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(HOW)(data, rng)
    return data


def _span(data: bytes, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(data) + 1)
    return start, min(len(data), start + int(2.0 ** rng.uniform(0, 12)))


def _bits(data: bytes, rng: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 8)) if data else 0):
        changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def _doubled(data: bytes, rng: random.Random) -> bytes:
    start, end = _span(data, rng)
    return data[:end] + data[start:end] * rng.choice((1, 1, 3)) + data[end:]


def _dropped(data: bytes, rng: random.Random) -> bytes:
    start, end = _span(data, rng)
    return data[:start] + data[end:]


def _moved(data: bytes, rng: random.Random) -> bytes:
    start, end = _span(data, rng)
    rest, to = data[:start] + data[end:], rng.randrange(len(data) - (end - start) + 1)
    return rest[:to] + data[start:end] + rest[to:]


def _inserted(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(BYTES) * rng.choice((1, 1, 50)) + data[at:]


def _number(data: bytes, rng: random.Random) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    at = rng.choice(found)
    return data[: at.start()] + rng.choice(NUMBERS) + data[at.end() :]


def _swapped(data: bytes, rng: random.Random) -> bytes:
    """Two words in each other's place."""
    found = list(WORD.finditer(data))
    if len(found) < 2:
        return data
    a, b = sorted(rng.sample(found, 2), key=lambda word: word.start())
    return data[: a.start()] + b[0] + data[a.end() : b.start()] + a[0] + data[b.end() :]


def _lines(data: bytes, rng: random.Random) -> bytes:
    """Two lines in each other's place, or one twice, or without one."""
    lines = data.splitlines(keepends=True)
    if len(lines) < 2:
        return data
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(3)
    if how == 0:
        lines[a], lines[b] = lines[b], lines[a]
    elif how == 1:
        lines.insert(b, lines[a])
    else:
        del lines[a]
    return b"".join(lines)


def _integer(data: bytes, rng: random.Random) -> bytes:
    """Four bytes, most often at a multiple of four, as a count that there cannot be."""
    if len(data) < 4:
        return data
    at = rng.randrange(len(data) - 3) // 4 * 4
    return data[:at] + struct.pack("<I", rng.choice(INTEGERS)) + data[at + 4 :]


HOW: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _bits, _cut, _doubled, _dropped, _moved, _inserted, _number, _number, _number, _swapped, _lines, _integer,
)  # fmt: skip


VALUES: tuple[Any, ...] = (
    0,
    -1,
    1,
    2,
    10**6,
    2**31,
    2**62,
    -(2**63),
    0.5,
    -0.5,
    1e-320,
    1e30,
    1e308,
    float("nan"),
    float("inf"),
    None,
    True,
    "x",
    "",
)
"""What a column may be given."""


def _table(data: bytes, rng: random.Random) -> bytes:
    """A table with other columns or rows, which are written as the sound ones are."""
    table = pd.read_parquet(io.BytesIO(data))
    name, row = rng.choice(list(table.columns)), rng.randrange(max(len(table), 1))
    how, new = rng.randrange(12), rng.choice(VALUES)
    if how == 0:
        table[name] = [new] * len(table)
    elif how <= 3:
        table[name] = [new if k == row else value for k, value in enumerate(table[name])]
    elif how == 4:
        table = table.drop(columns=name)
    elif how == 5:
        table = table.iloc[:row]
    elif how == 6:
        table = pd.concat([table, table])
    elif how == 7:
        table = table.drop(index=table.index[row : row + 1])
    elif how == 8:
        table = table.sample(frac=1.0, random_state=rng.randrange(2**31))
    elif how == 9:
        table[name] = -table[name] if table[name].dtype.kind in "if" else table[name]
    elif how == 10:
        other = rng.choice(list(table.columns))
        table[name], table[other] = table[other].copy(), table[name].copy()
    else:
        table = table.astype({name: rng.choice(("float32", "int8", "str", "bool"))}, errors="ignore")
    out = io.BytesIO()
    try:
        table.to_parquet(out)
    except (ValueError, TypeError, OverflowError, pa.lib.ArrowException):  # values that cannot be written give no file
        return data[: rng.randrange(len(data))]
    return out.getvalue()
