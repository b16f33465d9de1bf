"""List of the files that pywet wrote in a run directory: `.pywet-run`, one line each.

`+ path` was written, `- path` removed; a folder that belongs to pywet with all its content ends with a slash. No other
file of a run directory is deleted or overwritten.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterable
from pathlib import Path

from pywet.errors import FileError, shown

LIST = ".pywet-run"
DEEPEST = 4
"""Largest number of folders between a run directory and its deepest file."""
TORN = "\0"
"""End of a line of the list that a full disk truncated."""


def root(path: Path) -> Path | None:
    """Return the run directory that contains a file, or None."""
    above = Path(os.path.abspath(path)).parents
    return next((folder for folder in above[:DEEPEST] if os.path.lexists(folder / LIST)), None)


def open_regular(path: Path, flags: int) -> int:
    """Open a regular file with a single link, never through a symbolic link and without truncating it."""
    file = os.open(path, flags | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK, 0o666)
    if not stat.S_ISREG(os.fstat(file).st_mode):
        os.close(file)
        raise OSError(errno.EINVAL, "not a regular file", str(path))
    return file


def listed(run_dir: Path) -> set[str]:
    """Return the paths in a run directory that pywet wrote, with a slash for its own folders; empty without a list."""
    names: set[str] = set()
    try:
        with open(open_regular(Path(run_dir) / LIST, os.O_RDONLY), encoding="utf-8", errors="surrogateescape") as file:
            for line in file:
                sign, _, name = line.rstrip("\n").partition(" ")
                if TORN in line or not line.endswith("\n"):
                    continue
                if sign == "+" and not name.startswith("/") and ".." not in name.split("/"):
                    names.add(name)
                elif sign == "-":
                    names.discard(name)
    except FileNotFoundError:
        pass
    return names


def covers(names: set[str], name: str) -> bool:
    return name in names or any(f"{parent.as_posix()}/" in names for parent in Path(name).parents)


def record(run_dir: Path, names: Iterable[str], removed: bool = False) -> None:
    """Add paths to the list of a run directory, or, if `removed`, delete them from it; nothing without a list."""
    if not os.path.lexists(Path(run_dir) / LIST):
        return
    known = listed(run_dir)
    news = [n for n in names if "\n" not in n and (n in known if removed else not covers(known, n))]
    if news:
        text = "".join(f"{'-' if removed else '+'} {name}\n" for name in news)
        with open(open_regular(Path(run_dir) / LIST, os.O_RDWR | os.O_APPEND), "r+b", buffering=0) as file:
            end = file.seek(0, os.SEEK_END)
            if end and os.pread(file.fileno(), 1, end - 1) != b"\n":
                text = f"{TORN}\n{text}"
            data = memoryview(os.fsencode(text))
            while data:
                data = data[file.write(data) or 0 :]


def write_here(path: Path) -> None:
    """Register a file before it gets its name, or refuse to overwrite a file in a run directory that pywet did not write."""
    run_dir = root(path)
    if run_dir is None:
        return
    name = Path(os.path.abspath(path)).relative_to(run_dir).as_posix()
    if os.path.lexists(path) and not covers(listed(run_dir), name):
        raise stranger(Path(path))
    record(run_dir, [name])


def remove(run_dir: Path, *names: str) -> None:
    """Delete existing files of a run; a file that is not in the run's list is refused."""
    known = listed(run_dir)
    there = [name for name in names if os.path.lexists(Path(run_dir) / name)]
    for name in there:
        if not covers(known, name):
            raise stranger(Path(run_dir) / name)
        (Path(run_dir) / name).unlink(missing_ok=True)
    record(run_dir, there, removed=True)


def stranger(path: Path) -> FileError:
    return FileError(
        f"{shown(path)} is there already and was not written by this run of pywet (its {LIST} does not list it); expected no "
        "such file: move it elsewhere",
        path=path, code="folder.stranger",
    )  # fmt: skip
