"""Partition curve, efficiencies, throughput and moisture of a screen's products, from the logs alone.

Of a case the collecting bin at the end holds the unders; of a scene with outlets those that left through them between the two
times that `screen.json` names. The classes are sorted by hand here, and sizes found by going along the curve.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.replay import plans, retired
from reference_impl.tables.recomputed import Bodies, outputs

RESULTS = {1: "results/screen.json", 2: "results/screen_2.json", 3: "results/screen_3.json"}
"""Of each deck, from above."""
LEVELS = ("overs", "middlings", "lower_middlings")
MOST_PASSED, BLOCKS = 0.9, 8
SOURCE = "the logs"


def products(folder: Path, scene: Mapping[str, Any], given: Mapping[str, Any]) -> pd.DataFrame:
    """Spheres that count: id, diameter [mm], mass [kg], product, time of leaving and of entering [s], liquid [m3]."""
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    diameter = {c["type"]: 2e3 * c["radius_m"] for c in scene["classes"]}
    table = pd.DataFrame({"id": of.ids, "d": [diameter[k] for k in of.kind], "kg": of.mass, "start_m3": of.film})
    if not scene.get("outlets"):
        return _of_batch(folder, scene, of, table)
    above = LEVELS[: given.get("deck", 1) - 1]
    names = {
        k: (o["product"] == LEVELS[given.get("deck", 1) - 1] and "overs") or "unders"
        for k, o in enumerate(scene["outlets"], start=1)
        if o.get("product") and o["product"] not in above
    }
    table["in"] = plans.enters(dict(scene), of.kind) * scene["time_step_s"]
    gone = retired.table(folder)
    gone = gone.assign(out=gone["step"] * scene["time_step_s"], product=gone["outlet"].map(names), m3=gone["film"])
    table = table.merge(gone[["id", "out", "product", "m3"]], on="id")
    table = table[table["product"].notna()]
    return table[(table["out"] > given["from_s"]) & (table["out"] <= given["to_s"])].reset_index(drop=True)


def _of_batch(folder: Path, scene: Mapping[str, Any], of: Bodies, table: pd.DataFrame) -> pd.DataFrame:
    """Assign each sphere of a batch to its product: those that have been in the bin and are there at the end are unders."""
    first = np.full(len(of.ids), np.nan)
    for o in outputs(folder, scene, of, ["z"]):
        below = np.zeros(len(of.ids), bool)
        below[o.at] = o.places["z"].to_numpy() < scene["bin_z_m"]
        first[below & np.isnan(first)] = o.step * scene["time_step_s"]
        liquid, here = o.on, o.here
    under = ~np.isnan(first) & here
    opened = float(scene["slide"]["opens_at_s"])
    table["in"], table["out"], table["m3"] = opened, np.where(under, first, np.nan), liquid
    table["product"] = np.where(under, "unders", "overs")
    return table


def curve(rows: pd.DataFrame) -> list[tuple[float, float, float]]:
    """Size [mm], mass in the overs and in the unders [kg], from the finest on."""

    def of(d: float, product: str) -> float:
        return float(rows["kg"][(rows["d"] == d) & (rows["product"] == product)].sum())

    return [(float(d), of(d, "overs"), of(d, "unders")) for d in sorted(rows["d"].unique())]


def size_of(sizes: list[tuple[float, float, float]], share: float) -> float | None:
    """Size [mm] at which the curve crosses a share for the first time; None where it does not."""
    before: tuple[float, float] | None = None
    for d, over, under in sizes:
        t = over / (over + under)
        if before is not None and before[1] <= share <= t and t > before[1]:
            return (before[0] * (t - share) + d * (share - before[1])) / (t - before[1])
        before = d, t
    return None


def numbers(rows: pd.DataFrame, scene: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of screen.json that follow from the spheres that count."""
    sizes, limit = curve(rows), given["reference_mm"]
    d25, d50, d75 = (size_of(sizes, share) for share in (0.25, 0.5, 0.75))
    found: dict[str, Any] = {"d25_mm": d25, "d50_mm": d50, "d75_mm": d75}
    found["ecart_probable_mm"] = None if d25 is None or d75 is None else (d75 - d25) / 2.0
    if not sizes:
        found |= dict.fromkeys(("undersize_recovery", "oversize_recovery", "efficiency", "misplaced"))
    elif limit is not None:
        fine_over, fine_under, coarse_over, coarse_under = (
            math.fsum(row[column] for row in sizes if (row[0] < limit) == fine)
            for fine, column in ((True, 1), (True, 2), (False, 1), (False, 2))
        )
        undersize = fine_under / (fine_over + fine_under) if fine_over + fine_under else 1.0
        oversize = coarse_over / (coarse_over + coarse_under) if coarse_over + coarse_under else 1.0
        found |= {"undersize_recovery": undersize, "oversize_recovery": oversize, "efficiency": undersize - 1.0 + oversize,
                  "misplaced": (fine_over + coarse_under) / math.fsum(row[1] + row[2] for row in sizes)}  # fmt: skip
    density = scene["liquid"]["density_kg_per_m3"] if scene["liquid"] else 0.0
    for product in ("overs", "unders"):
        part = rows[rows["product"] == product]
        found[f"spheres.{product}"] = len(part)
        mass = float(part["kg"].sum())
        found[f"moisture_percent_of_dry_mass.{product}"] = (
            100.0 * density * float(part["m3"].sum()) / mass if mass else None
        )
        stay = (part["out"] - part["in"]).dropna()
        found[f"residence_s.{product}.mean"] = float(stay.sum() / len(stay)) if len(stay) else None
    return found


