"""Loops of the reference that numba keeps: never with another file's code in them, and made anew where nothing can be kept."""

from __future__ import annotations

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


def test_what_is_compiled_into_a_kept_function_stands_in_its_file() -> None:
    """numba looks for changes in that file alone."""
    kept = 0
    for path in ROOT.rglob("*.py"):
        if "@compiled" not in path.read_text():
            continue
        module = importlib.import_module(".".join(("reference_impl", *path.relative_to(ROOT).with_suffix("").parts)))
        for name, value in vars(module).items():
            if not is_jitted(value):
                continue
            assert value.py_func.__module__ == module.__name__, name
            used = {n: vars(module)[n] for n in value.py_func.__code__.co_names if n in vars(module)}
            of_us = [n for n, v in used.items() if getattr(v, "__name__", "").startswith("reference_impl")]
            assert not of_us, f"{name} takes from {of_us}"
            assert not [n for n, v in used.items() if isinstance(v, FunctionType)], f"{name} calls what is not compiled"
            kept += 1
    assert kept >= 10


def test_where_nothing_can_be_kept_it_is_compiled_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: Any) -> None:
        return None

    for locator in caching.CacheImpl._locator_classes:
        monkeypatch.setattr(locator, "from_function", nowhere)

    def half(x: float) -> float:
        return x / 2.0

    made = compiled(half)
    assert made(3.0) == 1.5
    assert made._cache.cache_path is None
