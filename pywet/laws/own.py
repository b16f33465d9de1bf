"""Former name of `pywet.laws.custom_laws`, which warns for one version and is removed in the next."""

from __future__ import annotations

import warnings
from typing import Any

from pywet.laws import custom_laws


def __getattr__(name: str) -> Any:
    """Return a name of the module that replaces this one, with a warning."""
    value = getattr(custom_laws, name)
    if not name.startswith("__"):
        warnings.warn(f"pywet.laws.own is now pywet.laws.custom_laws; use custom_laws.{name}", DeprecationWarning, 2)
    return value
