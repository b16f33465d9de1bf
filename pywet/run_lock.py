"""Locks of run directories: one call that simulates, or any number of calls that evaluate or read a finished run."""

from __future__ import annotations

import fcntl
import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from pywet.errors import FileError, PywetError, shown
from pywet.run_folder import LIST, LOCK, claim, drop_temporary, open_regular, refuse_links

Key = tuple[int, int, str]
_held: dict[Key, int] = {}
"""Locks of this process by process, thread and folder: a stage within a call that has locked the folder needs no lock."""


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
    lock = _locked(run_dir, LOCK, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
    _held[key] = lock
    try:
        if not shared:
            drop_temporary(run_dir)
        yield
    finally:
        del _held[key]
        os.close(lock)


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
