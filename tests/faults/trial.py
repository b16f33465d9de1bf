"""One fault tried: a copy of the program with it runs the smallest moist case, and what the program says of it is the verdict."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.faults.mutants import Mutant

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pywet"
ROOMS: dict[str, tuple[str, ...]] = {
    "plugin": ("engines/liggghts/plugin/*.cpp", "engines/liggghts/plugin/*.h"),
    "laws": tuple(
        f"laws/{name}.py"
        for name in ("capillary", "capillary_fits", "contact", "formation", "rupture", "transfer", "viscous")
    ),
    "driver": ("engines/schedule.py", "engines/liggghts/*.py", "engines/liggghts/*.j2", "runs/*.py"),
    "scene": (
        "screening/cases.py",
        "screening/amounts.py",
        "apparatus/*.py",
        "config/materials.py",
        "config/scales.py",
    ),
    "results": ("screening/results.py", "screening/summary.py"),
    "view": ("report/vtk.py",),
}
"""Room -> its files, below pywet/."""
TESTS = {
    "plugin": ["tests/engines/liggghts"], "laws": ["tests/laws"], "driver": ["tests/engines", "tests/runs"],
    "scene": ["tests/screening", "tests/apparatus", "tests/test_config.py"], "results": ["tests/screening"],
    "view": ["tests/report"],
}  # fmt: skip
"""Room -> the tests that are asked where the program itself says nothing."""
SMALL = {
    "width_mm: {value: 50": "width_mm: {value: 40", "duration_s: {value: 1.6": "duration_s: {value: 0.3",
    "slide_opens_at_s: {value: 0.2": "slide_opens_at_s: {value: 0.1",
}  # fmt: skip
"""What makes the smoke scale's case 2 a matter of seconds."""
STEADY = (
    "history/*.parquet",
    "*.parquet",
    "results/*.parquet",
    "scene.json",
    "stl/*",
    "vtk/*.vtu",
    "vtk/*.vtp",
    "vtk/*.vtk",
)
"""Files that are the same in every run without a fault."""
LIMIT_S = 900.0


@dataclass(frozen=True)
class Verdict:
    """`by`: replay, program (it stopped, with a sentence), tests, no effect, survives; `said`: in which words."""

    by: str
    said: str = ""


def files(room: str) -> list[Path]:
    """Files of a room that there are."""
    return sorted(p for pattern in ROOMS[room] for p in PACKAGE.glob(pattern))


def copy(folder: Path, mutant: Mutant | None = None) -> Path:
    """The program in a folder of its own, with the fault; its configuration is small."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(PACKAGE, folder / "pywet", ignore=shutil.ignore_patterns("__pycache__"))
    for name in (
        "reference_impl",
        "liggghts_inputs",
        "workflow",
        "tests",
        "docs",
        "examples",
        "pyproject.toml",
        "README.md",
    ):
        (folder / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "config", folder / "config")
    scales = folder / "config" / "scales.yaml"
    text = scales.read_text()
    for old, new in SMALL.items():
        head, smoke, tail = text.partition("  smoke:")
        text = head + smoke + tail.replace(old, new, 1)
    scales.write_text(text)
    settings = folder / "config" / "config.yaml"
    settings.write_text(settings.read_text().replace("energy: false", "energy: true"))
    if mutant is not None:
        (folder / mutant.path.relative_to(ROOT)).write_text(mutant.text)
    return folder


def pywet(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """A command of the program in a folder."""
    return call(folder, [sys.executable, "-m", "pywet.cli.app", *arguments])


def call(folder: Path, command: list[str]) -> subprocess.CompletedProcess[str]:
    """A command in a folder, with the program of that folder and a cache of the trials' own."""
    cache = str(folder.parent / "cache")
    environment = {**os.environ, "PYTHONPATH": str(folder), "NO_COLOR": "1", "COLUMNS": "250", "PYWET_CACHE": cache}
    try:
        return subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=LIMIT_S
        )
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess(command, 1, "", f"no end within {LIMIT_S:.0f} s")


def run(folder: Path) -> subprocess.CompletedProcess[str]:
    """The smallest moist case, its replay, results and time series."""
    done = pywet(folder, "run", "2", "--scale", "smoke", "--out", "run")
    return done if done.returncode else pywet(folder, "view", "run")


def marks(folder: Path) -> dict[str, str]:
    """Hashes of all that a run without a fault always leaves alike."""
    found = {p for pattern in STEADY for p in (folder / "run").glob(pattern)}
    return {str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(found)}


def compiles(folder: Path, mutant: Mutant) -> bool:
    """Whether the fault is one of meaning, not of grammar."""
    if mutant.path.suffix == ".py":
        try:
            compile(mutant.text, str(mutant.path), "exec")
        except SyntaxError:
            return False
    if mutant.path.suffix in (".cpp", ".h"):
        return (
            call(
                folder, [sys.executable, "-c", "from pywet.engines.liggghts import build; build.plugin_path()"]
            ).returncode
            == 0
        )
    return True


def judge(folder: Path, room: str, sound: dict[str, str], ask_tests: bool) -> Verdict:
    """Run the copy and say who noticed."""
    done = run(folder)
    replayed = folder / "run" / "replay.json"
    if replayed.exists():
        content = json.loads(replayed.read_text())
        if not content["ok"]:
            return Verdict("replay", _words(content))
    if done.returncode:
        return Verdict("program", (done.stderr.strip().splitlines() or ["it ended without a word"])[-1][:200])
    if marks(folder) == sound:
        return Verdict("no effect")
    if ask_tests:
        for place in TESTS[room]:
            tested = call(
                folder, [sys.executable, "-m", "pytest", "-x", "-q", "-m", "not slow", "-p", "no:cacheprovider", place]
            )
            if tested.returncode:
                return Verdict(
                    "tests", next((w for w in tested.stdout.splitlines() if w.startswith("FAILED")), place)[:200]
                )
    changed = [name for name, mark in marks(folder).items() if sound.get(name) != mark]
    return Verdict("survives", f"changes {', '.join(changed[:4])}")


def _words(content: dict[str, object]) -> str:
    """What the replay says: its diagnosis, else the quantities beyond their limits."""
    said = content.get("diagnosis")
    if said:
        return json.dumps(said, ensure_ascii=False)[:300]
    quantities = content.get("quantities")
    assert isinstance(quantities, dict)
    return ", ".join(name for name, q in quantities.items() if isinstance(q, dict) and q.get("ok") is False)
