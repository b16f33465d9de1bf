"""The audit of the effect plan: what it says of plans that are right, and of each way to be wrong."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pywet.planning import audit
from pywet.runs.shapes import FORCES

TOLERANCE = 0.01


def planned(effect: str = "capillary", on: bool = True, number: float = 1.0, **more: Any) -> dict[str, Any]:
    """A row of plan.json."""
    return {"effect": effect, "on": on, "number": number, "threshold": TOLERANCE, "quantity": "", "why": "", **more}


def judged(row: dict[str, Any], share: float | None) -> audit.AuditRow:
    """The verdict on one row; `share` is its measure."""
    entry = {"acting": row["on"], "impulse_share": share, "liquid_share": share, "mean_stretch": share}
    found = {
        "effects": {
            name: entry for name in ("capillary", "viscous_normal", "viscous_tangential", "weight", row["effect"])
        }
    }
    return audit.rows({"rows": [row]}, found)[0]


@pytest.mark.parametrize(
    ("row", "share", "verdict", "words"),
    [
        (planned(), 0.5, audit.OK, "contributes 0.5"),
        (planned(on=False, number=0.001), 0.002, audit.OK, "left out"),
        (planned(on=False, number=0.001), 0.2, audit.WRONG, "left out but contributes 0.2"),
        (planned(number=1.0), 0.002, audit.SMALL, "on but contributes only 0.002"),
        (planned(number=0.001), 0.002, audit.OK, "negligible as its number says"),
        (planned(number=0.001), 0.2, audit.WRONG, "called negligible but contributes 0.2"),
        (planned(predicted_share=0.6, predicted_within=3.0), 0.1, audit.WRONG, "predicted 0.6, measured 0.1"),
        (planned(predicted_share=0.25, predicted_within=3.0), 0.1, audit.OK, "contributes 0.1"),
        (planned(predicted_share=0.6, predicted_within=10.0), 0.1, audit.OK, "contributes 0.1"),
        # a factor of a hundred between two shares below the tolerance is irrelevant
        (planned(number=0.001, predicted_share=1e-3, predicted_within=3.0), 1e-5, audit.OK, "negligible"),
        (planned(), None, audit.UNKNOWN, "measured nothing"),
        (planned("liquid_weight", on=False), 0.2, audit.OK, "in no preset, left out; would contribute 0.2"),
        (planned("shedding", on=False), 0.0, audit.OK, "in no preset, left out; what it would do was not measured"),
        (planned("shedding"), 0.3, audit.OK, "contributes 0.3"),
    ],
)  # fmt: skip
def test_verdicts(row: dict[str, Any], share: float | None, verdict: str, words: str) -> None:
    """Each way to be right and wrong."""
    found = judged(row, share)
    assert found.verdict == verdict
    assert words in found.text


def test_measures() -> None:
    """Liquid is measured by liquid, dynamic rupture by its stretch; a predicted share of impulse is not laid next to those."""
    assert judged(planned("wall_films", predicted_share=0.9), 0.05).measure.startswith("liquid drawn")
    assert judged(planned("wall_films", predicted_share=0.9), 0.05).predicted is None
    assert judged(planned("dynamic_rupture"), 0.05).measure.startswith("mean stretch")
    assert judged(planned("gravity"), 0.05).measured == 0.05  # the weight is called `gravity` in the plan
    assert audit.rows({"rows": [planned("wall_films", on=False)]}, {"effects": {}})[0].measured == 0.0  # without liquid
    assert judged(planned("bridges"), 0.1).measured == pytest.approx(0.3)  # the sum of three forces of 0.1
    assert judged(planned("bridges"), 0.0).measured == 0.0


def test_file(tmp_path: Path) -> None:
    """audit.json says whether the plan is right; without contributions there is none."""
    (tmp_path / "plan.json").write_text(json.dumps({"rows": [planned(on=False)]}))
    assert audit.write(tmp_path) is None and audit.read(tmp_path) is None
    entry = {"acting": False, "impulse_share": 0.3}
    effects = dict.fromkeys(FORCES, entry)
    (tmp_path / "contributions.json").write_text(json.dumps({"effects": effects}))
    found = audit.write(tmp_path)
    assert found == audit.read(tmp_path)
    assert json.loads((tmp_path / "audit.json").read_text())["plan_right"] is False
    assert "<-- plan wrong: left out but contributes 0.3" in audit.lines(found or [])[0]
