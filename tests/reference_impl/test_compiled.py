"""Loops of the reference that numba keeps: never with another file's code in them, and made again where nothing can be stored."""

from __future__ import annotations

import ast
import importlib
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest
from numba.core import caching
from numba.extending import is_jitted

import reference_impl
from reference_impl.compiled import compiled

ROOT = Path(reference_impl.__file__).parent


def test_what_is_compiled_into_a_stored_function_stands_in_its_file() -> None:
    """numba looks for changes in that file alone."""
    stored = 0
    for path in ROOT.rglob("*.py"):
        if "@compiled" not in path.read_text():
            continue
        imports = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.ImportFrom)]
        ours = {n.asname or n.name for i in imports if (i.module or "").startswith("reference_impl") for n in i.names}
        module = importlib.import_module(".".join(("reference_impl", *path.relative_to(ROOT).with_suffix("").parts)))
        for name, value in vars(module).items():
            if not is_jitted(value):
                continue
            assert value.py_func.__module__ == module.__name__, name
            used = set(value.py_func.__code__.co_names)
            assert not used & ours, f"{name} takes {used & ours} from another file"
            plain = [n for n in used if isinstance(vars(module).get(n), FunctionType)]
            assert not plain, f"{name} calls {plain}, not compiled"
            stored += 1
    assert stored >= 10


def test_where_nothing_can_be_stored_it_is_compiled_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: Any) -> None:
        return None

    for locator in caching.CacheImpl._locator_classes:
        monkeypatch.setattr(locator, "from_function", nowhere)

    def half(x: float) -> float:
        return x / 2.0

    made = compiled(half)
    assert made(3.0) == 1.5
    assert made._cache.cache_path is None
