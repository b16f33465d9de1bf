"""The physics of liquid bridges: one law = one plain function; `registry` finds them by name.

This package is independent of engines and scenes. Its modules are imported at their first use and need only numpy and
numba. A law of one function with a unique name can also be imported from here: `from pywet.laws import rabinovich`.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import Any


def __getattr__(name: str) -> Any:
    """Import a module of laws at its first use, or return a law by its name."""
    if name.startswith("_"):
        raise AttributeError(f"module {__name__} has no attribute {name}")
    if find_spec(f"pywet.laws.{name}") is not None:
        return import_module(f"pywet.laws.{name}")
    built_in = import_module("pywet.laws.registry").BUILT_IN
    found = [law for laws in built_in.values() for law in laws.get(name, ())]
    if len(found) != 1:
        where = " or ".join(f"{law.__module__}.{law.python.__name__}" for law in found)
        raise AttributeError(
            f"module {__name__} has no attribute {name}; expected {where or 'a module or a law that `pywet laws` lists'}"
        )
    return found[0]
