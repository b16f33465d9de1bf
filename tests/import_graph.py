"""Who imports whom in pywet, read from its source; `python -m tests.import_graph` prints the drawing of docs/ARCHITECTURE.md."""

from __future__ import annotations

import ast
from collections.abc import Callable
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parents[1]
Graph = dict[str, set[str]]
"""Module or package -> all that it imports of the graph."""


def modules(root: Path = ROOT, package: str = "pywet") -> Graph:
    """Every module with what it imports, inside functions and by a name written out too; a package means its `__init__`."""
    paths = {_name(path.relative_to(root)): path for path in (root / package).rglob("*.py")}
    imported = {name: _imported(path, set(paths)) - {name} for name, path in paths.items()}
    return imported


def _name(path: Path) -> str:
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(path: Path, known: set[str]) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            names |= {word.value for word in node.args if isinstance(word, ast.Constant)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {name if name in known else node.module for name in whole}
    return names & known


def packages(graph: Graph) -> Graph:
    """Return the imports among packages and modules directly below `pywet`."""
    of: Callable[[str], str] = lambda name: ".".join(name.split(".")[1:2])  # noqa: E731
    joined: Graph = {}
    for name, imported in graph.items():
        joined.setdefault(of(name), set()).update(of(other) for other in imported if of(other) != of(name))
    return {package: others - {""} for package, others in joined.items() if package}


def circle(graph: Graph) -> list[str]:
    """One circle of imports, empty where there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def direct(graph: Graph) -> Graph:
    """Without the arrows that a longer path implies; of a graph without circles."""
    beyond: Graph = {}
    for package in TopologicalSorter(graph).static_order():
        beyond[package] = set().union(*(beyond[other] | {other} for other in graph[package]))
    return {
        package: {o for o in others if not any(o in beyond[p] for p in others)} for package, others in graph.items()
    }


def mermaid(graph: Graph) -> str:
    """A drawing of a graph without circles: a package is above those it imports, with the arrows that are `direct`."""
    lines = ["graph TD"]
    for package, others in sorted(direct(graph).items()):
        lines += [f"    {package} --> {' & '.join(sorted(others))}"] if others else []
    return "\n".join(lines)


if __name__ == "__main__":
    drawn = packages(modules())
    print(mermaid(drawn), f"{len(drawn)} packages, {sum(map(len, drawn.values()))} arrows", sep="\n\n")
