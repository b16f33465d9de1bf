"""The program's source files: which of them a run depends on, and which are compiled. One list for every fingerprint."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
COMPILED = ("laws", "collisions")
"""Packages whose functions are compiled."""
RUN = ("util", "laws", "geometry", "runs", "planning", "engines")
"""Packages used by a run from its scene to its tables, in addition to the modules directly in `pywet`."""
EVALUATION = ("cases", "products", "../reference_impl")
"""Packages that build a run and that compute its results, checks and replay, in addition to those in `RUN`."""
TEXT = (".py", ".cpp", ".h", ".j2")


def of(packages: Iterable[str]) -> list[Path]:
    """List all source files of the given packages."""
    return sorted(path for name in packages for path in (PACKAGE / name).rglob("*") if path.suffix in TEXT)


def of_a_run() -> list[Path]:
    """Return the source files that a run depends on: Python, the plugin's C++, and the templates of the engine's script."""
    inside, outside = PACKAGE / "shipped" / "liggghts_inputs", PACKAGE.parent / "liggghts_inputs"
    templates = inside if inside.exists() else outside
    return [*sorted(PACKAGE.glob("*.py")), *of(RUN), *sorted(templates.glob("*.j2"))]


@cache
def digest_of_a_run() -> str:
    """Return the digest of names and contents of the files of `of_a_run`."""
    return digest(of_a_run())


@cache
def digest_of_evaluation() -> str:
    """Return the digest of names and contents of the files of `EVALUATION`."""
    return digest(of(EVALUATION))


@cache
def digest_of_program() -> str:
    """Return the digest of names and contents of all source files, those of the studies included where they are."""
    return digest([*of_a_run(), *of((".", "../reference_impl", "../studies"))])


def digest(files: Iterable[Path], *parts: str) -> str:
    """Return the digest of `parts` and of names and contents of files."""
    made = hashlib.sha256("\0".join(parts).encode())
    for path in files:
        made.update(path.name.encode() + b"\0" + path.read_bytes())
    return made.hexdigest()
