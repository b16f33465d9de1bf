"""Grounds of the campaign's settings: errors and costs of its contact stiffness in the stored accuracy study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pywet.cost import choice
from studies.full_scale.campaign import SETTINGS

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
        f"The time step is a tenth of the shortest collision, the contact stiffness {springs}. Errors of the stiffness at",
        "reduced scale, 8 mm, after one second of screening, against the paper's stiffness, in % of the feed ± 99 % limit",
        "([what accuracy costs](accuracy.md)):\n",
        "| stiffness | cost dry, moist | retained, dry: mean | at the end | moist: mean | at the end |",
        "|" + "---|" * 6,
        *(_row(row) for row in rows),
        "",
        "0.03 and 0.1 differ significantly in no column; 0.01 errs more than twice as much as 0.1 at the end, dry. One run has a",
        f"standard deviation of {100 * spread:.1f} % at the end, dry. Overlap over diameter varies as √(d/k): 0.03 is for",
        "spheres of 5 mm what 0.042 is for those of 7 mm. Time steps of 0.1 to 0.025 do not differ significantly.",
    ]  # fmt: skip


def _row(row: Mapping[str, Any]) -> str:
    found = {(e["scene"], e["quantity"]): e for e in row["errors"]}
    errors = (found[key] for key in ASKED)
    shown = " | ".join(f"{100 * e['value']:+.1f} ± {100 * e['limit']:.1f}" for e in errors)
    price = row["price"]
    return f"| {row['level']:g} | {price['dry']['ratio']:.2f}, {price['moist']['ratio']:.2f} | {shown} |"
