"""Accuracy of a deck's numbers: the statistics by closed forms, the table of the page from the stored runs."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pywet.sweep import description
from studies.deck_numbers import page

ROOT = Path(__file__).resolve().parents[2]


def test_the_page_has_the_numbers_of_the_stored_runs() -> None:
    """Six seeds of each point; both sentences on single changes hold by the criteria of the study."""
    table = pd.read_csv(page.STORED)
    text = (ROOT / "docs" / "screens.md").read_text()
    assert not table.duplicated([*page.DEFAULT, "seed"]).any() and len(table) == 6 * (1 + len(page.CHANGES))
    assert "\n".join(page.page_rows(table)) in text
    moved = {
        (name, what)
        for name, (number, *_) in page.NUMBERS.items() for what, one in page.CHANGES.items()
        if page.change(table, number, *one)[2]
    }  # fmt: skip
    assert moved == {("moisture of the overs, %", "feed of 10 s"), ("moisture of the unders, %", "feed of 10 s")}
    assert "not significantly among 21 comparisons. Half the time step changes nothing significantly." in text
    assert len(page.NUMBERS) * len(page.CHANGES) == 21


def test_an_interval_is_too_narrow_where_seeds_scatter_more() -> None:
    """Six values of variance 1: chi-square of five degrees of freedom exceeds 15.90 with probability 0.05/7."""
    values = pd.Series([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0]) * (5.0 / 6.0) ** 0.5
    assert values.var() == pytest.approx(1.0)
    for factor, narrow in ((1.01, False), (0.99, True)):
        half = pd.Series([factor * 1.96 * (5.0 / 15.90) ** 0.5] * 6)
        assert page.too_narrow(values, half, 1.96) == narrow
    assert not page.too_narrow(pd.Series([0.0] * 6), pd.Series([0.0] * 6), 1.96)


def test_one_value_is_changed_at_a_time() -> None:
    """The sweep has the points of the page: the default and each change alone."""
    sweep = description.read(ROOT / "studies" / "deck_numbers" / "deck_numbers.yaml")
    assert {page.AXES.get(key) for key in sweep.axes} == {*page.DEFAULT, None} and sweep.seeds == 6
    for column, value in page.CHANGES.values():
        key = next(k for k, name in page.AXES.items() if name == column)
        assert tuple(sweep.axes[key].listed) == (page.DEFAULT[column], value)
