"""Loops compiled by numba and cached between processes.

numba detects changes only in the file of the cached function, so that all functions compiled into it are in the same file
(tested).
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba import njit


def _private(folder: str) -> bool:
    """Return whether a folder belongs to the caller and nobody else can write to it, since its files are loaded as code."""
    try:
        Path(folder).mkdir(mode=0o700, parents=True, exist_ok=True)
        found = os.stat(folder)
    except (OSError, ValueError):
        return False
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


_folder = getattr(numba.config, "CACHE_DIR", "")
CACHED = not _folder or _private(_folder)
"""Whether machine code is cached: not in a folder of $NUMBA_CACHE_DIR to which others can write."""


def compiled(function: Callable[..., Any]) -> Any:
    """Return the compiled function; division by zero is as in numpy."""
    try:
        return njit(cache=CACHED, error_model="numpy")(function)
    except RuntimeError:  # no writable folder for the cache
        return njit(error_model="numpy")(function)
