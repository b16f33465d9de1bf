"""Partition curve, efficiencies, throughput and moisture of a screen's products, from the logs alone.

In a case the collecting bin at the end contains the unders; in a scene with outlets the products left through them
in the averaging period (period.py). The classes are sorted explicitly here, and sizes found by following the
curve.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import ndtri, stdtrit

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.replay import plans, retired
from reference_impl.replay.arrays import Floats
from reference_impl.tables import period, screen_series, screen_wall
from reference_impl.tables.period import BLOCKS, STUDENT
from reference_impl.tables.recomputed import Bodies, outputs

RESULTS = {1: "results/screen.json", 2: "results/screen_2.json", 3: "results/screen_3.json"}
"""Result file of each deck, from the top."""
LEVELS = ("overs", "middlings", "lower_middlings")
MOST_PASSED = 0.95
SAME = 1e-9
"""Difference of two times that is round-off [s]."""
SHARES = (
    "undersize_in_feed", "undersize_recovery", "oversize_recovery", "unders_purity", "overs_purity", "efficiency",
    "efficiency_product", "misplaced",
)  # fmt: skip
SOURCE = "the logs"


def within(every: pd.DataFrame, after: float, until: float, batch: bool = False) -> pd.DataFrame:
    """Return the spheres of both products that left between two times [s]; of a batch all."""
    table = every[every["product"].notna()]
    if not batch:
        table = table[(table["out"] > after + SAME) & (table["out"] <= until + SAME)]
    return table.reset_index(drop=True)


def spheres(folder: Path, scene: Mapping[str, Any], deck: int) -> pd.DataFrame:
    """Return all spheres: id, diameter [mm], mass [kg], product, time of leaving and of entering [s], liquid [m3]."""
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    diameter = {c["type"]: 2e3 * c["radius_m"] for c in scene["classes"]}
    table = pd.DataFrame(
        {"id": of.ids, "type": of.kind, "d": [diameter[k] for k in of.kind], "kg": of.mass, "start_m3": of.film}
    )
    if not scene.get("outlets"):
        return _of_batch(folder, scene, of, table)
    above = LEVELS[: deck - 1]
    names = {
        k: (o["product"] == LEVELS[deck - 1] and "overs") or "unders"
        for k, o in enumerate(scene["outlets"], start=1)
        if o.get("product") and o["product"] not in above
    }
    table["in"] = plans.enters(dict(scene), of.kind) * scene["time_step_s"]
    gone = retired.table(folder)
    gone = gone.assign(out=gone["step"] * scene["time_step_s"], product=gone["outlet"].map(names), m3=gone["film"])
    table = table.merge(gone[["id", "out", "product", "m3"]], on="id", how="left")
    continuous = any(c.get("insertion") for c in scene["classes"])
    return table if continuous else _of_outlets(folder, scene, of, table)


def _of_outlets(folder: Path, scene: Mapping[str, Any], of: Bodies, table: pd.DataFrame) -> pd.DataFrame:
    """Of a batch all that left counts; what stays is overs where there is one deck, with its liquid at the last output."""
    if not {o.get("product") for o in scene["outlets"]} & {*LEVELS[1:]}:
        last = deque(outputs(folder, scene, of, ["z"]), maxlen=1)[0]
        stays = table["out"].isna()
        table.loc[stays, "product"] = "overs"
        table.loc[stays, "m3"] = last.on[stays]
    return table


def _of_batch(folder: Path, scene: Mapping[str, Any], of: Bodies, table: pd.DataFrame) -> pd.DataFrame:
    """Assign each sphere of a batch to its product: those that have been in the bin and are there at the end are unders."""
    first = np.full(len(of.ids), np.nan)
    for o in outputs(folder, scene, of, ["z"]):
        below = np.zeros(len(of.ids), bool)
        below[o.at] = o.places["z"] < scene["bin_z_m"]
        first[below & np.isnan(first)] = o.step * scene["time_step_s"]
        liquid, here = o.on, o.here
    under = ~np.isnan(first) & here
    opened = float(scene["slide"]["opens_at_s"])
    table["in"], table["out"], table["m3"] = opened, np.where(under, first, np.nan), liquid
    table["product"] = np.where(under, "unders", "overs")
    return table


def curve(rows: pd.DataFrame) -> list[tuple[float, float, float]]:
    """Return size [mm], mass in the overs and in the unders [kg], from the finest."""

    def of(d: float, product: str) -> float:
        return float(rows["kg"][(rows["d"] == d) & (rows["product"] == product)].sum())

    return [(float(d), of(d, "overs"), of(d, "unders")) for d in sorted(rows["d"].unique())]


ROUND_OFF = 1e-12
"""Largest rounding of a share of masses."""


def size_of(sizes: list[tuple[float, float, float]], share: float) -> float | None:
    """Return the size [mm] at which the curve, from the coarse end, first falls to a share; None if it does not."""
    above: tuple[float, float] | None = None
    for d, over, under in reversed(sizes):
        t = over / (over + under)
        if t > share + ROUND_OFF:
            above = d, t
        elif above is not None:
            return (d * (above[1] - share) + above[0] * (share - t)) / (above[1] - t)
        else:
            rises = any(o < (share - ROUND_OFF) * (o + u) for _, o, u in sizes)
            return d if rises and t >= share - ROUND_OFF else None
    return None


def place_of(sizes: list[tuple[float, float, float]], cut: float | None) -> str:
    """Describe where a cut size is among the sizes, or why there is none, by which product outweighs the other."""
    if not sizes:
        return "no sphere left"
    if cut is not None:
        ends = {sizes[0][0]: "at the smallest size", sizes[-1][0]: "at the largest size"}
        return next((words for size, words in ends.items() if abs(cut - size) <= 1e-9 * size), "within the sizes")
    apart = [(over - under) / (over + under) for _, over, under in sizes]
    if min(apart) > 2.0 * ROUND_OFF:
        return "below the smallest size"
    return "above the largest size" if max(apart) < -2.0 * ROUND_OFF else "T does not stay above 0.5"


def cut_interval(rows: pd.DataFrame) -> tuple[float | None, float | None]:
    """Return the sizes at which the lower and the upper ends of the intervals of T cross one half; the widest of equal sizes."""
    ends: tuple[list[tuple[float, float, float]], ...] = ([], [])
    for d in sorted(rows["d"].unique()):
        found = []
        for _, of in rows[rows["d"] == d].groupby("type"):
            found.append(score_interval(int((of["product"] == "overs").sum()), len(of)))
        for into, t in zip(ends, (min(f[0] for f in found), max(f[1] for f in found)), strict=True):
            into.append((float(d), t, 1.0 - t))
    return size_of(ends[0], 0.5), size_of(ends[1], 0.5)


def score_interval(part: int, whole: int) -> tuple[float, float]:
    """Return the proportions p at which (p - part/whole)^2 is z^2 p (1 - p)/whole."""
    z2 = float(ndtri(0.975)) ** 2 / whole
    a, b, c = 1.0 + z2, -(2.0 * part / whole + z2), (part / whole) ** 2
    root = math.sqrt(max(0.0, b * b - 4.0 * a * c))
    return max(0.0, (-b - root) / (2.0 * a)), min(1.0, (-b + root) / (2.0 * a))


def efficiency_interval(rows: pd.DataFrame, limit: float) -> tuple[float | None, float | None]:
    """Return the ends of the interval of the efficiency, by squares of each size's effect with its share of overs at an end.

    Of classes of one size the widest ends are used; a size below the limit counts with its unders, one above with
    its overs.
    """
    if not len(rows):
        return None, None
    total = {True: 0.0, False: 0.0}
    for d, kg in zip(rows["d"], rows["kg"], strict=True):
        total[bool(d < limit)] += float(kg)
    value, fall, rise = -1.0, 0.0, 0.0
    for fine, kg in total.items():
        if not kg:
            value += 1.0
            continue
        for d in sorted({float(d) for d in rows["d"] if bool(d < limit) == fine}):
            of = rows[rows["d"] == d]
            mass, kinds = float(of["kg"].sum()), [of[of["type"] == k] for k in of["type"].unique()]
            t = float(of["kg"][of["product"] == "overs"].sum()) / mass
            ends = [score_interval(int((kind["product"] == "overs").sum()), len(kind)) for kind in kinds]
            down, up = t - min(e[0] for e in ends), max(e[1] for e in ends) - t
            value += mass / kg * ((1.0 - t) if fine else t)
            fall += (mass / kg * (up if fine else down)) ** 2
            rise += (mass / kg * (down if fine else up)) ** 2
    return value - math.sqrt(fall), value + math.sqrt(rise)


def moisture_interval(part: pd.DataFrame, density: float, batch: bool) -> float | None:
    """Return half the interval of the moisture [%]: Student's t of the ratio of liquid to mass over groups of spheres.

    There are eight groups in the order of leaving, the first ones one sphere larger than the last; in a batch
    every sphere is a group.
    """
    count = len(part)
    if count < BLOCKS:
        return None
    ranked = sorted(zip(part["out"], part["id"], part["kg"], part["m3"], strict=True), key=lambda row: (row[0], row[1]))
    many = count if batch else BLOCKS
    size, larger = divmod(count, many)
    sums, at = [], 0
    for k in range(many):
        here = ranked[at : at + size + (k < larger)]
        at += len(here)
        sums.append((math.fsum(row[2] for row in here), density * math.fsum(row[3] for row in here)))
    mass, liquid = (math.fsum(column) for column in zip(*sums, strict=True))
    squares = math.fsum((water - liquid / mass * kg) ** 2 for kg, water in sums)
    return 100.0 * float(stdtrit(many - 1, 0.975)) * math.sqrt(squares * many / (many - 1)) / mass


def numbers(rows: pd.DataFrame, scene: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of screen.json that follow from the counted spheres."""
    sizes, limit = curve(rows), given["reference_mm"]
    d25, d50, d75 = (size_of(sizes, share) for share in (0.25, 0.5, 0.75))
    found: dict[str, Any] = {"d25_mm": d25, "d50_mm": d50, "d50_position": place_of(sizes, d50), "d75_mm": d75}
    found |= dict(zip(("d50_high_mm", "d50_low_mm"), cut_interval(rows), strict=True))
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
            (fine_over + fine_under) / feed, undersize, oversize, fine_under / unders if unders else None,
            coarse_over / overs if overs else None, undersize - 1.0 + oversize, oversize * undersize,
            (fine_over + coarse_under) / feed,
        )  # fmt: skip
        found |= dict(zip(SHARES, values, strict=True))
    ends = (None, None) if limit is None else efficiency_interval(rows, limit)
    found |= dict(zip(("efficiency_low", "efficiency_high"), ends, strict=True))
    density = scene["liquid"]["density_kg_per_m3"] if scene["liquid"] else 0.0
    for product in ("overs", "unders"):
        part = rows[rows["product"] == product]
        found[f"spheres.{product}"] = len(part)
        mass = float(part["kg"].sum())
        found[f"moisture_percent_of_dry_mass.{product}"] = (
            100.0 * density * float(part["m3"].sum()) / mass if mass else None
        )
        found[f"moisture_half_width_percent.{product}"] = moisture_interval(part, density, given["kind"] == "batch")
        stay = (part["out"] - part["in"]).dropna()
        found[f"residence_s.{product}.mean"] = float(stay.sum() / len(stay)) if len(stay) else None
        found[f"residence_s.{product}.median"] = quantile(stay.to_numpy(), 0.5)
        found[f"residence_s.{product}.p90"] = quantile(stay.to_numpy(), 0.9)
    return found


