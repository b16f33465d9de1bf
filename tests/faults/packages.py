"""Packages of the program that faults are drawn from, their files, and which run comes to a line of them."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.faults.mutants import Mutant

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pywet"
PACKAGES: dict[str, tuple[str, ...]] = {
    "plugin": ("engines/liggghts/plugin/*.cpp", "engines/liggghts/plugin/*.h"),
    "laws": tuple(
        f"laws/{name}.py"
        for name in ("capillary", "capillary_fits", "contact", "formation", "rupture", "transfer", "viscous")
    ),
    "driver": (
        "engines/schedule.py",
        "engines/pipeline.py",
        "engines/run_store.py",
        "engines/liggghts/*.py",
        "engines/liggghts/*.j2",
        "runs/*.py",
    ),
    "scene": (
        "cases/screening/cases.py",
        "cases/screening/amounts.py",
        "geometry/*.py",
        "config/materials.py",
        "config/scales.py",
    ),
    "results": ("cases/screening/results.py",),
    "view": ("report/vtk.py",),
    "planning": ("planning/*.py",),
    "custom": ("cases/custom/*.py", "products/feed.py", "products/deck.py", "products/size_classes.py"),
    "calibration": ("calibration/*.py",),
}
"""Module -> its files, below pywet/."""
LEFT_OUT = ("build.py",)
"""Trials have the plugin compiled in a way of their own."""
BUILT = ("planning", "custom", "calibration")
"""Modules whose faults run no engine: inputs are built and compared with their description, then tests are asked."""
AFTER = ("results", "view")
"""Modules that work on a finished run."""


def files(module: str, package: Path = PACKAGE) -> list[Path]:
    """Existing files of a module."""
    return sorted(p for pattern in PACKAGES[module] for p in package.glob(pattern) if p.name not in LEFT_OUT)


def below(path: Path) -> str:
    """A file's name below pywet/, of whatever copy it is."""
    return str(Path(*path.parts[len(path.parts) - path.parts[::-1].index("pywet") :]))


def reached(lines: set[int], mutant: Mutant, beside: int = 0) -> bool:
    """Return whether a run comes to the statement of the fault (in C++ to lines at most so far from it).

    Where lines do not tell: to its file.
    """
    if mutant.path.suffix != ".py":
        return bool(lines & {*range(mutant.line - beside, mutant.line + beside + 1)})
    inner = [n for n in ast.walk(ast.parse(mutant.path.read_text())) if isinstance(n, ast.stmt)
             and n.lineno <= mutant.line <= (n.end_lineno or n.lineno)]  # fmt: skip
    if not inner:
        return bool(lines)
    smallest = min(inner, key=lambda n: (n.end_lineno or n.lineno) - n.lineno)
    return any(smallest.lineno <= line <= (smallest.end_lineno or smallest.lineno) for line in lines)


def law_of(mutant: Mutant) -> tuple[str, str] | None:
    """Kind and name of the law whose function holds the fault, or that calls the one that does."""
    functions = {n.name: n for n in ast.parse(mutant.path.read_text()).body if isinstance(n, ast.FunctionDef)}
    ahead = [name for name, f in functions.items() if f.lineno <= mutant.line <= (f.end_lineno or 0)]
    for name in ahead:  # grows
        if law := _law(functions[name]):
            return law
        ahead += [other for other, f in functions.items() if other not in ahead and _names(f, name)]
    return None


def _law(function: ast.FunctionDef) -> tuple[str, str] | None:
    for mark in function.decorator_list:
        if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "force_law" and mark.args:
            words = [str(ast.literal_eval(a)) for a in mark.args]
            return words[0], words[1] if len(words) > 1 else function.name
    return None


def _names(function: ast.FunctionDef, name: str) -> bool:
    return any(isinstance(n, ast.Name) and n.id == name for n in ast.walk(function))
