"""User reference implementations of custom laws, with which the replay recomputes terms otherwise taken as logged.

They are given as `path/to/file.py:function`, with the arguments of the law as numbers; at a wall radius_j is
infinite. The file must not import pywet, since functions that share a helper are not independent. A law of two parts
(viscous_tangential) has one function that returns both.
"""

from __future__ import annotations

import ast
import runpy
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.replay import capillary, coverage, io, laws
from reference_impl.replay.io import ReplayError
from reference_impl.replay.laws import Flags, Floats

Function = Callable[..., Any]
TABLES: dict[str, dict[str, Any]] = {
    "capillary": capillary.LAWS,
    "viscous_normal": laws.VISCOUS_NORMAL,
    "viscous_tangential": laws.VISCOUS_TANGENTIAL,
    "rupture": laws.RUPTURE,
}
"""Kinds with user reference implementations -> dictionary of laws in the replay."""


@contextmanager
def known(folder: Path, functions: Mapping[str, str]) -> Iterator[None]:
    """Make these functions known to the replay of a run, a name for each kind, within the context."""
    effects, put = io.scene(folder)["effects"], []
    try:
        for kind, name in functions.items():
            law = effects.get(kind)
            if kind not in TABLES:
                raise ReplayError(f"{name} is for {kind}; expected one for {', '.join(TABLES)}")
            if law is None or law in TABLES[kind]:
                continue  # the effect is off, or the law is built in
            TABLES[kind][law] = _with_walls(kind, _in_numbers(kind, name))
            coverage.CLOSED[kind].add(law)
            put.append((kind, law))
        yield
    finally:
        for kind, law in put:
            del TABLES[kind][law]
            coverage.CLOSED[kind].discard(law)


def _in_numbers(kind: str, name: str) -> Function:
    """Return the file's function, called for one bridge after the other."""
    function = _load(name)

    def one(*values: float) -> Any:
        try:
            return function(*map(float, values))
        except Exception as error:
            raise ReplayError(
                f"{name} raises {type(error).__name__} ({error}) for {', '.join(f'{v:g}' for v in values)}; fix its file"
            ) from error

    return np.vectorize(one, otypes=[float, float] if kind == "viscous_tangential" else [float])


def _load(name: str) -> Function:
    path, _, attribute = name.rpartition(":")
    try:
        imported = {word for node in ast.walk(ast.parse(Path(path).read_bytes())) for word in _imports(node)}
        if "pywet" in imported:
            raise ReplayError(
                f"{path} imports pywet; expected a user reference implementation that shares nothing with the law"
            )
        function = runpy.run_path(path).get(attribute)
    except ReplayError:
        raise
    except (Exception, SystemExit) as error:
        raise ReplayError(f"{name} cannot be loaded ({error!r}); expected path/to/file.py:function") from error
    if not callable(function):
        raise ReplayError(f"{path} has no function {attribute}; expected path/to/file.py:function")
    return function  # type: ignore[no-any-return]


def _imports(node: ast.AST) -> list[str]:
    """Return the top-level modules that a statement imports."""
    if isinstance(node, ast.Import):
        return [alias.name.split(".")[0] for alias in node.names]
    return [node.module.split(".")[0]] if isinstance(node, ast.ImportFrom) and node.module else []


def _with_walls(kind: str, f: Function) -> Function:
    """Adapt the function to the calls of its kind in the replay: a flag marks a wall, whose radius_j is a dummy."""

    def outer(rj: Floats, wall: Flags) -> Floats:
        return np.where(wall, np.inf, rj)

    if kind == "capillary":
        return lambda s, v, ri, rj, wall, ti, tj, sigma: f(s, v, ri, outer(rj, wall), ti, tj, sigma)
    if kind == "viscous_normal":
        return lambda s, v, ri, rj, wall, vn, eta: f(s, v, ri, outer(rj, wall), vn, eta)
    if kind == "viscous_tangential":
        return lambda s, ri, rj, wall, eta: f(s, ri, outer(rj, wall), eta)
    return lambda v, ri, rj, wall, ti, tj: f(v, ri, outer(rj, wall), ti, tj)
