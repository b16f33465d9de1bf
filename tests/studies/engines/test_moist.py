"""The table of moist screening in two engines, from made-up rows and a run's numbers."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet.errors import PywetError
from studies.engines import moist

ROW = {"on_spheres": 0.7, "in_bridges": 0.2, "on_walls": 0.1, "bridges_per_sphere": 4.0, "cpu_s": 10.0}


def rows(engine: str, *retained: float) -> pd.DataFrame:
    return pd.DataFrame(
        [{"case": 2, "engine": engine, "seed": k, "retained": r, **ROW} for k, r in enumerate(retained)]
    )


def test_the_table_has_a_mean_and_the_interval_of_the_difference() -> None:
    """0.5 against 0.6, each ± 0.01 of two seeds: t of two degrees of freedom, 4.303, times 0.01; equal numbers are not bold."""
    table = pd.concat([rows("LIGGGHTS", 0.49, 0.51), rows("YADE", 0.59, 0.61)])
    *_, line, mean = moist.lines(table)
    assert line.startswith("| 2 | 0.500; **+0.100 ± 0.061** |")
    assert line.endswith("| 4.000; +0.000 ± 0.000 |")
    assert mean.startswith("| all, mean difference | **+0.100 ± 0.061** | +0.000 ± 0.000 |")
    assert moist.lines(rows("YADE", 0.5))[2:] == []  # the rows are of one engine only


def test_the_mean_over_cases_has_the_scatter_within_cases() -> None:
    """Differences 0.1 and 0.3, deviations of 0.0141: 0.2 ± 2.776 (t of four degrees of freedom) times
    sqrt(2) 0.01/2; the error of a difference is sqrt(2) 0.01."""
    other = pd.concat([rows("LIGGGHTS", 0.39, 0.41), rows("YADE", 0.69, 0.71)]).assign(case=3)
    table = pd.concat([rows("LIGGGHTS", 0.49, 0.51), rows("YADE", 0.59, 0.61), other, rows("YADE", 0.9).assign(case=5)])
    assert moist.over_cases(table, "retained") == "**+0.200 ± 0.028**"
    assert moist.over_cases(rows("YADE", 0.5, 0.6), "retained") == "–"


def test_time_of_runs_that_both_engines_have() -> None:
    table = pd.concat([rows("LIGGGHTS", 0.5, 0.5), rows("YADE", 0.5).assign(cpu_s=25.0)])
    assert moist.speed(table) == (
        "The mean processor time of the engine per run, over 1 run in each, is 10 s in LIGGGHTS and 25 s in YADE (2.5 times).\n\n"
    )


def test_a_call_resumes_with_the_runs_that_have_no_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each row is stored as its run ends; a run that fails is reported and the next one is made; time is over."""
    monkeypatch.setattr(moist, "TABLE", tmp_path / "rows.csv")
    made: list[tuple[int, str, int]] = []

    def simulate(case: int, engine: str, seed: int) -> tuple[int, str, int]:
        made.append((case, engine, seed))
        if case == 3 and engine == "YADE":
            raise PywetError("no")
        return made[-1]

    monkeypatch.setattr(moist, "simulate", simulate)
    monkeypatch.setattr(moist, "read_run", lambda run: run)
    monkeypatch.setattr(
        moist, "row", lambda run, _: dict(zip(("case", "engine", "seed"), run, strict=True)) | ROW | {"retained": 0.5}
    )
    moist.run([2, 3], 1, 1e9)
    assert len(made) == 4 and len(moist.stored()) == 3
    moist.run([2, 3], 1, 1e9)
    assert [one[:2] for one in made[4:]] == [(3, "YADE")]
    moist.run([2, 3], 1, -1.0)
    assert len(made) == 5


def test_a_run_that_is_found_again_takes_the_place_of_the_earlier_one() -> None:
    table = moist.merged(rows("YADE", 0.4, 0.5), rows("YADE", 0.6))
    assert table["retained"].tolist() == [0.6, 0.5]


def test_the_table_goes_between_the_marks_of_the_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"before\n{moist.MARKS[0]}former\n{moist.MARKS[1]}\nafter\n")
    moist.write(pd.concat([rows("LIGGGHTS", 0.5), rows("YADE", 0.5)]), page)
    text = page.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "former" not in text and "| 2 | 0.500; " in text
    page.write_text("no marks")
    with pytest.raises(PywetError, match="lacks the marks"):
        moist.write(rows("YADE", 0.5), page)
    assert moist.MARKS[0] in moist.PAGE.read_text() and moist.MARKS[1] in moist.PAGE.read_text()


def test_both_engines_agree_over_the_moist_cases() -> None:
    """What the page says on top: four seeds of each case and engine, no mean difference beyond its interval, two single ones."""
    table = pd.read_csv("docs/second_engine.csv")
    assert set(table.groupby(["case", "engine"]).size()) == {4} and sorted(set(table["case"])) == list(moist.MOIST)
    *_, mean = lines = moist.lines(table)
    assert "**" not in mean and "| +0.004 ± 0.012 |" in mean
    assert sum(line.count("**") for line in lines[2:-1]) == 2 * 2
