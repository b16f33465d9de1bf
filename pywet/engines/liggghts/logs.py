"""Raw log files of a run, and up to which step each is complete: sizes and checksums.

Trajectory and window dumps are the engine's text, the `.bin` logs the plugin's records (pywet/schema.py).
"""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from pywet.engines.liggghts import windows
from pywet.errors import PywetError
from pywet.schema import RAW
from pywet.util.files import read_json, write_json

TRAJECTORY = "trajectory.txt"
DUMPS = (TRAJECTORY, *(f"{name}.txt" for name in (windows.STATES, *windows.SPRINGS)))
HEAD = 9
"""Number of lines before the rows of a dump's frame."""
BLOCK = 1 << 20
UNREAD = "make it readable, then call again"
"""Hint on a file of an unfinished run that cannot be read."""
SUM = "own"
"""Key of the check sum of a JSON file within itself."""

Sums = dict[str, tuple[int, int]]
"""File, by its path in the engine's folder -> number of bytes from its start and their CRC-32."""


def files(folder: Path) -> list[Path]:
    """Return the existing raw files of all ranks."""
    dumps = [path for name in DUMPS if (path := folder / name).exists()]
    return dumps + [path for name in RAW for path in sorted(folder.glob(f"{name}.*.bin"))]


def checked(path: Path, start: int = 0, end: int | None = None, before: int = 0) -> tuple[int, int]:
    """Return bytes and CRC-32 of a file up to `end` (None: all of it); `before` is the CRC-32 of its first `start` bytes."""
    with open(path, "rb") as file:
        file.seek(start)
        while block := file.read(BLOCK if end is None else min(BLOCK, end - start)):
            before, start = zlib.crc32(block, before), start + len(block)
    return start, before


def sums_of(content: dict[str, Any]) -> Sums:
    """Return the digests in a JSON file; AttributeError, TypeError or ValueError if they are none."""
    return {name: (int(size), int(crc)) for name, (size, crc) in content.items()}


def write_signed(path: Path, content: dict[str, Any]) -> None:
    """Write a JSON file with its own check sum, the only protection of a number that describes an empty log."""
    write_json(path, {**content, SUM: _sum(content)})


def read_signed(path: Path) -> dict[str, Any]:
    """Return the content of a file of `write_signed`; PywetError if it has changed."""
    content = read_json(path, UNREAD)
    if not isinstance(content, dict) or content.pop(SUM, None) != _sum(content):
        raise PywetError(f"{path} was changed", code="checkpoint.changed", where=path)
    return content


def refuse_unread(path: Path, error: Exception) -> None:
    """Raise the error of an existing file that the operating system does not read now, because that file is not damaged."""
    if isinstance(error, PywetError) and error.code == "file.unread" and path.is_file():
        raise error


def _sum(content: dict[str, Any]) -> int:
    return zlib.crc32(json.dumps(content, sort_keys=True).encode())


def damage(folder: Path, sums: Sums, appended: bool = False) -> str | None:
    """Name the first file whose content has changed since its checksum; content `appended` to logs is allowed if so stated."""
    for name, (size, sum_then) in sums.items():
        path = folder / name
        if appended and size == 0:
            continue  # nothing of it is needed
        if not path.is_file():
            return f"{name} is missing"
        if path.stat().st_size < size or (not appended and path.stat().st_size > size):
            return f"{name} has {path.stat().st_size} bytes where {size} were written"
        if checked(path, end=size) != (size, sum_then):
            return f"{name} was changed"
    return None


def extended(folder: Path, sums: Sums, last: int, frames: list[int], last_frame: int) -> Sums | str:
    """Extend earlier digests to all logs up to step `last`, of the trajectory up to `last_frame`.

    `frames` are the steps that the trajectory must have gained. If it has not, or if a log became shorter, a phrase is returned.
    """
    grown = {}
    for path in files(folder):
        start, before = sums.get(path.name, (0, 0))
        if path.stat().st_size < start:
            return f"{path.name} became shorter"
        if path.suffix == ".bin":
            end = _records_end(path, start, last)
        else:
            end, steps = _frames_end(path, start, last_frame if path.name == TRAJECTORY else last)
            if path.name == TRAJECTORY and steps != frames:
                return f"{TRAJECTORY} has {len(steps)} of {len(frames)} output steps whole after byte {start}"
        grown[path.name] = checked(path, start, end, before)
    if TRAJECTORY not in grown and frames:
        return f"{TRAJECTORY} is missing"
    return grown


def _records_end(path: Path, start: int, last: int) -> int:
    """Return the byte at which the plugin's records up to step `last` end; they are in the order of steps."""
    dtype = RAW[path.name.split(".")[0]]
    count = (path.stat().st_size - start) // dtype.itemsize
    if not count:
        return start
    steps = np.memmap(path, dtype=dtype, mode="r", offset=start, shape=(count,))["step"]
    return start + int(np.searchsorted(steps, last, side="right")) * dtype.itemsize


def _frames_end(path: Path, start: int, last: int) -> tuple[int, list[int]]:
    """Return the byte at which the complete frames of a dump up to step `last` end, and their steps."""
    steps: list[int] = []
    with open(path, "rb") as dump:
        dump.seek(start)
        while True:
            end = dump.tell()
            head = [dump.readline() for _ in range(HEAD)]
            if head[0] != b"ITEM: TIMESTEP\n" or not head[-1].startswith(b"ITEM: ") or not head[-1].endswith(b"\n"):
                return end, steps
            if not (head[1].strip().isdigit() and head[3].strip().isdigit()) or int(head[1]) > last:
                return end, steps
            row = head[-1]
            for _ in range(int(head[3])):
                row = dump.readline()
            if not row.endswith(b"\n"):
                return end, steps
            steps.append(int(head[1]))
