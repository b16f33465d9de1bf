"""On what grounds the campaign's settings stand: its springs against the stored errors and prices of the accuracy study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pywet.evidence.accuracy import choice
from pywet.evidence.full_scale.campaign import SETTINGS

SCALE = "reduced"
ASKED = (("dry", "retained_mean"), ("dry", "retained_end"), ("moist", "retained_mean"), ("moist", "retained_end"))
"""Scene and quantity of the errors shown."""


def lines() -> list[str]:
    """The section on settings, as lines of the page."""
    table = choice.stored()["scales"][SCALE]
    rows = [row for row in table["knobs"]["stiffness"] if row["level"] <= table["default"]["stiffness"]]
    spread = float(np.std(table["spread_over_seeds"]["dry"]["retained_end"], ddof=1))
    springs = " and ".join(f"{of['stiffness']:g} of the paper's at {mm:g} mm" for mm, of in SETTINGS.items())
    return [
        "\n## Settings\n",
        "A time step of a tenth of the shortest collision, and springs of a stiffness of",
        f"{springs}, where there",
        "are four times as many spheres. What the accuracy study says of springs (reduced scale, 8 mm, its first second of",
        "screening, against the paper's stiffness, in % of the feed; ± is what chance may make of the mean over the seeds, 99 %;",
        "[what accuracy costs](accuracy.md)):\n",
        "| springs | price dry, moist | retained, dry: mean | at the end | moist: mean | at the end |",
        "|" + "---|" * 6,
        *(_row(row) for row in rows),
        "",
        "0.03 is told from 0.1 in no column; 0.01 errs more than twice as much as 0.1 at the end, dry. One run of that scale has",
        f"a standard deviation of {100 * spread:.1f} % at the end, dry. The spheres at 5.6 mm are smaller, and an impact",
        "dents them by a smaller part of their diameter, which goes with √(d/k): 0.03 is for near-mesh spheres",
        "of 5 mm what 0.042 is for those of 7 mm. From a time step of 0.1 to one of 0.025 no difference is told from chance.",
    ]  # fmt: skip


def _row(row: Mapping[str, Any]) -> str:
    found = {(e["scene"], e["quantity"]): e for e in row["errors"]}
    errors = (found[key] for key in ASKED)
    shown = " | ".join(f"{100 * e['value']:+.1f} ± {100 * e['limit']:.1f}" for e in errors)
    price = row["price"]
    return f"| {row['level']:g} | {price['dry']['ratio']:.2f}, {price['moist']['ratio']:.2f} | {shown} |"