def quantile(values: Floats, share: float) -> float | None:
    """Return the value that a share of all is below, linear between neighbours; None without values."""
    if not len(values):
        return None
    ranked = sorted(values.tolist())
    whole, part = divmod(share * (len(ranked) - 1), 1.0)
    low, high = ranked[int(whole)], ranked[min(int(whole) + 1, len(ranked) - 1)]
    return float(low + part * (high - low))


def rates(rows: pd.DataFrame, given: Mapping[str, Any], every: float) -> tuple[float | None, float | None]:
    """Return dry t/h of spheres that left, and half its 95 % interval from eight blocks; None with fewer intervals.

    Blocks consist of whole intervals between two removals; excess ones at the start are dropped.
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
    """Return dry t/h of a batch: of the unders until 95 % of them had passed."""
    passed = rows[rows["product"] == "unders"].sort_values(["out", "id"])
    total, so_far = float(passed["kg"].sum()), 0.0
    for kg, out in zip(passed["kg"], passed["out"], strict=True):
        so_far += kg
        if so_far >= (MOST_PASSED - 1e-9) * total:
            return 3.6 * so_far / (out - given["from_s"]) if out > given["from_s"] else None
    return 0.0


def throughput(
    rows: pd.DataFrame, given: Mapping[str, Any], every: float, area: float | None
) -> dict[str, float | None]:
    """Return throughputs with their intervals, and over the screen's area if there is one."""
    if given["kind"] == "batch":
        found: dict[str, tuple[float | None, float | None]] = {"unders": (of_batch(rows, given), None)}
    else:
        parts = {p: rows[rows["product"] == p] for p in ("overs", "unders")}
        found = {name: rates(part, given, every) for name, part in (*parts.items(), ("all", rows))}
    result: dict[str, float | None] = {}
    for name, (mean, half) in found.items():
        result[f"throughput_t_per_h.{name}"] = mean
        result[f"throughput_half_width_t_per_h.{name}"] = half
        result[f"throughput_t_per_h_m2.{name}"] = None if mean is None or not area else mean / area
    return result


