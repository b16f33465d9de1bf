"""The copy of the program that trials work in, and the small scenes that they run."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

from tests.faults.packages import ROOT

COPIED = ("pywet", "config", "reference_impl", "liggghts_inputs")
"""What trials run: the program itself may change meanwhile."""
NEEDED = ("workflow", "tests", "docs", "examples", "pyproject.toml", "README.md",
          "constraints.txt", "Makefile", "Snakefile", "setup.py", "MANIFEST.in", "tools", "benchmarks",
          "CHANGELOG.md")  # fmt: skip
SMALL = {
    "width_mm: {value: 50": "width_mm: {value: 40", "duration_s: {value: 1.6": "duration_s: {value: 0.2",
    "slide_opens_at_s: {value: 0.2": "slide_opens_at_s: {value: 0.08",
}  # fmt: skip
"""What makes the smoke scale's case 2 a matter of seconds."""
SETTINGS = {"energy: false": "energy: true", "checkpoints: 20": "checkpoints: 3"}
OTHER = {"viscous_integration: explicit": "viscous_integration: semi_implicit", "liquid_weight: auto": "liquid_weight: on",
         "shedding: auto": "shedding: on"}  # fmt: skip
"""Settings of a second scene, for lines that the first does not come to; its wires are analytic."""
RARE = {"bridges_every: 1": "bridges_every: 2"}
SCENES: dict[str, dict[str, str]] = {"paper": {}, "other": OTHER, "rare": RARE}


def sources() -> str:
    """Hash over all that a sound run follows from."""
    digest = hashlib.sha256()
    for name in COPIED:
        for path in sorted(p for p in (ROOT / name).rglob("*") if p.is_file() and p.suffix != ".pyc"):
            digest.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return digest.hexdigest()


def copy(folder: Path) -> None:
    """The program in a folder of its own."""
    shutil.rmtree(folder, ignore_errors=True)
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in NEEDED:
        (folder / name).symlink_to(ROOT / name)


def configure(config: Path, scene: str) -> None:
    """The configuration of a scene: small, and with its settings; `KIND=LAW` is the first scene with another law."""
    shutil.rmtree(config, ignore_errors=True)
    shutil.copytree(ROOT / "config", config)
    scales, settings = config / "scales.yaml", config / "config.yaml"
    head, smoke, tail = scales.read_text().partition("  smoke:\n")
    for old, new in SMALL.items():
        tail = tail.replace(old, new, 1)
    scales.write_text(head + smoke + ("    wires: analytic\n" if scene == "other" else "") + tail)
    kind, _, law = scene.partition("=")
    text = settings.read_text()
    for old, new in (
        SETTINGS | (SCENES[scene] if not law else {"preset: paper ": f"{kind}: {law}\n  preset: paper "})
    ).items():
        if old not in text:
            raise SystemExit(f"config.yaml has no {old!r} any more: fix tests/faults/scenes.py")
        text = text.replace(old, new, 1)
    settings.write_text(text)
