"""The table of moist screening in two engines, from made-up rows and a run's numbers."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet.errors import PywetError
from studies.engines import moist

ROW = {"on_spheres": 0.7, "in_bridges": 0.2, "on_walls": 0.1, "bridges_per_sphere": 4.0}


def rows(engine: str, *retained: float) -> pd.DataFrame:
    return pd.DataFrame(
        [{"case": 2, "engine": engine, "seed": k, "retained": r, **ROW} for k, r in enumerate(retained)]
    )


def test_the_table_has_both_means_and_the_interval_of_their_difference() -> None:
    """0.5 against 0.6, each ± 0.01 of two seeds: t of two degrees of freedom, 4.303, times 0.01; equal numbers are not bold."""
    table = pd.concat([rows("LIGGGHTS", 0.49, 0.51), rows("YADE", 0.59, 0.61)])
    line = moist.lines(table)[-1]
    assert line.startswith("| 2 | 2, 2 | 0.500, 0.600; **+0.100 ± 0.061** |")
    assert line.endswith("| 4.000, 4.000; +0.000 ± 0.000 |")
    assert moist.lines(rows("YADE", 0.5))[2:] == []  # in one engine only


def test_a_run_that_is_found_again_takes_the_place_of_the_earlier_one() -> None:
    table = moist.merged(rows("YADE", 0.4, 0.5), rows("YADE", 0.6))
    assert table["retained"].tolist() == [0.6, 0.5]


def test_the_table_goes_between_the_marks_of_the_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"before\n{moist.MARKS[0]}former\n{moist.MARKS[1]}\nafter\n")
    moist.write(pd.concat([rows("LIGGGHTS", 0.5), rows("YADE", 0.5)]), page)
    text = page.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "former" not in text and "| 2 | 1, 1 |" in text
    page.write_text("no marks")
    with pytest.raises(PywetError, match="lacks the marks"):
        moist.write(rows("YADE", 0.5), page)
    assert moist.MARKS[0] in moist.PAGE.read_text() and moist.MARKS[1] in moist.PAGE.read_text()
