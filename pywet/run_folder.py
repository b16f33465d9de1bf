"""Whose a run directory is, who may write in it, and what may be deleted of it.

A folder becomes a run directory by `claim`, which leaves the folder `.pywet`; a folder with anything else in it is refused. Each
stage `record`s in it what it has written, and `forget` deletes what is recorded there and nothing else. Whoever writes
`hold`s the directory; stages that only add to a finished run share it.
"""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from pywet.errors import PywetError, shown
from pywet.files import read_if_there, write_json

MARKER = ".pywet"
LOCK = ".engine.lock"
CONFIGURED = "configured.json"
"""What the configuration asks of this directory, which Snakemake and `pywet run` write and compare."""
SCENE = "scene.json"
WORKING = ("engine.partial", "engine.partial.new", "vtk.partial")
"""Folders that hold a run under way; they are made by it and replaced as a whole."""
NOT_YET = (MARKER, LOCK, CONFIGURED, "status")
"""What may be in a folder before a run claims it."""
_held: dict[str, int] = {}
"""Directories that this process holds, and how often."""


def claim(run_dir: Path) -> None:
    """Make a folder a run directory; refused where it holds files that no run has made, or links to elsewhere."""
    folder = Path(run_dir)
    if folder.is_dir():
        _refuse_links(folder)
        if not (folder / MARKER).is_dir() and not (folder / SCENE).is_file():
            others = sorted(name for name in os.listdir(folder) if name not in NOT_YET)
            if others:
                raise PywetError(
                    f"{shown(folder)} holds {shown(Path(others[0]))}{' and more' if others[1:] else ''}, which no run has made; "
                    "expected a new or empty folder, or that of a run, so that nothing of yours is overwritten: name another"
                )
    elif os.path.lexists(folder):
        raise PywetError(f"{shown(folder)} is no folder; expected a new or empty one, or that of a run: name another")
    (folder / MARKER).mkdir(parents=True, exist_ok=True)


def _refuse_links(folder: Path) -> None:
    """A link in a run directory would carry what is written there to somebody else's files."""
    for within in (folder, *(folder / name for name in ("history", "results", "status", MARKER, *WORKING))):
        if within != folder and within.is_symlink():
            break  # named by the loop over the folder itself
        if within.is_dir():
            for entry in os.scandir(within):
                if entry.is_symlink():
                    raise PywetError(
                        f"{shown(Path(entry.path))} is a symbolic link; expected files and folders of the run's own: remove "
                        "the link, or name another folder"
                    )


