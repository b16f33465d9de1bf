"""Partition curve, efficiencies, throughput and moisture of a screen's products, from the logs alone.

Of a case the collecting bin at the end holds the unders; of a scene with outlets those that left through them between the two
times that `screen.json` names. The classes are sorted by hand here, and sizes found by going along the curve.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.motion.window import way_of
from reference_impl.replay import io, plans, retired
from reference_impl.replay.arrays import Floats
from reference_impl.tables.recomputed import Bodies, outputs

RESULTS = {1: "results/screen.json", 2: "results/screen_2.json", 3: "results/screen_3.json"}
"""Of each deck, from above."""
LEVELS = ("overs", "middlings", "lower_middlings")
MOST_PASSED, BLOCKS = 0.9, 8
STUDENT = 2.3646242515927844
"""Two-sided 95 % point of Student's distribution with seven degrees of freedom."""
SHARES = (
    "undersize_in_feed", "undersize_recovery", "oversize_recovery", "unders_purity", "overs_purity", "efficiency",
    "efficiency_product", "misplaced",
)  # fmt: skip
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
    ecart = found["ecart_probable_mm"] = None if d25 is None or d75 is None else (d75 - d25) / 2.0
    found["imperfection"] = None if ecart is None or d50 is None else ecart / d50
    if not sizes:
        found |= dict.fromkeys(SHARES)
    elif limit is not None:
        fine_over, fine_under, coarse_over, coarse_under = (
            math.fsum(row[column] for row in sizes if (row[0] < limit) == fine)
            for fine, column in ((True, 1), (True, 2), (False, 1), (False, 2))
        )
        undersize = fine_under / (fine_over + fine_under) if fine_over + fine_under else 1.0
        oversize = coarse_over / (coarse_over + coarse_under) if coarse_over + coarse_under else 1.0
        feed = math.fsum((fine_over, fine_under, coarse_over, coarse_under))
        unders, overs = fine_under + coarse_under, coarse_over + fine_over
        values = (
            (fine_over + fine_under) / feed, undersize, oversize, fine_under / unders if unders else 1.0,
            coarse_over / overs if overs else 1.0, undersize - 1.0 + oversize, oversize * undersize,
            (fine_over + coarse_under) / feed,
        )  # fmt: skip
        found |= dict(zip(SHARES, values, strict=True))
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
        found[f"residence_s.{product}.median"] = quantile(stay.to_numpy(), 0.5)
        found[f"residence_s.{product}.p90"] = quantile(stay.to_numpy(), 0.9)
    return found


def quantile(values: Floats, share: float) -> float | None:
    """Value that a share of all is below, linear between neighbours; None of nothing."""
    if not len(values):
        return None
    ranked = sorted(values.tolist())
    whole, part = divmod(share * (len(ranked) - 1), 1.0)
    low, high = ranked[int(whole)], ranked[min(int(whole) + 1, len(ranked) - 1)]
    return float(low + part * (high - low))


def rates(rows: pd.DataFrame, given: Mapping[str, Any], every: float) -> tuple[float | None, float | None]:
    """Dry t/h of spheres that left, and half of its 95 % interval from eight blocks; None where there are not as many intervals.

    Blocks are of whole intervals between two removals; what is left over is cut off at the start.
    """
    ends = np.arange(1, int(given["to_s"] / every + 1e-9) + 1) * every
    ends = ends[ends - every > given["from_s"] - 1e-9]
    ends = ends[len(ends) % BLOCKS if len(ends) >= BLOCKS else 0 :]
    if not len(ends):
        return None, None
    times, masses = rows["out"].to_numpy(float), rows["kg"].to_numpy(float)
    many = BLOCKS if len(ends) >= BLOCKS else 1
    blocks = []
    for part in ends.reshape(many, -1):
        inside = (times > part[0] - 0.5 * every) & (times < part[-1] + 0.5 * every)
        blocks.append(3.6 * math.fsum(masses[inside]) / (len(part) * every))
    mean = math.fsum(blocks) / many
    if many == 1:
        return mean, None
    spread = math.sqrt(math.fsum((b - mean) ** 2 for b in blocks) / (many - 1))
    return mean, STUDENT * spread / math.sqrt(many)


