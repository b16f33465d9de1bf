"""The report's table of contributions: values, colours and sentences of made-up cases."""

from __future__ import annotations

from pathlib import Path

import pytest

from pywet import config as settings
from pywet.planning import audit
from pywet.report import contributed
from pywet.report.collect import CaseResult

ROOT = Path(__file__).parent.parent.parent
EFFECTS = ("weight", "contact_normal", "contact_tangential", "capillary", "viscous_normal")


def row(effect: str, verdict: str, measured: float, predicted: float | None = None, on: bool = True) -> audit.AuditRow:
    """One judged effect."""
    return audit.AuditRow(effect, on, audit.IMPULSE, predicted, 3.0, measured, 0.01, verdict, f"{effect} text")


@pytest.fixture
def results() -> list[CaseResult]:
    """One measured case, and one that failed."""
    config = settings.load(ROOT / "config")
    entry = {"impulse_share": 2.876, "energy_share": 0.5}
    measured = {"effects": dict.fromkeys(EFFECTS, entry)}
    rows = (
        row("capillary", audit.WRONG, 0.6, predicted=0.1),
        row("viscous_normal", audit.OK, 0.0, on=False),
        row("rolling", audit.SMALL, 0.004),
        row("gravity", audit.OK, 0.3),
    )
    good = CaseResult(config.case(2), (), contributions=measured, audit=rows)
    return [good, CaseResult(config.case(3), ("stage simulate failed",))]


def test_rows(results: list[CaseResult]) -> None:
    """Contacts without a colour first, then the plan's effects; the weight once; nothing for the failed case."""
    rows = {name: cells for name, _, cells in contributed.rows(results)}
    assert list(rows)[:3] == ["weight", "contact_normal", "contact_tangential"]
    assert "gravity" not in rows
    cell = rows["capillary"][0]
    assert cell is not None and (cell.share, cell.predicted, cell.colour) == (0.6, 0.1, "wrong")
    assert cell.text == "capillary text; 50 % of the energy turned over"
    assert [rows[n][0].colour for n in ("viscous_normal", "rolling")] == ["off", "small"]  # type: ignore[union-attr]
    assert contributed.percent(rows["contact_normal"][0].share) == "288"  # type: ignore[union-attr]
    assert rows["capillary"][1] is None


def test_wrong_plans_are_named(results: list[CaseResult]) -> None:
    """One sentence for the one wrong effect; without measurements there is no table."""
    assert contributed.wrong(results) == ["Case 2, capillary: capillary text."]
    assert contributed.rows(results[1:]) == []
