"""Folder of a sweep's table and page, which belongs to one file: two files with the same name have two folders."""

from __future__ import annotations

import itertools
import os
from pathlib import Path

from typing_extensions import TypedDict

from pywet.errors import FileError, shown
from pywet.util.files import make_folder, read_if_there, write_json
from pywet.util.notices import notice

ROOT = Path("results/sweeps")
STORE = ROOT / "store"
WRITTEN = ("sweep.parquet", "sweep.csv", "report.html")
"""Files that a sweep writes into its folder, replacing those of an earlier call."""
OWNER = "file.json"
"""File that names the file of the sweep, by its path from the folder."""
ADDED = "added.json"
"""File with the points that adaptive sampling has added."""
CURE = "remove the file, and the next call writes it"


class Owner(TypedDict):
    """File of the sweep to which a folder of results belongs."""

    file: str


def named(folder: Path) -> Path | None:
    """Return the file whose sweep is in a folder, whether it still exists or not; None if there is none."""
    found = read_if_there(folder / OWNER, CURE, Owner)
    return None if found is None else (folder.resolve() / found["file"]).resolve()


def owner(folder: Path) -> Path | None:
    """Return the file whose sweep is in a folder; None if there is none or the file no longer exists."""
    path = named(folder)
    return path if path is not None and path.exists() else None


def of(file: Path) -> Path:
    """Return `results/sweeps/NAME`, with a number if that folder belongs to another file of this name."""
    for k in itertools.count(1):
        folder = ROOT / (file.stem if k == 1 else f"{file.stem}-{k}")
        if folder != STORE and owner(folder) in (None, file.resolve()):
            return folder
    raise AssertionError


def claim(folder: Path, file: Path) -> None:
    """Assign a folder to a file's sweep; raises if it contains another file's sweep or files that would be overwritten."""
    make_folder(folder)
    there = owner(folder)
    if not os.path.lexists(folder / OWNER) and (found := [n for n in WRITTEN if os.path.lexists(folder / n)]):
        raise FileError(
            f"{shown(folder)} holds {found[0]} and no sweep ({OWNER}); expected a new folder, or that of the sweep: name another",
            code="sweep.folder_of_others",
            path=folder,
        )
    if there is None:
        _set_aside(folder, file)
        write_json(folder / OWNER, {"file": os.path.relpath(file.resolve(), folder.resolve())})
    elif there != file.resolve():
        raise FileError(
            f"{shown(folder)} holds the sweep of {shown(there)}, not of {shown(file)}; expected a folder of its own: give --out",
            code="sweep.folder_of_another",
            path=folder,
        )


def _set_aside(folder: Path, file: Path) -> None:
    """Rename the points that were added to the sweep of another file, which no longer exists."""
    path, before = folder / ADDED, named(folder)
    if before in (None, file.resolve()) or not os.path.lexists(path):
        return
    aside = next(p for k in itertools.count(1) if not os.path.lexists(p := folder / f"added.{k}.json"))
    path.rename(aside)
    notice.warning("%s holds points that were added to the sweep of %s; they are %s from now on", path, before, aside)
