"""What each reading of a doubtful place of the paper does to the coefficients of restitution: one changed at a time."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pywet.collisions.wall import wall
from pywet.collisions.wall.curves import problem
from pywet.collisions.wall.data import FRICTION
from pywet.collisions.wall.problem import Problem

OTHER: dict[str, str] = {
    "shear_modulus": "as_printed",
    "drag": "as_printed",
    "gap": "as_printed",
    "goldman_signs": "as_printed",
    "suction_sign": "as_printed",
    "neck_radius": "as_printed",
    "volume_factors": "as_printed",
    "bridge_volume": "frozen",
    "contact_end": "force",
    "rupture_from": "wall",
    "capillary": "film_and_bridge",
}
"""Reading -> the one that is not the default."""


def cases() -> dict[str, Problem]:
    """Column -> collision: normal on a thick and on a thin layer, dry and wet oblique at a small and at a large angle."""
    tween = {"friction": FRICTION["tween20"]}
    return {
        "e_n 400 µm": problem("glass_1.74mm", ("water", 400)),
        "e_n 100 µm": problem("glass_1.74mm", ("water", 100)),
        "e_n dry": problem("alumina_1.74mm", None, gravity_m_per_s2=0.0),
        "e_t dry 5°": problem("alumina_1.74mm", None, angle_deg=5.0),
        "e_t wet 20°": problem("alumina_1.74mm", ("tween20", 100), angle_deg=20.0, **tween),
        "e_t wet 85°": problem("alumina_1.74mm", ("tween20", 100), angle_deg=85.0, **tween),
    }


def value(column: str, case: Problem, readings: dict[str, str], variant: str = "mended") -> float | None:
    """The coefficient that a column names; None where the reading is not defined for its layer."""
    changed: dict[str, Any] = case.model_dump(exclude_none=True) | {"readings": readings, "variant": variant}
    changed.setdefault("liquid", None)
    try:
        return float(wall.collide(Problem.model_validate(changed))[column.split()[0]])
    except ValueError:
        return None


def table() -> pd.DataFrame:
    """One row per reading; the first is the default, the last everything as printed."""
    rows = [{"reading": "default", **{c: value(c, case, {}) for c, case in cases().items()}}]
    for name, other in OTHER.items():
        row = {c: value(c, case, {name: other}) for c, case in cases().items()}
        rows.append({"reading": f"{name}: {other}", **row})
    rows.append({"reading": "variant: as_printed", **{c: value(c, k, {}, "as_printed") for c, k in cases().items()}})
    return pd.DataFrame(rows)
