"""What the tests say of faults that the program itself does not notice: those that import the changed module, in turn."""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
from pathlib import Path

from tests.faults import trial
from tests.faults.mutants import Mutant, draw

LIMIT_S = 600.0
PLUGIN = ("tests/engines/liggghts",)
"""No test imports the plugin's sources."""


def again(row: dict[str, str], seed: int) -> Mutant:
    """The fault of a row of the table, drawn once more."""
    chance = random.Random(f"{seed} {row['room']} {row['number']}")
    while True:
        mutant = draw(trial.files(row["room"]), chance)
        name = str(mutant.path.relative_to(trial.PACKAGE))
        if (name, str(mutant.line), mutant.what) == (row["file"], row["line"], row["what"]):
            return mutant


def tests_of(path: Path) -> list[str]:
    """Test files that import a module, the one named after it first."""
    if path.suffix != ".py":
        return list(PLUGIN)
    package, name = ".".join(path.relative_to(trial.ROOT).parent.parts), path.stem
    uses = re.compile(rf"from {re.escape(package)} import [^\n]*\b{name}\b|{re.escape(package)}\.{name}\b")
    found = [p for p in sorted((trial.ROOT / "tests").rglob("test_*.py")) if uses.search(p.read_text())]
    found.sort(key=lambda p: (p.stem != f"test_{name}", name not in p.stem, p.stat().st_size))
    return [str(p.relative_to(trial.ROOT)) for p in found]


def ask(tree: Path, mutant: Mutant) -> str | None:
    """The first test that fails with the fault; None where none does, or there is none."""
    named = tests_of(mutant.path)
    if not named:
        return None
    place = tree / mutant.path.relative_to(trial.ROOT)
    before = place.read_text()
    place.write_text(mutant.text)
    words = [
        sys.executable,
        "-m",
        "pytest",
        "-x",
        "-q",
        "-m",
        "not slow",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:randomly",
    ]
    words += ["--basetemp", str(tree.parent / "asked"), *named]
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            words, cwd=tree, env=environment, capture_output=True, text=True, check=False, timeout=LIMIT_S
        )
    except subprocess.TimeoutExpired:
        return None
    finally:
        place.write_text(before)
    if done.returncode == 0:
        return None
    lines = done.stdout.splitlines()
    return next((w for w in lines if w.startswith(("FAILED", "ERROR"))), lines[-1] if lines else "it does not start")[
        :200
    ]