def of_batch(rows: pd.DataFrame, given: Mapping[str, Any]) -> float | None:
    """Dry t/h of a batch: of the unders until nine tenths of them had passed."""
    passed = rows[rows["product"] == "unders"].sort_values(["out", "id"])
    total, so_far = float(passed["kg"].sum()), 0.0
    for kg, out in zip(passed["kg"], passed["out"], strict=True):
        so_far += kg
        if so_far >= (MOST_PASSED - 1e-9) * total:
            return 3.6 * so_far / (out - given["from_s"]) if out > given["from_s"] else None
    return 0.0


def in_blocks(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Mean of the last values in eight blocks of equal length, and half of its 95 % interval; of fewer the mean alone."""
    if len(values) < BLOCKS:
        return (math.fsum(values) / len(values) if values else None), None
    size = len(values) // BLOCKS
    last = np.array(values[len(values) - BLOCKS * size :], float).reshape(BLOCKS, size)
    means = [math.fsum(row) / size for row in last.tolist()]
    mean = math.fsum(means) / BLOCKS
    return mean, STUDENT * math.sqrt(math.fsum((m - mean) ** 2 for m in means) / (BLOCKS - 1) / BLOCKS)


def pegged(folder: Path, scene: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, float | None]:
    """Spheres whose centres are within their radius of the screen's plane and that go along with it, on average over outputs.

    Going along: slower against the screen than half of 2 pi f times the root of the sum of its squared amplitudes.
    """
    number = given.get("deck", 1)
    names = [name + (f"_{number}" if number > 1 else "") for name in ("wires", "screen", "deck")]
    wall = next((w for w in scene["walls"] if w["name"] in names), None)
    if wall is None:
        return {}
    plane = float(scene.get("screen_z_m", 0.0))
    if wall["name"] != "wires":
        table = io.every(folder / "history" / "triangles.parquet")
        z = table.loc[table["mesh"] == wall["name"], ["v0_z", "v1_z", "v2_z"]].to_numpy(float)
        plane = (float(z.min()) + float(z.max())) / 2.0
    way = way_of(dict(scene), dict(wall)) if wall["motion"] == "vibrates" else {}
    a, phase = (np.array(way.get(key, [0.0] * 3), float) for key in ("amplitude_m", "phase_rad"))
    rate = 2.0 * math.pi * way.get("frequency_Hz", 0.0)
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    radius = np.array([c["radius_m"] for c in scene["classes"]])[of.kind - 1]
    counts = []
    for o in outputs(folder, scene, of, ["z", "vx", "vy", "vz"]):
        time = o.step * scene["time_step_s"]
        if not given["from_s"] <= time <= given["to_s"]:
            continue
        height = plane + a[2] * (math.sin(rate * time + phase[2]) - math.sin(phase[2]))
        v = o.places[["vx", "vy", "vz"]].to_numpy(float) - a * rate * np.cos(rate * time + phase)
        near = np.abs(o.places["z"].to_numpy(float) - height) < radius[o.at]
        slow = np.sqrt((v**2).sum(axis=1)) <= 0.5 * rate * math.sqrt(float((a**2).sum()))
        counts.append(float((near & slow & ~o.waits[o.at]).sum()))
    mean, half = in_blocks(counts)
    share = None if mean is None else mean / given["apertures"]
    return {"pegged": mean, "pegged_half_width": half, "pegged_share": share}


def throughput(rows: pd.DataFrame, given: Mapping[str, Any], every: float) -> dict[str, float | None]:
    """Throughputs with their intervals, and over the screen's area where there is one."""
    if given["kind"] == "batch":
        found: dict[str, tuple[float | None, float | None]] = {"unders": (of_batch(rows, given), None)}
    else:
        parts = {p: rows[rows["product"] == p] for p in ("overs", "unders")}
        found = {name: rates(part, given, every) for name, part in (*parts.items(), ("all", rows))}
    area = given["screen_area_m2"]
    result: dict[str, float | None] = {}
    for name, (mean, half) in found.items():
        result[f"throughput_t_per_h.{name}"] = mean
        result[f"throughput_half_width_t_per_h.{name}"] = half
        result[f"throughput_t_per_h_m2.{name}"] = None if mean is None or not area else mean / area
    return result


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
    mine |= throughput(rows, given, rule)
    if given["screen"] is not None:
        mine |= pegged(folder, scene, given)
    for path, value in mine.items():
        there: Any = given
        for key in path.split("."):
            there = there.get(key, MISSING) if isinstance(there, Mapping) else MISSING
        yield Held(f"{RESULTS[given.get('deck', 1)]}: {path}", there, value, SOURCE)
