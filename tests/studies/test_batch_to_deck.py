"""Batches and a deck: the scenes of the variants, and what the page says of their predictions."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
import yaml

from studies.batch_to_deck import figure, variants

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("variant", variants.VARIANTS)
def test_a_variant_changes_what_its_name_says(variant: str) -> None:
    """Twice as many spheres of every class where it is crowded, inclination and stroke of the deck where it travels."""
    batch, deck = (yaml.safe_load((variants.HERE / f"{name}.yaml").read_text()) for name in ("batch", "deck"))
    made = variants.scene(variant)
    ratio = 2 if "crowded" in variant else 1
    assert [s["count"] for s in made["spheres"]] == [ratio * s["count"] for s in batch["spheres"]]
    travels = "travelling" in variant
    for key in ("inclination_deg", "stroke"):
        assert made["deck"].get(key) == (deck if travels else batch)["deck"].get(key)
    assert ("walls" in made) is not travels
    same = {"materials", "liquid", "time_step"}
    assert {key: made[key] for key in same} == {key: batch[key] for key in same}


def test_the_page_has_the_stored_predictions_and_its_conclusions_follow_from_them() -> None:
    """With the residence times of the deck; a variant is called the cause if 0.7 to 0.9 lie within the deck's intervals."""
    table = pd.read_csv(figure.STORED)
    assert "\n".join(figure.page_rows(table)) in (ROOT / "docs" / "screens.md").read_text()
    ratio = (table["diameter_mm"] / figure.APERTURE_MM).round(3)
    within = {
        way: set(ratio[(table[way] >= table["T_low"]) & (table[way] <= table["T_high"])])
        for way in ("residence_times", *variants.VARIANTS)
    }
    assert within["residence_times"] == {0.5, 1.2} and within["crowded"] == {1.2}
    assert within["travelling"] == within["travelling_crowded"] == {0.8, 0.9, 1.2}
    fine = table[ratio < 0.75]
    assert ((fine["T"] - fine["travelling"]).round(2) == 0.11).all()  # "11 points too few"
