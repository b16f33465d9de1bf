"""The scatter of inputs: what is moved, effects of known rows, the stored rows and the page that shows them."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest

from pywet import config
from pywet.cost import choice
from studies.accuracy import blocks, scatter

ROOT = Path(__file__).parents[3]
ACCURACY, MEASURED = ROOT / "docs" / "accuracy.md", ROOT / "docs" / "measured.md"
CONFIG = config.load(ROOT / "config")
SMOKE = choice.stored()["scales"]["smoke"]


def test_one_input_is_moved_and_nothing_else() -> None:
    """By the sources' numbers: friction of POM on POM by 0.0674/0.2736, on steel by 0.0756/0.2514; the rest stays."""
    more, less = (scatter.scattered(CONFIG, "friction", sign).resolved(2, "smoke") for sign in (1, -1))
    usual = CONFIG.resolved(2, "smoke")
    steel, pom = (
        [made["materials"]["contacts"][k]["friction"]["value"] for made in (less, usual, more)] for k in (0, 1)
    )
    assert pom == pytest.approx([0.3725 * f for f in (1 - 0.0674 / 0.2736, 1, 1 + 0.0674 / 0.2736)])
    assert steel == pytest.approx([0.3484 * f for f in (1 - 0.0756 / 0.2514, 1, 1 + 0.0756 / 0.2514)])
    for made in (more, less):
        for contact, usual_contact in zip(made["materials"]["contacts"], usual["materials"]["contacts"], strict=True):
            contact["friction"] = usual_contact["friction"]
        assert made == usual
    wetter = scatter.scattered(CONFIG, "film", 1)
    assert wetter.case(2).liquid_percent == pytest.approx(5.5) and wetter.case(1).liquid_percent == 0.0
    tension = scatter.scattered(CONFIG, "tension", -1).materials.liquid.surface_tension_N_per_m.value
    assert tension == pytest.approx(0.07275 * 69 / 70)


def test_effects_of_known_rows() -> None:
    """High minus low, halved; a setting against the default; limits as those of the study with other seeds."""
    rows = [
        {"scene": "moist", "seed": seed, "input": name, "level": level, "retained_mean": value, "retained_end": 0.5}
        for seed in (1, 2, 3, 4)
        for name, level, value in (
            ("default", 0, 0.7), ("friction", -1, 0.6), ("friction", 1, 0.8), ("bridges_every", 4, 0.73),
        )
    ]  # fmt: skip
    made = scatter.effects(pd.DataFrame(rows), SMOKE).set_index(["input", "quantity"])
    assert made.loc[("friction", "retained_mean"), "value"] == pytest.approx(0.1)
    assert made.loc[("bridges_every", "retained_mean"), "value"] == pytest.approx(0.03)
    (known,) = (r["errors"] for r in SMOKE["parameters"]["fraction"] if r["level"] == 0.1)
    (limit,) = (e["limit"] for e in known if (e["scene"], e["quantity"]) == ("moist", "retained_mean"))
    assert made.loc[("bridges_every", "retained_mean"), "limit"] == pytest.approx(limit)
    assert made.loc[("friction", "retained_mean"), "limit"] == pytest.approx(0.5 * limit)


def test_the_documentation_shows_the_stored_rows() -> None:
    """Every input in its scenes with every seed; the table of docs/measured.md is that of the page."""
    rows = scatter.stored()
    for name, given in scatter.INPUTS.items():
        for scene in given.scenes:
            of = rows[(rows["input"] == name) & (rows["scene"] == scene)]
            assert set(of["level"]) == {-1, 1} and of["seed"].nunique() >= 2 and of["retained_end"].between(0, 1).all()
    text = MEASURED.read_text().split("<!-- scatter -->")[1].split("<!-- end of scatter -->")[0]
    shown = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.strip().splitlines()[2:]]
    assert shown == blocks.scatter_rows(SMOKE)
    page = blocks.scattered(SMOKE)
    assert all(given.source in page for given in scatter.INPUTS.values())


def test_no_row_of_the_documentation_is_significant() -> None:
    """Find the bound of friction for the dry mean, its mean and half width, in the text."""
    cells = [cell for row in blocks.scatter_rows(SMOKE) for cell in row[1:] if cell != "–"]
    values = [tuple(float(part) for part in cell.split(" ± ")) for cell in cells]
    assert len(values) > 20 and all(abs(mean) <= half for mean, half in values)
    found = re.search(r"changes the dry mean by at most ([\d.]+) %", " ".join(MEASURED.read_text().split()))
    assert found and 0.0 <= float(found[1]) - sum(values[0]) < 0.1


def test_what_the_documentation_says_of_bridges_every_fourth_step() -> None:
    fourth = next(row for row in SMOKE["parameters"]["bridges_every"] if row["level"] == 4)
    of = {e["quantity"]: e for e in fourth["errors"]}
    text = " ".join(ACCURACY.read_text().split())
    cost = fourth["cost"]["moist"]
    assert f"every fourth step** (smoke scale) costs {cost['low']:.2f} to {cost['high']:.2f} of the default" in text
    pull = [f"{100 * of[name]['value']:.2g} %" for name in ("pull_force", "pull_work", "pull_rupture")]
    assert f"the error is {pull[0]} of the force, {pull[1]} of the work and {pull[2]} of the rupture distance" in text
    assert all(abs(e["value"]) <= e["limit"] for name, e in of.items() if not name.startswith("pull"))
    mean, bridges = of["retained_mean"], of["liquid_bridges"]
    assert f"the mean fraction retained changes by −{-100 * mean['value']:.2g} ± {100 * mean['limit']:.2g} %" in text
    assert f"the liquid in bridges by +{100 * bridges['value']:.2g} ± {100 * bridges['limit']:.2g} %" in text