def feed_moisture(folder: Path, scene: Mapping[str, Any]) -> float | None:
    """Return the moisture [% of dry mass] of the spheres that have entered by the last output; None if none has."""
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    came = plans.enters(dict(scene), of.kind) <= plans.plan(folder).outputs[-1]
    mass = math.fsum(of.mass[came])
    return 100.0 * of.density * math.fsum(of.film[came]) / mass if mass else None


def spilled(folder: Path, scene: Mapping[str, Any]) -> float:
    """Return the share of the mass that has entered by the last output that no product contains though it left."""
    of, last = Bodies.of(folder, scene, lambda wall: str(wall["name"])), plans.plan(folder).outputs[-1]
    lost = [k for k, o in enumerate(scene.get("outlets") or (), start=1) if not o.get("product")]
    gone = retired.table(folder)
    ids = set(gone["id"][gone["outlet"].isin(lost) & (gone["step"] <= last)])
    came = math.fsum(of.mass[plans.enters(dict(scene), of.kind) <= last])
    return math.fsum(of.mass[[i in ids for i in of.ids.tolist()]]) / came if came and ids else 0.0


def reference(folder: Path, sizes: list[tuple[float, float, float]], given: Mapping[str, Any]) -> float | None:
    """Return the size [mm] that separates undersize from oversize: the option, the aperture, or else d50."""
    if (size := (given.get("options") or {}).get("aperture")) is not None:
        return float(size)
    size = screen_wall.aperture(folder, given.get("deck", 1))
    return size_of(sizes, 0.5) if size is None else size


