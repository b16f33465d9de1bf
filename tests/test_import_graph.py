"""The imports of pywet run one way, and docs/ARCHITECTURE.md draws them as they are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.import_graph import ROOT, circle, direct, mermaid, modules, packages

PAGE = (ROOT / "docs" / "ARCHITECTURE.md").read_text()
GRAPH = modules()
HOMES = re.findall(r"^\| [^|`]+ \| `([^`:]+\.\w+)(?::(\w+))?`", PAGE, re.MULTILINE)
"""The rows of "Where does it live": file, and the name in it."""


def test_no_module_imports_itself_by_a_detour() -> None:
    assert circle(GRAPH) == []
    assert circle(packages(GRAPH)) == []


def test_the_program_imports_nothing_of_the_studies() -> None:
    """A wheel has no `studies`: one command and the workflow open them, and nothing else in `pywet` names them."""
    named = {
        str(path.relative_to(ROOT))
        for path in (ROOT / "pywet").rglob("*.py")
        if re.search(r"(?:import|from) studies\b|[\"']studies[.\"']", path.read_text())
    }
    assert named == {"pywet/cli/evidence.py", "pywet/shipped.py"}
    studies = modules(package="studies")
    assert len(studies) > 70 and circle(studies) == []


def test_a_circle_would_be_noticed(tmp_path: Path) -> None:
    texts = {
        "__init__": "",
        "a": "def f():\n    from pywet.b import c\n",
        "b": "import pywet.a\n",
        "d": "import_module('pywet.a')\n",
    }
    (tmp_path / "pywet").mkdir()
    for name, text in texts.items():
        (tmp_path / "pywet" / f"{name}.py").write_text(text)
    graph = modules(tmp_path)
    assert graph == {"pywet": set(), "pywet.a": {"pywet.b"}, "pywet.b": {"pywet.a"}, "pywet.d": {"pywet.a"}}
    assert sorted(set(circle(graph))) == ["pywet.a", "pywet.b"]


def test_the_drawing_leaves_out_what_a_longer_way_says() -> None:
    assert direct({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": {"b"}, "b": {"c"}, "c": set()}


def test_the_drawing_is_that_of_the_code() -> None:
    wanted = mermaid(packages(GRAPH))
    assert f"```mermaid\n{wanted}\n```" in PAGE, f"put this into docs/ARCHITECTURE.md:\n{wanted}"
    assert f"The {len(packages(GRAPH))} packages import each other without cycles." in PAGE


@pytest.mark.parametrize(("file", "name"), HOMES)
def test_what_is_looked_for_is_where_the_page_says(file: str, name: str) -> None:
    text = (ROOT / file).read_text()
    assert not name or re.search(rf"^\s*(?:def|class) {name}\b|^{name}\b.* =|^@\w+\(\"{name}\"", text, re.MULTILINE)


def test_ten_things_are_looked_for() -> None:
    assert len(HOMES) == 10


def test_every_file_that_the_page_names_is_there() -> None:
    paths = [
        path.relative_to(ROOT)
        for package in ("pywet", "studies", "reference_impl", "tests")
        for path in (ROOT / package).rglob("*")
    ]
    named = set(re.findall(r"`([\w./]+\.(?:py|cpp|h))`", PAGE))
    assert len(named) > 40
    assert {name for name in named if not any(f"/{path}".endswith(f"/{name}") for path in paths)} == set()