def throughput(rows: pd.DataFrame, scene: Mapping[str, Any], given: Mapping[str, Any], every: float) -> float | None:
    """Dry t/h of all products, of a batch of the unders until nine tenths of them had passed."""
    if given["kind"] == "batch":
        passed = rows[rows["product"] == "unders"].sort_values(["out", "id"])
        total, so_far = float(passed["kg"].sum()), 0.0
        for kg, out in zip(passed["kg"], passed["out"], strict=True):
            so_far += kg
            if so_far >= (MOST_PASSED - 1e-9) * total:
                return 3.6 * so_far / (out - given["from_s"]) if out > given["from_s"] else None
        return 0.0
    ends = np.arange(1, int(given["to_s"] / every + 1e-9) + 1) * every
    ends = ends[ends - every > given["from_s"] - 1e-9]  # of the intervals that lie in it as a whole
    ends = ends[len(ends) % BLOCKS if len(ends) >= BLOCKS else 0 :]
    if not len(ends):
        return None
    inside = (rows["out"] > ends[0] - 0.5 * every) & (rows["out"] < ends[-1] + 0.5 * every)
    return 3.6 * float(rows["kg"][inside].sum()) / (len(ends) * every)


def held(folder: Path, scene: Mapping[str, Any], given: Mapping[str, Any]) -> Iterator[Held]:
    """Every number compared with that of screen.json."""
    rows = products(folder, scene, given)
    mine = numbers(rows, scene, given)
    planned = plans.plan(folder)
    outputs_s = float(planned.outputs[1] - planned.outputs[0]) * scene["time_step_s"]
    rule = (
        plans.checkpoints_every(dict(scene), planned.steps) * scene["time_step_s"]
        if scene.get("outlets")
        else outputs_s
    )
    which = "unders" if given["kind"] == "batch" else "all"
    mine[f"throughput_t_per_h.{which}"] = throughput(rows, scene, given, rule)
    for path, value in mine.items():
        there: Any = given
        for key in path.split("."):
            there = there.get(key, MISSING) if isinstance(there, Mapping) else MISSING
        yield Held(f"{RESULTS[given.get('deck', 1)]}: {path}", there, value, SOURCE)