@dataclass(frozen=True)
class Deck:
    """Result of a deck, with all spheres, the averaging period (kind, from_s, to_s, steady) and the series."""

    given: Mapping[str, Any]
    spheres: pd.DataFrame
    period: Mapping[str, Any]
    start: Held
    series: pd.DataFrame

    @classmethod
    def read(cls, folder: Path, scene: Mapping[str, Any], given: Mapping[str, Any]) -> Deck:
        """Read a deck of a run; of `given`, screen.json, only the number and the options are taken as they are."""
        deck = given.get("deck", 1)
        every = spheres(folder, scene, deck)
        of_period, starts = period.of(folder, scene, every, given.get("options") or {})
        start = Held(f"{RESULTS[deck]}: from_s", given.get("from_s", MISSING), starts, SOURCE)
        of_period["from_s"] = starts[0] if start.wrong else given["from_s"]
        return cls(given, every, of_period, start, screen_series.table(folder, scene, every, deck))

    @property
    def counted(self) -> pd.DataFrame:
        """Return the spheres of both products that count."""
        p = self.period
        return within(self.spheres, p["from_s"], p["to_s"], p["kind"] == "batch")


def held(folder: Path, scene: Mapping[str, Any], of: Deck) -> Iterator[Held]:
    """Compare every number with that of screen.json."""
    deck, rows = of.given.get("deck", 1), of.counted
    size = reference(folder, curve(rows), of.given)
    mine: dict[str, Any] = {"run": scene["name"], "reference_mm": size}
    mine |= {key: value for key, value in of.period.items() if key != "from_s"}
    mine |= numbers(rows, scene, {**of.period, "reference_mm": size})
    mine["feed_moisture_percent"] = feed_moisture(folder, scene)
    mine["spilled_share"] = spilled(folder, scene)
    wall = screen_wall.of(scene, deck)
    mine["screen"] = wall["name"] if wall else None
    mine["screen_area_m2"] = screen_wall.area(folder, wall) if wall else None
    planned = plans.plan(folder)
    outputs_s = float(planned.outputs[1] - planned.outputs[0]) * scene["time_step_s"]
    rule = (
        plans.checkpoints_every(dict(scene), planned.steps) * scene["time_step_s"]
        if scene.get("outlets")
        else outputs_s
    )
    mine |= throughput(rows, of.period, rule, mine["screen_area_m2"])
    if wall:
        mine["apertures"] = screen_wall.count(folder, scene, wall, deck)
        slot = screen_wall.slots(folder, wall, deck)
        lengths = {f"pegged_{c['type']}": 2.0 * c["radius_m"] / slot for c in scene["classes"]} if slot else None
        mine |= screen_series.on_screen(of.series, of.period, mine["apertures"], lengths)
    yield of.start
    for path, value in mine.items():
        there: Any = of.given
        for key in path.split("."):
            there = there.get(key, MISSING) if isinstance(there, Mapping) else MISSING
        scale = (float(of.spheres["start_m3"].sum()) or 1.0) if path == "screen_liquid_m3" else None
        yield Held(f"{RESULTS[deck]}: {path}", there, value, SOURCE, scale)


def partition(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the partition curve from the finest size: masses [kg], T and its interval, the widest of classes of equal size."""
    found = []
    for d, over, under in curve(rows):
        of = rows[rows["d"] == d]
        ends = [score_interval(int((k["product"] == "overs").sum()), len(k)) for _, k in of.groupby("type")]
        low, high = min(e[0] for e in ends), max(e[1] for e in ends)
        found.append((d, over + under, over, under, over / (over + under), low, high))
    return pd.DataFrame(
        found, columns=["diameter_mm", "feed_kg", "overs_kg", "unders_kg", "T", "T_low", "T_high"], dtype=float
    )
