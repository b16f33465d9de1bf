"""The cache folder: plugin, tables, machine code, and custom laws that are trusted.

Its files are loaded as code, so it is private: made with mode 700, owned by the caller, checked before use.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pywet.errors import PywetError, shown
from pywet.util.files import atomic_write
from pywet.util.notices import notice

SEAL = ".sha256"
"""Suffix of the file with the check sum of the file next to it."""
CURE = "set PYWET_CACHE to a folder of your own"


def folder(*below: str) -> Path:
    """Return the cache folder, or one `below` it, made if missing.

    It is $PYWET_CACHE; otherwise `pywet` in the system's cache folder ($XDG_CACHE_HOME or ~/.cache), if it belongs or
    can belong to the caller; otherwise /tmp/pywet-UID. Raises `PywetError` for a folder that belongs to somebody else,
    is writable by others or not by the caller.
    """
    path = _chosen()
    for name in below:
        path = _private(path / name)
    return path


def given(place: str, name: str) -> Path:
    """Return a folder in one named by an environment variable, if both belong to the caller; else the cache's, with a notice."""
    try:
        return _private(_private(Path(place).absolute()) / name)
    except PywetError as error:
        notice.warning(f"{error}; machine code is stored in {folder(name)}")
        return folder(name)


def _chosen() -> Path:
    if os.environ.get("PYWET_CACHE"):
        return _private(Path(os.environ["PYWET_CACHE"]).absolute())
    with suppress(PywetError):
        above = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
        if not above.exists() or _private(above):
            return _private(above / "pywet")
    return _private(Path(tempfile.gettempdir()) / f"pywet-{os.getuid()}")


def _private(path: Path) -> Path:
    """Return the folder, made if missing; raises unless it belongs to the caller and only the caller can write to it."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        there, link = path.stat(), path.lstat()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise PywetError(
            f"the cache {shown(path)} could not be made ({reason}); expected a writable folder: {CURE}",
            code="cache.not_made", where=path,
        ) from error  # fmt: skip
    if not {there.st_uid, link.st_uid} <= {os.getuid()}:
        raise PywetError(
            f"the cache {shown(path)} belongs to another user; expected a folder that you own: {CURE}",
            code="cache.owner", where=path,
        )  # fmt: skip
    if there.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        raise PywetError(
            f"the cache {shown(path)} can be written by others (mode {stat.S_IMODE(there.st_mode):o}), so that its "
            f"contents cannot be trusted; expected mode 700: remove it or {CURE}",
            code="cache.mode", where=path, given=stat.S_IMODE(there.st_mode), expected=0o700,
        )  # fmt: skip
    if not os.access(path, os.R_OK | os.W_OK | os.X_OK):
        raise PywetError(
            f"the cache {shown(path)} cannot be written; expected a writable folder: {CURE}",
            code="cache.unwritable", where=path,
        )  # fmt: skip
    return path


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """Let one process at a time make a file of the cache; others wait and then find it."""
    with path.with_name(f"{path.name}.lock").open("w") as lock:
        with suppress(OSError):  # a file system without locks: both processes compile it
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def seal(path: Path) -> None:
    """Write the check sum of a cached file next to it."""
    with atomic_write(path.with_name(path.name + SEAL)) as temporary:
        temporary.write_text(hashlib.sha256(path.read_bytes()).hexdigest())


def whole(path: Path) -> bool:
    """Return whether a cached file exists and equals, byte for byte, the sealed one."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest() == path.with_name(path.name + SEAL).read_text()
    except (OSError, UnicodeDecodeError):
        return False
