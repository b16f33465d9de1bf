"""The physics of liquid bridges: one law = one plain function; `registry` finds them by name. Nothing of engines or scenes.

`pywet.laws.capillary.rabinovich` and the other modules are imported when they are asked for; they need numpy and numba alone.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any


def __getattr__(name: str) -> Any:
    """Import a module of laws at its first use."""
    if name.startswith("_") or find_spec(f"pywet.laws.{name}") is None:
        raise AttributeError(f"module {__name__} has no attribute {name}")
    return import_module(f"pywet.laws.{name}")
