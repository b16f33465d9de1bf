"""User reference implementations of custom laws that a run's replay uses, stored next to its scene.

They do not affect the simulation, only its replay: after a change only the replay is repeated.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from typing_extensions import TypedDict

from pywet import run_folder
from pywet.laws import custom_laws
from pywet.util.files import AGAIN, read_bytes, read_if_there, write_json
from pywet.util.notices import notice

FILE = "reference.json"


class Named(TypedDict):
    """Content of the file that names a run's user reference implementations by kind of law, with a digest of their code."""

    functions: dict[str, str]
    word: str


def leave(run_dir: Path, functions: Mapping[Any, str]) -> None:
    """Write the names of the functions that the replay of this run uses."""
    if functions:
        write_json(run_dir / FILE, Named(functions=dict(functions), word=word(functions)))
    else:
        run_folder.remove(run_dir, FILE)


def same(run_dir: Path, functions: Mapping[Any, str]) -> bool:
    """Return whether a run used these functions and their code has not changed since."""
    return _left(run_dir)["word"] == word(functions)


def of_run(run_dir: Path) -> dict[str, str]:
    """Return the functions of a run that are permitted to run; any other is omitted with a notice."""
    named = _left(run_dir)["functions"]
    for name in (name for name in named.values() if not custom_laws.may_run(name)):
        notice.warning(
            f"the user reference implementation {name} was not run: read its file, then name it in config.yaml or give --trust"
        )
    return {kind: name for kind, name in named.items() if custom_laws.may_run(name)}


def trust(run_dir: Path) -> None:
    """Permit the functions that a run names to run with their present content."""
    custom_laws.trust(_left(run_dir)["functions"].values())


def word(functions: Mapping[Any, str]) -> str:
    """Return a digest of the names and files of these functions; empty without any."""
    parts = [
        f"{kind} {name}".encode() + read_bytes(Path(name.rpartition(":")[0]), custom_laws.CURE)
        for kind, name in sorted(functions.items())
    ]
    return hashlib.sha256(b"\0".join(parts)).hexdigest()[:16] if parts else ""


def _left(run_dir: Path) -> Named:
    return read_if_there(run_dir / FILE, AGAIN, Named) or Named(functions={}, word="")
