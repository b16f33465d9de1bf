"""The kit that plants faults by chance: what it changes, and how it counts."""

from __future__ import annotations

import os
import random
import re
import sys
from pathlib import Path
from typing import Any

from tests.faults import asked, packages, page, reach, server
from tests.faults.__main__ import read, score
from tests.faults.mutants import Mutant, code, draw, mutants

PYTHON = '''"""Text + 1 (a, b)."""
import math  # a + b


def area(x: float, y: float) -> float:
    # 2 * x
    total = min(x, y) + 2.5 * x
    total += hypot(x, y)
    return total
'''


def changes(path: Path) -> dict[str, str]:
    return {f"{m.line}: {m.what}": m.text for m in mutants(path)}


def test_operators_constants_arguments_and_lines_are_changed_and_comments_are_not(tmp_path: Path) -> None:
    path = tmp_path / "area.py"
    path.write_text(PYTHON)
    made = changes(path)
    assert {"7: + -> -", "7: * -> /", "7: 2.5 -> 2.525", "7: min -> max", "7: (x, y) -> (y, x)", "8: += -> -=",
            "8: dropped: total += hypot(x, y)"} <= set(made)  # fmt: skip
    assert not any("dropped: total = " in w for w in made)
    assert not {w for w in made if w.startswith(("1:", "2:", "5:", "6:"))}
    assert "total = min(x, y) - 2.5 * x" in made["7: + -> -"] and "Text + 1 (a, b)." in made["7: + -> -"]
    assert "    pass\n    return total" in made["8: dropped: total += hypot(x, y)"]


def test_cpp_is_changed_alike(tmp_path: Path) -> None:
    path = tmp_path / "force.cpp"
    path.write_text("// a + b\nvoid f(int i) {\n  force[i] += k * overlap[0] * i;\n}\n")
    assert set(changes(path)) == {"2: i -> j", "3: i -> j", "3: i -> j (2)", "3: += -> -=", "3: * -> /", "3: * -> / (2)",
                                  "3: 0 -> 1", "3: dropped: force[i] += k * overlap[0] * i;"}  # fmt: skip


def test_the_same_seed_draws_the_same_faults() -> None:
    one, two = (draw(packages.files("plugin"), random.Random(7)) for _ in range(2))
    assert one == two


def test_every_package_has_files_and_their_tests() -> None:
    for module in packages.PACKAGES:
        names = [packages.below(path) for path in packages.files(module)]
        assert names and all((packages.ROOT / place).exists() for name in names for place in asked.tests_of(name))
    assert asked.tests_of("report/vtk.py")[0] == "tests/report/test_vtk.py"


def test_a_fault_of_a_helper_is_one_of_the_law_that_calls_it(tmp_path: Path) -> None:
    path = tmp_path / "laws.py"
    path.write_text("def one(x):\n    return x\n\n\n@force_law('capillary')\ndef two(x):\n    return one(x)\n")
    assert [packages.law_of(Mutant(path, line, "", "")) for line in (2, 7, 4)] == [("capillary", "two")] * 2 + [None]


def test_crashes_and_faults_without_effect_do_not_count() -> None:
    rows = [{"package": "plugin", "by": by} for by in ("replay", "replay", "tests", "survives", "no effect", "crash")]
    assert score(rows)[1].split() == ["plugin", "6", "1", "1", "2", "0", "1", "0", "1", "75%"]


def test_a_fault_is_made_again_from_its_row_after_the_file_was_edited(tmp_path: Path) -> None:
    """Found by its line of code in its function, whatever lines with the same change are nearer; else not at all."""
    path, other = tmp_path / "area.py", "def volume(x, y):\n    total = x + y\n    total = x - z + y\n\n\n"
    path.write_text("def area(x, y):\n    total = x + y\n")
    (mutant,) = (m for m in mutants(path) if m.what == "+ -> -")
    row = {"file": path.name, "line": "2", "what": mutant.what, "code": code(path.read_text(), mutant.line)}
    assert row["code"] == "def area: total = x + y" and asked.again(row, tmp_path) == mutant
    path.write_text(other + path.read_text())
    found = asked.again(row, tmp_path)
    assert found and (found.line, found.text) == (7, other + mutant.text)
    path.write_text(path.read_text().replace("area", "side"))
    assert asked.again(row, tmp_path) is None and asked.again({**row, "file": "volume.py"}, tmp_path) is None


def test_what_imports_a_changed_module_is_forgotten() -> None:
    """With what imports that; nothing else."""
    import pywet.report.vtk as vtk
    import pywet.runs.rundir as rundir

    names = ("pywet.runs.rundir", "pywet.report.vtk", "pywet.scene")
    stored = {name: sys.modules[name] for name in list(sys.modules) if name.startswith("pywet")}
    try:
        server.forget("pywet.runs.rundir", packages.ROOT)
        assert [name in sys.modules for name in names] == [False, False, True]
    finally:
        sys.modules.update(stored)
        sys.modules["pywet.runs"].rundir = rundir  # type: ignore[attr-defined]
        sys.modules["pywet.report"].vtk = vtk  # type: ignore[attr-defined]


def test_the_answer_of_a_copy_and_how_it_ended() -> None:
    assert server.in_copy(lambda: {"by": "replay"}, 60.0) == {"by": "replay"}
    assert "ZeroDivisionError" in server.in_copy(lambda: {"by": str(1 // 0)}, 60.0)["crash"]
    assert server.in_copy(lambda: os.kill(os.getpid(), 9) or {}, 60.0) == {"crash": "signal 9"}


def test_lines_that_a_run_comes_to(tmp_path: Path) -> None:
    """Compare the recorded lines of a small file with those that are executed."""
    path = tmp_path / "way.py"
    path.write_text("def way(x):\n    if x:\n        return 1\n    return 2\n")
    space: dict[str, Any] = {}
    exec(compile(path.read_text(), str(path), "exec"), space)
    with reach.traced(tmp_path) as lines:
        space["way"](False)
        reach.keep(tmp_path / "stored.json")
    assert lines == reach.recorded(tmp_path / "stored.json") == {"way.py": {1, 2, 4}}
    assert [packages.reached(lines["way.py"], Mutant(path, line, "", "")) for line in (2, 3, 4)] == [True, False, True]
    assert [packages.reached({7}, Mutant(Path("a.h"), 8, "", ""), beside) for beside in (0, 1)] == [False, True]


def test_the_page_is_that_of_the_stored_table() -> None:
    """Every change that nobody noticed has its reason."""
    rows = read(page.STORED)
    assert page.PAGE.read_text() == page.page(rows)
    assert read(page.UNFOUND) == page.unfound(rows)
    assert all(row[page.WHY] for row in rows if page.verdict(row) in ("equivalent", "open"))
    assert [
        row["message"] for row in rows if re.search(r"(?<![\w.])/\w+/", row["message"])
    ] == []  # folders of a machine
