"""Force of YADE's own bridge laws at given gaps, from the installed program.

In YADE the volume of a bridge is a property of the material, so that it is exactly the requested one. YADE does not
support bodies with two contact angles. A wall is a large facet.
"""

from __future__ import annotations

import json
import math
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.util.files import read_json
from studies.stock.points import Floats, checked, expressible, run_program, with_force

YADE_LAWS = ("Willett_numeric", "Willett_analytic", "Weigert", "Rabinovich", "Lambert", "Soulie")
SCRIPT = Path(__file__).with_name("in_yade.py")


def yade_force(points: pd.DataFrame, law: str) -> pd.DataFrame:
    """Return the attraction [N] by YADE's law at each point (columns: see points.COLUMNS); adds `force` and `reason`.

    A point with S = 0 is measured at a gap of 1e-7 of the smaller radius, S < 0 at that overlap. Beyond YADE's rupture
    distance the force is zero. PywetError if the program is missing or stops.
    """
    if law not in YADE_LAWS:
        raise PywetError(f"the law {law} was asked for; expected one of {', '.join(YADE_LAWS)}")
    table = checked(points)
    refused = expressible(table, one_angle=True)
    stored = np.array([k not in refused for k in range(len(table))], dtype=bool)
    force = np.full(len(table), np.nan)
    if stored.any():
        force[stored] = _measure(table[stored], law)
    return with_force(points, force, "YADE", refused)


def _measure(table: pd.DataFrame, law: str) -> Floats:
    """Run the program once with a separate position for each point."""
    asked = table[["gap", "volume", "radius_i", "radius_j", "surface_tension"]].astype(float)
    asked = asked.assign(angle_deg=np.degrees(table["contact_angle"].to_numpy(float)))
    rows = [
        {**row, "radius_j": None if math.isinf(row["radius_j"]) else row["radius_j"]}
        for row in asked.to_dict("records")
    ]
    with tempfile.TemporaryDirectory(prefix="pywet-stock-") as name:
        folder = Path(name)
        (folder / "points.json").write_text(json.dumps({"law": law, "points": rows}))
        run_program(["yade", "-j1", "-x", "-n", str(SCRIPT), "points.json", "forces.json"], folder, "yade")
        result = folder / "forces.json"
        if not result.exists():
            raise PywetError(f"YADE ended without a result for the law {law}; expected YADE 2023.02a of Debian 12")
        return np.array(read_json(result), dtype=float)
