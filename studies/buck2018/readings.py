"""Effect of each reading of an ambiguous passage of the paper on the coefficients of restitution: one changed at a time."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pywet.collisions.wall import wall
from pywet.collisions.wall.forces import READINGS
from pywet.collisions.wall.problem import Problem
from studies.buck2018.buck_tables import FRICTION
from studies.buck2018.curves import problem


def cases() -> dict[str, Problem]:
    """Return column -> collision: normal on a thick and on a thin layer, dry and wet oblique at a small and at a large angle."""
    tween = {"friction": FRICTION["tween20"]}
    return {
        "e_n 400 µm": problem("glass_1.74mm", ("water", 400)),
        "e_n 100 µm": problem("glass_1.74mm", ("water", 100)),
        "e_n dry": problem("alumina_1.74mm", None, gravity_m_per_s2=0.0),
        "e_t dry 5°": problem("alumina_1.74mm", None, angle_deg=5.0),
        "e_t wet 20°": problem("alumina_1.74mm", ("tween20", 100), angle_deg=20.0, **tween),
        "e_t wet 85°": problem("alumina_1.74mm", ("tween20", 100), angle_deg=85.0, **tween),
    }


def coefficient(column: str, case: Problem, changed: dict[str, Any]) -> float | None:
    """Return the coefficient of a column; None if the reading is not defined for its layer."""
    try:
        other = Problem.model_validate({"liquid": None, **case.model_dump(exclude_none=True), **changed})
        return float(wall.collide(other)[column.split()[0]])
    except ValueError:
        return None


def table() -> pd.DataFrame:
    """Return one row per reading; the first is the default, the last everything as printed."""
    one_by_one = {f"{name}: {other}": {"readings": {name: other}} for name, (_, other) in READINGS.items()}
    changes: dict[str, dict[str, Any]] = {
        "default": {},
        **one_by_one,
        "variant: as_printed": {"variant": "as_printed"},
    }
    return pd.DataFrame(
        {"reading": message, **{column: coefficient(column, case, changed) for column, case in cases().items()}}
        for message, changed in changes.items()
    )
