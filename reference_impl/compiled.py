"""Loops that numba compiles, kept from one process to the next.

For changes numba looks in the file of the kept function alone: what is compiled into it stands in the same file (tested).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any]) -> Any:
    """The function as machine code; by zero it divides as numpy does."""
    try:
        return njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # no folder in which it can be kept
        return njit(error_model="numpy")(function)
