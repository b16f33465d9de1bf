"""The run directory: its folders, every deletion of more than one file, and its lock.

Only what its list (`file_list.py`) names is deleted, and a folder without a list becomes a run directory only if it is
empty. docs/reliability.md lists the files that each module may change.

The lock is for one call that simulates, or any number of calls that evaluate or read a finished run.
"""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import threading
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from pywet.errors import FileError, PywetError, one_line, shown
from pywet.util.file_list import DEEPEST, LIST, covers, listed, open_regular, record, remove, root, stranger, write_here

LOCK = ".engine.lock"
FOLDERS = (
    "engine",
    "engine.partial",
    "engine.partial.new",
    "history",
    "results",
    "status",
    "stl",
    "vtk",
    "vtk.partial",
)
"""Folders of a run that must not be symbolic links."""
TEMPORARY = re.compile(r"\..+\.(\d+)\.[0-9a-f]{8}\.partial(\.[^.]*)?")
"""Pattern of the name of an unfinished file, with the id of the process that writes it (`files.atomic_write`)."""
Key = tuple[int, int, str]
_held: dict[Key, int] = {}
"""Locks of this process by process, thread and folder: a stage within a call that has locked the folder needs no lock."""


def refuse_within(folder: Path) -> None:
    """Refuse a run directory, and a folder in one, for files that are a user's to change: a run's list would name them."""
    if run_dir := root(Path(folder) / LIST):
        raise FileError(
            f"{shown(folder)} lies in the run directory {shown(run_dir)}; expected a folder outside: name another",
            path=folder, code="folder.in_run", expected=run_dir,
        )  # fmt: skip


def claim(run_dir: Path) -> None:
    """Make a new or empty folder a run directory; raises if it contains files that no run of pywet wrote."""
    run_dir = Path(run_dir)
    try:
        refuse_links(run_dir)
        if os.path.lexists(run_dir / LIST):
            return
        _refuse_strangers(run_dir)
        run_dir.mkdir(parents=True, exist_ok=True)
        os.close(open_regular(run_dir / LIST, os.O_CREAT | os.O_WRONLY))
    except OSError as error:
        raise FileError(
            f"the run directory {shown(run_dir)} could not be written ({error.strerror}); expected a writable folder with "
            "free space",
            path=run_dir, code="folder.unwritten",
        ) from error  # fmt: skip


def _refuse_strangers(run_dir: Path) -> None:
    for folder, _, files in os.walk(run_dir):
        found = [name for name in files if Path(folder, name) != run_dir / LOCK]
        if found:
            raise FileError(
                f"{shown(run_dir)} holds {shown(Path(folder, found[0]).relative_to(run_dir))} and no list of what a run wrote "
                f"({LIST}); expected a new or empty folder, or that of an earlier run: name another, or, where a version of "
                "pywet without such lists made it, move it away and run it again",
                path=run_dir, code="folder.strangers",
            )  # fmt: skip


def refuse_links(run_dir: Path) -> None:
    """Refuse a run whose folders are symbolic links, so that nothing is written or deleted elsewhere."""
    for name in (*FOLDERS, LIST, LOCK):
        if os.path.islink(Path(run_dir) / name):
            raise FileError(
                f"{shown(Path(run_dir) / name)} is a symbolic link; expected a regular folder or file: remove the link",
                path=Path(run_dir) / name, code="folder.link",
            )  # fmt: skip


def drop_temporary(run_dir: Path) -> None:
    """Delete unfinished files of killed processes; called with the run directory locked.

    Run directories within it are not changed.
    """
    for folder, below, files in os.walk(run_dir):
        inner = Path(folder) != Path(run_dir) and LIST in files
        below[:] = [] if inner or len(Path(folder).relative_to(run_dir).parts) >= DEEPEST else below
        for name in () if inner else files:
            named = TEMPORARY.fullmatch(name)
            if named and (int(named[1]) == os.getpid() or not os.path.exists(f"/proc/{named[1]}")):
                Path(folder, name).unlink(missing_ok=True)


def remove_listed(run_dir: Path, patterns: Iterable[str]) -> None:
    """Delete the files and folders that match and are in the run's list; all else remains, with the folders that contain it."""
    run_dir, known = Path(run_dir), listed(run_dir)
    for pattern in patterns:
        for top in sorted(run_dir.glob(pattern)):
            if top.is_dir() and f"{top.relative_to(run_dir)}/" in known:
                remove_folder(run_dir, str(top.relative_to(run_dir)))
                continue
            below = [Path(f, name) for f, _, files in os.walk(top) for name in files] if top.is_dir() else [top]
            remove(run_dir, *(n for n in (p.relative_to(run_dir).as_posix() for p in below) if covers(known, n)))
            if top.is_dir():
                _drop_empty(top)


