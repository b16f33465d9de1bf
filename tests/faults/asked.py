"""What the tests say of faults that the program itself does not notice: those that import the changed module, in turn."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.faults.mutants import Mutant, code, mutants
from tests.faults.packages import PACKAGE, ROOT, below
from tests.faults.trial import Bench

LIMIT_S = 600.0
OF_PLUGIN = (*(f"tests/engines/liggghts/test_{name}.py" for name in (
    "two_bodies", "wires", "energy", "records", "restart", "invariance", "semi_implicit", "shedding", "liquid_weight", "impulses",
    "window_dumps", "grid", "failures", "ranks", "exact_in_engine", "dry", "contacts", "retirement")),
    "tests/products/test_outlets.py", "tests/test_sound_runs.py")  # fmt: skip
"""No test imports the plugin's sources; the quick ones first."""


def again(row: dict[str, str], package: Path = PACKAGE) -> Mutant | None:
    """The fault of a row of the table: the same change of the same line of code; None where the program has it no longer."""
    path = package / row["file"]
    text = path.read_text() if path.exists() else ""
    same = [m for m in mutants(path) if m.what == row["what"] and code(text, m.line) == row["code"]] if text else []
    return min(same, key=lambda m: abs(m.line - int(row["line"])), default=None)


def tests_of(name: str) -> list[str]:
    """Test files that import a module, given by its file below pywet/, that named after it first; else its package's."""
    path = PACKAGE / name
    if path.suffix != ".py":
        return list(OF_PLUGIN)
    package, stem = ".".join(path.relative_to(ROOT).parent.parts), path.stem
    uses = re.compile(rf"from {re.escape(package)} import [^\n]*\b{stem}\b|{re.escape(package)}\.{stem}\b")
    named = [p for p in sorted((ROOT / "tests").rglob("test_*.py")) if uses.search(p.read_text())]
    named = named or sorted((ROOT / "tests" / path.relative_to(PACKAGE).parent).glob("test_*.py"))
    named.sort(key=lambda p: (p.stem != f"test_{stem}", stem not in p.stem, p.stat().st_size))
    return [str(p.relative_to(ROOT)) for p in named]


def ask(bench: Bench, mutant: Mutant, tests: Sequence[str] = (), engine: bool = True) -> str | None:
    """The first test that fails with the fault, of some or of all that know the module; None where there is none."""
    named = tests or tests_of(below(mutant.path))
    if not named:
        return None
    which = "not slow" if engine or mutant.path.suffix != ".py" else "not slow and not engine"
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-m", which, "-p", "no:cacheprovider",
             "--basetemp", str(bench.out / "asked"), *named]  # fmt: skip
    environment = {**os.environ, "PYTHONPATH": str(bench.tree), "PYTHONDONTWRITEBYTECODE": "1"}
    with bench.injected(mutant):
        _keep_plugin(bench, mutant)
        try:
            done = subprocess.run(
                words, cwd=bench.tree, env=environment, capture_output=True, text=True, check=False, timeout=LIMIT_S
            )
        except subprocess.TimeoutExpired:
            return None
    if done.returncode == 0:
        return None
    lines = done.stdout.splitlines()
    failed = next((w for w in lines if w.startswith(("FAILED", "ERROR"))), lines[-1] if lines else "it does not start")
    return failed[:200]


def _keep_plugin(bench: Bench, mutant: Mutant) -> None:
    """Copy the plugin to where the tests look for it, since compiling takes long."""
    from pywet.engines.liggghts import build
    from pywet.util import caches

    if (library := bench.plugin(mutant)) and library.exists():
        shutil.copy(library, build.cached())
        caches.seal(build.cached())
