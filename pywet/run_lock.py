"""Who may work in a run directory: one call that simulates, or any number that evaluate a finished run."""

from __future__ import annotations

import fcntl
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pywet.errors import FileError, PywetError, shown
from pywet.run_folder import LIST, LOCK, claim, drop_temporary, open_own, refuse_links

Key = tuple[int, int, str]
_held: dict[Key, int] = {}
"""Locks of this process by process, thread and folder: a stage within a call that holds the folder needs none of its own."""


@contextmanager
def hold(run_dir: Path, shared: bool = False) -> Iterator[None]:
    """Lock the run directory; `shared` with others that only evaluate a finished run. It is made where it is missing.

    Raises `PywetError` at once where another call holds it, before anything in it is written. The lock ends with the process,
    also when that is killed.
    """
    run_dir, key = Path(run_dir), _key(run_dir)
    if key in _held or (shared and not any((run_dir / name).exists() for name in (LIST, "scene.json"))):
        yield
        return
    refuse_links(run_dir)
    if not shared:
        claim(run_dir)
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
def hold_part(run_dir: Path, name: str) -> Iterator[None]:
    """Lock one output of a run, such as `vtk`, that two evaluations would both replace."""
    lock = _locked(Path(run_dir), f".{name}.lock", fcntl.LOCK_EX)
    try:
        yield
    finally:
        os.close(lock)


def _locked(run_dir: Path, name: str, how: int) -> int:
    try:
        lock = open_own(run_dir / name, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise FileError(
            f"{shown(run_dir / name)} could not be opened ({error.strerror}); expected a writable folder with free space",
            path=run_dir / name,
        ) from error
    try:
        fcntl.flock(lock, how | fcntl.LOCK_NB)
        there = _same(lock, run_dir / name)
    except BlockingIOError:
        there = False
    if not there:  # held, or moved aside by a call that held it until now
        os.close(lock)
        raise PywetError(f"another run is at work in {shown(run_dir)}; wait for it or stop it")
    return lock


def _same(lock: int, path: Path) -> bool:
    """Whether a lock is still that of the path."""
    try:
        return os.path.samestat(os.fstat(lock), os.lstat(path))
    except OSError:
        return False


def check_held(run_dir: Path) -> None:
    """Raise where the folder that this process holds is no longer where it was."""
    lock = _held.get(_key(run_dir))
    if lock is not None and not _same(lock, Path(run_dir) / LOCK):
        raise PywetError(
            f"{shown(run_dir)} was moved or removed while its run was at work; expected it to stay: call again with its new "
            "path, and the run goes on"
        )


def _key(run_dir: Path) -> Key:
    return os.getpid(), threading.get_ident(), os.path.realpath(run_dir)