def discard(top: Path) -> None:
    """Delete the listed files of run directories in a folder, and then empty folders; all else remains."""
    for mark in sorted(Path(top).rglob(LIST), reverse=True):
        run_dir = mark.parent
        drop_temporary(run_dir)
        for name in listed(run_dir):
            if name.endswith("/"):
                remove_folder(run_dir, name.rstrip("/"))
            elif (run_dir / name).is_file():
                (run_dir / name).unlink()
        (run_dir / LOCK).unlink(missing_ok=True)
        mark.unlink()
    if Path(top).is_dir() and not Path(top).is_symlink():
        _drop_empty(Path(top))


def _drop_empty(top: Path) -> None:
    """Remove a folder and its subfolders if they contain no file."""
    for folder, _, _ in os.walk(top, topdown=False):
        if not os.listdir(folder):
            os.rmdir(folder)


def make_folder(run_dir: Path, name: str) -> Path:
    """Make a folder that belongs to pywet with all its content, such as `engine.partial`; an earlier one is removed first."""
    remove_folder(run_dir, name)
    record(run_dir, [f"{name}/"])
    path = Path(run_dir) / name
    path.mkdir(parents=True)
    return path


def remove_folder(run_dir: Path, name: str) -> None:
    """Delete a folder that belongs to pywet, with all its content; raises for any other folder."""
    path = Path(run_dir) / name
    if os.path.lexists(path):
        if path.is_symlink() or f"{name}/" not in listed(run_dir):
            raise stranger(path)
        shutil.rmtree(path)
    record(run_dir, [f"{name}/"], removed=True)


def rename_folder(run_dir: Path, name: str, new: str) -> None:
    """Rename a folder that belongs to pywet; the new name must be free."""
    record(run_dir, [f"{new}/"])
    (Path(run_dir) / name).rename(Path(run_dir) / new)
    record(run_dir, [f"{name}/"], removed=True)


def publish(run_dir: Path, name: str, new: str, replaced: str = ".*") -> None:
    """Replace an earlier folder by a completed one that belongs to pywet; its files are listed individually from then on.

    Files in the earlier one whose names do not match the pattern `replaced` are retained. Raises if it contains files that
    no run wrote.
    """
    made, place = Path(run_dir) / name, Path(run_dir) / new
    refuse_foreign(run_dir, new)
    for path in place.glob("*"):
        if path.is_file() and not re.fullmatch(replaced, path.name):
            path.rename(made / path.name)
    files = [p.relative_to(made).as_posix() for p in made.rglob("*") if not p.is_dir()]
    remove_listed(run_dir, [new])
    refuse_foreign(run_dir, new)
    record(run_dir, [f"{new}/{file}" for file in files])
    made.rename(place)
    record(run_dir, [f"{name}/"], removed=True)


def refuse_foreign(run_dir: Path, name: str) -> None:
    """Raise if a folder that a run will replace contains files that no run wrote."""
    known, folder = listed(run_dir), Path(run_dir) / name
    for path in folder.rglob("*"):
        if not path.is_dir() and not covers(known, path.relative_to(run_dir).as_posix()):
            raise stranger(path)


def place(made: Path, run_dir: Path, name: str) -> None:
    """Move a file that was made in a folder of the run to its final path."""
    write_here(Path(run_dir) / name)
    made.replace(Path(run_dir) / name)


def set_aside(run_dir: Path) -> Path:
    """Move a run directory to the first free of `NAME.1`, `NAME.2` … next to it, and return the new path."""
    run_dir = Path(run_dir)
    here = Path(os.path.realpath(run_dir))
    why = "is a symbolic link" if run_dir.is_symlink() else "is the working folder"
    if run_dir.is_symlink() or Path.cwd().is_relative_to(here):
        raise PywetError(
            f"{shown(run_dir)} holds a run of another configuration and {why}; expected a folder that can be moved aside: name "
            "another by --out",
            code="folder.not_moved", where=run_dir,
        )  # fmt: skip
    new = next(p for k in range(1, 10**6) if not os.path.lexists(p := here.with_name(f"{here.name}.{k}")))
    here.rename(new)
    return run_dir.with_name(new.name) if run_dir.name not in ("", "..") else new


