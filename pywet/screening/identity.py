"""What a run of a case depends on, as one word: the resolved scene, its apparatus, the code of its laws and of the plugin.

Two runs with the same word give the same numbers. Sources, reasons and comments of the configuration are not in it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import pywet
from pywet import run_folder
from pywet.apparatus import build_apparatus
from pywet.config import Config
from pywet.errors import PywetError
from pywet.files import atomic_write, read_bytes, read_if_there, write_json
from pywet.laws import own
from pywet.notices import notice
from pywet.screening import cases

FILE = "identity.json"
CODE = ("apparatus", "laws", "engines")
"""Rooms of the package whose code a run goes through."""


def identity(config: Config, number: int, scale_name: str) -> str:
    """The word of a case at a scale; raises `PywetError` where the case cannot be built."""
    case, scale = config.case(number), config.scale(scale_name)
    made, spec = cases.ingredients(config, number, scale_name), cases.apparatus_spec(config, case, scale)
    scene = cases.assemble(config, case, scale, made, build_apparatus(spec))
    text = json.dumps([scene.model_dump(mode="json"), asdict(spec), _code()], sort_keys=True)
    for law in sorted(set(scene.effects.laws.values())):
        if own.is_own(law):  # what its file says counts, not where it lies
            text = text.replace(json.dumps(law), _text(law))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def of_description(description: dict[str, Any]) -> str:
    """The word of a described scene: what it says and the code of its run; where its files lie is not in it."""
    said = {key: value for key, value in description.items() if key not in ("folder", "file")}
    return hashlib.sha256(json.dumps([said, _code()], sort_keys=True).encode()).hexdigest()[:16]


def told(config: Config, number: int, scale_name: str, preset: str | None = None) -> str:
    """The same for the workflow, with another preset where it is named; why not, where a case cannot be built."""
    try:
        return identity(config.with_preset(preset) if preset else config, number, scale_name)
    except PywetError as error:
        return str(error)


def content(config: Config) -> str:
    """All that is configured, sources and reasons too, as a word: what the report shows. Comments are not in it."""
    parts = [
        m.model_dump(mode="json") for m in (config.settings, config.materials, config.scales, *config.cases.values())
    ]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def ask(run_dir: Path, word: str) -> str:
    """Write which run the configuration asks of a directory, unless that is what it says; returns the file.

    It is an input of the workflow, and older than the run's status only where the run is the one that is asked for.
    """
    path, text = run_dir / run_folder.CONFIGURED, json.dumps({"identity": word})
    if not path.exists() or path.read_text() != text:
        with atomic_write(path) as temporary:
            temporary.write_text(text)
    return str(path)


def leave(run_dir: Path, word: str) -> None:
    write_json(run_dir / FILE, {"identity": word})


def left(run_dir: Path) -> str | None:
    """The word of the run in a folder, None where there is none or the file holds no word."""
    try:
        word: str = (read_if_there(run_dir / FILE, shape=dict[str, str]) or {})["identity"]
    except (PywetError, KeyError):
        return None
    return word


@contextmanager
def room_for(run_dir: Path, word: str) -> Iterator[None]:
    """Hold a run directory for a run of this word; one of another that is in it is moved aside, with a notice."""
    with ExitStack() as held:
        held.enter_context(run_folder.hold(run_dir))
        if left(run_dir) not in (None, word):
            moved = run_folder.move_aside(run_dir)
            notice.warning(f"{run_dir} held a run of another configuration or version: it is in {moved} now")
            held.close()
            held.enter_context(run_folder.hold(run_dir))
        yield


def _text(law: str) -> str:
    """Hash of the file of a law of the user's own, and its name in it."""
    path, _, name = law.rpartition(":")
    return name + hashlib.sha256(read_bytes(Path(path), own.CURE)).hexdigest()


@cache
def _code() -> str:
    digest = hashlib.sha256(pywet.__version__.encode())
    here = Path(__file__).parents[1]
    for path in sorted(
        p for room in CODE for p in (here / room).rglob("*") if p.suffix in (".py", ".cpp", ".h", ".j2")
    ):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()
