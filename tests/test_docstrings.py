"""Docstrings of the public functions have the sections of numpydoc: parameters with units, returns, an example for a law."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import pytest

import pywet
from pywet.laws import exact_bridge, registry
from pywet.laws.kinds import KINDS
from pywet.runs.loaded import Run

SCENE = {name: of for name in pywet.__all__ if inspect.isfunction(of := getattr(pywet, name))}
SOLVER = {name: getattr(exact_bridge, name) for name in ("solve", "rupture")}
METHODS = {name: of for name, of in vars(Run).items() if inspect.isfunction(of) and not name.startswith("_")}
LAWS = {
    f"{kind}.{name}.{k}": law
    for kind in KINDS
    for name in registry.names(kind)
    for k, law in enumerate(registry.get(kind, name).functions)
    if kind != "transfer"
}


def sections(of: Any) -> dict[str, str]:
    """Title -> text of a docstring's sections; the summary has the title ''."""
    parts = re.split(r"\n([A-Z][a-z]+)\n-{4,}\n", "\n" + (inspect.getdoc(of) or ""))
    return {"": parts[0].strip(), **dict(zip(parts[1::2], parts[2::2], strict=True))}


@pytest.mark.parametrize(("name", "of"), [*SCENE.items(), *SOLVER.items(), *METHODS.items()])
def test_every_parameter_and_result_of_a_public_function_is_described(name: str, of: Callable[..., Any]) -> None:
    found, names = sections(of), [p for p in inspect.signature(of).parameters if p != "self"]
    assert len(found[""].split("\n")[0]) > 20 and found[""].split("\n")[0].endswith(".")
    assert re.findall(r"^(\w+) :", found.get("Parameters", ""), re.MULTILINE) == names
    assert "Returns" in found


@pytest.mark.parametrize(("name", "law"), LAWS.items())
def test_a_law_has_units_its_range_or_formula_and_a_number(name: str, law: Any) -> None:
    found = sections(law)
    shown = re.split(r"^(\w+) : .*$", found["Parameters"], flags=re.MULTILINE)
    assert shown[1::2] == list(inspect.signature(law).parameters)
    assert all("[" in text for text in shown[2::2])
    assert ">>>" in found["Examples"] and "Returns" in found and ("=" in found[""] or "Notes" in found)


def test_there_are_about_a_hundred_of_them() -> None:
    assert len(SCENE) + len(SOLVER) + len(METHODS) + len(set(LAWS.values())) >= 50