@contextmanager
def hold(run_dir: Path, shared: bool = False) -> Iterator[None]:
    """Lock the run directory, which is made if missing; `shared` with others that only evaluate a finished run.

    Raises `PywetError` at once if another call has locked it, before anything in it is written. The lock ends
    with the process, also if that is killed.
    """
    run_dir, key = Path(run_dir), _key(run_dir)
    if key in _held or (shared and not any((run_dir / name).exists() for name in (LIST, "scene.json"))):
        yield
        return
    (refuse_links if shared else claim)(run_dir)
    if shared and not os.path.lexists(run_dir / LOCK) and not os.access(run_dir, os.W_OK):
        yield  # a read-only run that no process is writing
        return
    _held[key] = _locked(run_dir, LOCK, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
    try:
        if not shared:
            drop_temporary(run_dir)
        yield
    finally:
        os.close(_held.pop(key))


def make_way(run_dir: Path) -> Path:
    """Move a locked run directory aside and lock a new one in its place; return the new path of the earlier one."""
    aside, key = set_aside(run_dir), _key(run_dir)
    claim(run_dir)
    lock = _locked(Path(run_dir), LOCK, fcntl.LOCK_EX)
    os.close(_held[key])
    _held[key] = lock
    return aside


@contextmanager
def alone(run_dir: Path) -> Iterator[None]:
    """Lock the run directory, and report refusals by the operating system in one sentence."""
    try:
        with hold(run_dir):
            yield
    except OSError as error:
        check_held(run_dir)
        raise PywetError(
            f"the run in {run_dir} stopped: {error.strerror or one_line(error)}; expected a writable folder with free space",
            code="run.refused", where=run_dir,
        ) from error  # fmt: skip


def no_run(folder: Path) -> str:
    """Say why a folder is no run directory, and what one is."""
    found, where = sorted(one_line(path.parent.name, 60) for path in folder.glob("*/scene.json")), shown(folder)
    if not os.path.lexists(folder):
        what = f"{where} does not exist"
    elif found:
        what = f"no scene.json in {where}, which contains runs ({', '.join(found[:3])}{', …' * (len(found) > 3)})"
    else:
        what = f"no scene.json in {where}"
    return (
        f"{what}; expected a run directory, which `pywet run CASE --out DIR` and `pywet run-scene FILE --out DIR` write: with "
        "scene.json, history/ and results/ (a folder of result tables alone is none)"
    )


@contextmanager
def reading(*run_dirs: Path) -> Iterator[None]:
    """Lock runs together with others that read or evaluate them; raises if one is being simulated."""
    with ExitStack() as held:
        for run_dir in run_dirs:
            held.enter_context(hold(run_dir, shared=True))
        yield


@contextmanager
def hold_part(run_dir: Path, name: str) -> Iterator[None]:
    """Lock one output of a folder, such as `vtk` of a run, that two calls would both replace."""
    lock = _locked(Path(run_dir), f".{name}.lock", fcntl.LOCK_EX)
    try:
        yield
    finally:
        os.close(lock)


def _locked(run_dir: Path, name: str, how: int) -> int:
    try:
        read_only = how == fcntl.LOCK_SH and os.path.lexists(run_dir / name)  # a run of another user
        lock = open_regular(run_dir / name, os.O_RDONLY if read_only else os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise FileError(
            f"{shown(run_dir / name)} could not be opened ({error.strerror}); expected a writable folder with free space",
            path=run_dir / name, code="lock.unwritten",
        ) from error  # fmt: skip
    try:
        fcntl.flock(lock, how | fcntl.LOCK_NB)
        there = _same(lock, run_dir / name)
    except BlockingIOError:
        there = False
    except OSError as error:
        os.close(lock)
        raise FileError(
            f"{shown(run_dir / name)} could not be locked ({error.strerror}); expected a file system with locks: name a "
            "folder on another one, or have it mounted with them (Lustre: option flock)",
            path=run_dir / name, code="lock.unsupported",
        ) from error  # fmt: skip
    if not there:  # locked, or moved aside by a call that held the lock until now
        os.close(lock)
        raise PywetError(
            f"another run is active in {shown(run_dir)}; wait for it or stop it", code="lock.active", where=run_dir
        )
    return lock


def _same(lock: int, path: Path) -> bool:
    """Check that a lock still belongs to the file at its path."""
    try:
        return os.path.samestat(os.fstat(lock), os.lstat(path))
    except OSError:
        return False


def check_held(run_dir: Path) -> None:
    """Raise if the folder that this process has locked has been moved."""
    lock = _held.get(_key(run_dir))
    if lock is not None and not _same(lock, Path(run_dir) / LOCK):
        raise PywetError(
            f"{shown(run_dir)} was moved or removed during its run; call again with its new path, and the run resumes",
            code="lock.moved", where=run_dir,
        )  # fmt: skip


def _key(run_dir: Path) -> Key:
    return os.getpid(), threading.get_ident(), os.path.realpath(run_dir)
