"""Names of laws in a configuration, a scene or a query: a checked name for each kind."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

from pywet.strict import Strict


def _law(text: str) -> str:
    """Check the form of a law's name: a built-in name or path/to/file.py:function."""
    if not text or len(text) > 1000 or not text.isprintable():
        raise ValueError("a law's name, or path/to/file.py:function, on one line of at most 1000 characters")
    return text


LawName = Annotated[str, AfterValidator(_law)]


class Laws(Strict):
    """A law for each kind, by its name or as path/to/file.py:function."""

    capillary: LawName | None = None
    viscous_normal: LawName | None = None
    viscous_tangential: LawName | None = None
    rupture: LawName | None = None
    dynamic_rupture: LawName | None = None
    formation: LawName | None = None
    transfer: LawName | None = None
    shedding: LawName | None = None
    """Law by which a film sheds a drop; None: never."""
