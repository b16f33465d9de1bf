"""Fingerprint of everything that a case's run depends on: resolved scene, apparatus, code of its laws and of the plugin.

Two runs with the same fingerprint have the same results. Sources, reasons and comments in the configuration do not affect it.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

import pywet
from pywet.cases.screening import cases
from pywet.config import Config
from pywet.errors import PywetError
from pywet.geometry import build_apparatus
from pywet.laws import custom_laws, registry
from pywet.runs import record
from pywet.util import sources
from pywet.util.files import atomic_write, read_bytes


def identity(config: Config, number: int, scale_name: str) -> str:
    """Return the fingerprint of a case at a scale; raises `PywetError` if the case cannot be built."""
    case, scale = config.case(number), config.scale(scale_name)
    made, spec = cases.ingredients(config, number, scale_name), cases.apparatus_spec(config, case, scale)
    scene = cases.assemble(config, case, scale, made, build_apparatus(spec))
    text = json.dumps([scene.model_dump(mode="json"), asdict(spec), _code(scene.effects.laws)], sort_keys=True)
    for law in sorted(set(scene.effects.laws.values())):
        if custom_laws.is_custom(law):  # the content of the file counts, not its path
            text = text.replace(json.dumps(law), _text(law))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def fingerprint_or_reason(config: Config, number: int, scale_name: str, preset: str | None = None) -> str:
    """Return the fingerprint of a case for the workflow, with another preset if given; the reason if a case cannot be built."""
    try:
        return identity(config.with_preset(preset) if preset else config, number, scale_name)
    except PywetError as error:
        return str(error)


def content(config: Config) -> str:
    """Return a fingerprint of the whole configuration, sources and reasons included, comments not."""
    parts = [
        m.model_dump(mode="json") for m in (config.settings, config.materials, config.scales, *config.cases.values())
    ]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def of(*parts: object) -> str:
    """Return the fingerprint of a run determined by these parts, which JSON can represent, and by the program's code."""
    return hashlib.sha256(json.dumps([*parts, _code(parts)], sort_keys=True).encode()).hexdigest()[:16]


def expect(run_dir: Path, word: str, file: Path) -> Path:
    """Write the fingerprint that a run must have into a file whose time tells Snakemake whether the run there has it.

    The file is as old as the run's identity.json if both agree; otherwise newer than the stage scene, regardless of the clock.
    """
    with suppress(OSError, UnicodeDecodeError):
        if file.read_text() == word:
            return _timed(run_dir, word, file)
    with atomic_write(file) as temporary:
        temporary.write_text(word)
    return _timed(run_dir, word, file)


def _timed(run_dir: Path, word: str, file: Path) -> Path:
    status = run_dir / "status" / "scene.json"
    if record.left_identity(run_dir) == word:
        when = (run_dir / record.IDENTITY).stat().st_mtime_ns
    else:
        when = max(time.time_ns(), status.stat().st_mtime_ns + 10**9 if status.exists() else 0)
    os.utime(file, ns=(when, when))
    return file


def _text(law: str) -> str:
    """Return the digest of a custom law's file, and the law's name in it."""
    path, _, name = law.rpartition(":")
    return name + hashlib.sha256(read_bytes(Path(path), custom_laws.CURE)).hexdigest()


def _code(parts: object) -> str:
    return sources.digest_of_a_run() + pywet.__version__ + registry.published_code(json.dumps(parts))
