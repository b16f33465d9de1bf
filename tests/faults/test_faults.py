"""The kit that plants faults by chance: what it changes, and how it counts."""

from __future__ import annotations

import random
from pathlib import Path

from tests.faults import trial
from tests.faults.__main__ import score
from tests.faults.mutants import draw, mutants

PYTHON = '''"""Text + 1."""
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
    assert "total = min(x, y) - 2.5 * x" in made["7: + -> -"] and "Text + 1." in made["7: + -> -"]
    assert "    pass\n    return total" in made["8: dropped: total += hypot(x, y)"]


def test_cpp_is_changed_alike(tmp_path: Path) -> None:
    path = tmp_path / "force.cpp"
    path.write_text("// a + b\nvoid f(int i) {\n  force[i] += k * overlap[0];\n}\n")
    assert set(changes(path)) == {"2: i -> j", "3: i -> j", "3: += -> -=", "3: * -> /", "3: 0 -> 1",
                                  "3: dropped: force[i] += k * overlap[0];"}  # fmt: skip


def test_the_same_seed_draws_the_same_faults() -> None:
    one, two = (draw(trial.files("plugin"), random.Random(7)) for _ in range(2))
    assert one == two


def test_every_room_has_files_and_tests() -> None:
    for room in trial.ROOMS:
        assert trial.files(room) and all((trial.ROOT / place).exists() for place in trial.TESTS[room])


def test_faults_without_effect_do_not_count() -> None:
    rows = [{"room": "plugin", "by": by} for by in ("replay", "replay", "survives", "no effect")]
    assert score(rows)[1].split() == ["plugin", "4", "3", "2", "0", "0", "1", "67%"]
