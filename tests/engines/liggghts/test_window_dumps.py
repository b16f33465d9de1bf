"""The engine's text dumps of the windows: every frame with its step, numbers to the last bit, a cut file refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pywet.engines.liggghts import windows
from tests.error_codes import raises_code

COLUMNS = ["id", "x", "y"]


def frame(step: int, rows: list[tuple[int, float, float]], end: str) -> str:
    """A frame as the engine writes it."""
    box = "ITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n{box}ITEM: ATOMS id x y\n"
    return head + "".join(f"{i} {x:.17g} {y:.17g}{end}\n" for i, x, y in rows)


@pytest.mark.parametrize("end", ["", " "])
def test_frames_keep_their_step_and_every_digit(tmp_path: Path, end: str) -> None:
    """17 digits give back the same double; a frame without rows adds none."""
    random = np.random.default_rng(2)
    rows = [(k + 1, *map(float, random.normal(size=2) * 10.0 ** random.integers(-30, 30, 2))) for k in range(200)]
    path = tmp_path / "states.txt"
    path.write_text(frame(10, rows[:120], end) + frame(20, [], end) + frame(30, rows[120:], end))
    table = windows.read_dump(path, COLUMNS)
    assert table["step"].tolist() == [10] * 120 + [30] * 80
    assert np.array_equal(table[COLUMNS].to_numpy(), np.array(rows))


def test_empty_frames_give_an_empty_table_of_numbers(tmp_path: Path) -> None:
    path = tmp_path / "pair_springs.txt"
    path.write_text(frame(10, [], " "))
    table = windows.read_dump(path, COLUMNS)
    assert len(table) == 0 and list(table.columns) == ["step", *COLUMNS] and table["x"].dtype == np.float64


@pytest.mark.parametrize("cut", [1, 9, 30, 100, 145])
def test_a_dump_that_is_cut_off_is_refused(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "states.txt"
    path.write_text(frame(10, [(k, 0.25, 0.5) for k in range(5)], " ")[:-cut])
    with raises_code("run.dump_cut_off"):
        windows.read_dump(path, COLUMNS)