@contextmanager
def hold(run_dir: Path, shared: bool = False) -> Iterator[None]:
    """Hold a run directory while it is written to; the lock goes with the process, also when that is killed.

    `shared`: beside others that only add to a finished run. A process that holds a directory may hold it again.
    """
    folder = Path(run_dir)
    if shared and not (folder / SCENE).is_file():
        yield  # nothing there to add to: whoever asked says so
        return
    claim(folder)
    name = os.path.realpath(folder)
    if _held.get(name):
        _held[name] += 1
        try:
            yield
        finally:
            _held[name] -= 1
        return
    try:
        lock = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
    except OSError as error:
        if error.errno != errno.ELOOP:
            raise
        raise PywetError(f"{shown(folder / LOCK)} is a symbolic link; expected a file of the run: remove it") from error
    try:
        try:
            fcntl.flock(lock, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise PywetError(f"another run is at work in {folder}; wait for it or stop it") from error
        _held[name] = 1
        yield
    finally:
        _held.pop(name, None)
        os.close(lock)


def record(run_dir: Path, stage: str, paths: Iterable[Path]) -> None:
    """Note which files a stage has written, beside what it had written before."""
    wrote = {str(Path(path).relative_to(run_dir)) for path in paths}
    write_json(Path(run_dir) / MARKER / f"{stage}.json", sorted(wrote | set(_recorded(run_dir, stage))))


@contextmanager
def recording(run_dir: Path, stage: str, patterns: Iterable[str]) -> Iterator[None]:
    """Note the files of these names that are new or changed at the end."""
    patterns = tuple(patterns)
    before = _stamps(run_dir, patterns)
    yield
    record(run_dir, stage, (path for path, stamp in _stamps(run_dir, patterns).items() if before.get(path) != stamp))


def _stamps(run_dir: Path, patterns: Iterable[str]) -> dict[Path, tuple[int, int, int]]:
    """Inode, size and time of the files of these names."""
    files = [path for name in patterns for path in Path(run_dir).glob(name) if path.is_file()]
    return {path: ((of := path.stat()).st_ino, of.st_size, of.st_mtime_ns) for path in files}


def _recorded(run_dir: Path, stage: str) -> list[str]:
    names = read_if_there(Path(run_dir) / MARKER / f"{stage}.json", "remove the run directory", list[str]) or []
    return [name for name in names if ".." not in Path(name).parts and not os.path.isabs(name)]


def missing(run_dir: Path, stages: Iterable[str]) -> list[str]:
    """What these stages have written and is not there; a stage without a record is missing itself."""
    lost = []
    for stage in stages:
        names = _recorded(run_dir, stage)
        lost += [name for name in names if not (Path(run_dir) / name).is_file()] if names else [stage]
    return lost


def forget(run_dir: Path, *stages: str) -> None:
    """Delete what these stages have written, the latest first, and folders that this leaves empty.

    A file that was put into the directory by somebody else stays.
    """
    folder = Path(run_dir)
    for stage in stages:
        names = _recorded(folder, stage)
        for name in names:
            (folder / name).unlink(missing_ok=True)
        for name in sorted({str(p) for n in names for p in Path(n).parents if str(p) != "."}, reverse=True):
            if (folder / name).is_dir() and not any((folder / name).iterdir()):
                (folder / name).rmdir()
        (folder / MARKER / f"{stage}.json").unlink(missing_ok=True)


def remove_working(folder: Path) -> None:
    """Delete a folder of a run under way, or a part of one, in a run directory."""
    folder = Path(folder)
    if not os.path.lexists(folder):
        return
    name = next((p for p in (folder, *folder.parents) if p.name in WORKING or p.name == "engine"), None)
    if name is None or not (name.parent / MARKER).is_dir() or folder.is_symlink() or not folder.is_dir():
        raise PywetError(f"{shown(folder)} is not the working folder of a run; expected one, so it was not deleted")
    shutil.rmtree(folder)


def remove_run(run_dir: Path) -> None:
    """Delete a whole run directory that a study has made for itself."""
    if not os.path.lexists(run_dir):
        return
    if not (Path(run_dir) / MARKER).is_dir() or Path(run_dir).is_symlink():
        raise PywetError(f"{shown(run_dir)} is no run directory; expected one, so it was not deleted")
    shutil.rmtree(run_dir)


def name_folder(run_dir: Path, made: Path, name: str) -> list[Path]:
    """Give a finished working folder its name, beside files that somebody else put there; returns its files."""
    folder = Path(run_dir) / name
    targets = {path: folder / path.relative_to(made) for path in made.rglob("*") if path.is_file()}
    if not folder.is_dir():
        made.rename(folder)
        return list(targets.values())
    for path, target in targets.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)
    remove_working(made)
    return list(targets.values())


def move_aside(run_dir: Path) -> Path:
    """Rename a run directory to the first free `NAME.1`, `NAME.2` … beside it."""
    folder = Path(run_dir)
    here = Path.cwd().resolve()
    if folder.resolve() in (here, *here.parents):
        raise PywetError(
            f"{shown(folder)} holds a run of another configuration, and is the folder that this command is called in; expected "
            "another one: name it with --out"
        )
    number = 1
    while os.path.lexists(folder.with_name(f"{folder.name}.{number}")):
        number += 1
    return folder.rename(folder.with_name(f"{folder.name}.{number}"))
