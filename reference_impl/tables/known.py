"""Recompute `results/until.json`, the accuracy of the partition of a run in blocks, from the logs.

The time from which blocks count is taken from there, all else recomputed: T of each size, half its interval, and
whether the run ended correctly.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from scipy.special import ndtri, stdtrit

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.tables import plant

RESULT = "results/until.json"
SOURCE = "the logs"


def half_of_counts(part: int, whole: int) -> float:
    """Return half the distance of the two proportions p at which (p - part/whole)^2 is z^2 p (1 - p)/whole."""
    z2 = float(ndtri(0.975)) ** 2 / whole
    a, b, c = 1.0 + z2, -(2.0 * part / whole + z2), (part / whole) ** 2
    return math.sqrt(max(0.0, b * b - 4.0 * a * c)) / (2.0 * a)


def half_of_blocks(overs: list[float], feed: list[float]) -> float:
    """Return Student's t times the standard error of a ratio from blocks, by the deviations of each from the ratio of all."""
    number, ratio = len(feed), math.fsum(overs) / math.fsum(feed)
    if number < 2:
        return 0.0
    off = [o - ratio * n for o, n in zip(overs, feed, strict=True)]
    variance = math.fsum(x * x for x in off) / (number - 1) / number
    return float(stdtrit(number - 1, 0.975)) * math.sqrt(variance) * number / math.fsum(feed)


def held(folder: Path, scene: Mapping[str, Any]) -> Iterator[Held]:
    """Every number of until.json compared with the logs and the description."""
    given = json.loads((folder / RESULT).read_text())
    asked = json.loads((folder / "description.json").read_text())["until"]
    step, number = scene["time_step_s"], scene["blocks"]
    total = round(scene["duration_s"] / step)
    size, first = total // number, round(given["from_s"] / step / (total // number))
    rows = plant.within(plant.spheres(folder, scene, asked["deck"]), (first - 0.5 / size) * size * step, math.inf)
    rows = rows.assign(at=[round(t / step) for t in rows["out"]])
    rows = rows[rows["at"] > first * size]
    diameters = sorted(rows["d"].unique())
    yield Held(f"{RESULT}: sizes", len(given["sizes"]), len(diameters), SOURCE)
    widest: list[float] = []
    for diameter, there in zip(diameters, given["sizes"], strict=False):
        of = rows[rows["d"] == diameter]
        overs, feed, count = [0.0] * (number - first), [0.0] * (number - first), 0
        for at, product, kg in zip(of["at"], of["product"], of["kg"], strict=True):
            block = (at - 1) // size - first
            feed[block] += kg
            overs[block] += kg if product == "overs" else 0.0
            count += product == "overs"
        half = max(half_of_counts(count, len(of)), half_of_blocks(overs, feed))
        counts = len(of) >= asked["least_spheres"]
        widest += [half] if counts else []
        share = math.fsum(overs) / math.fsum(feed)
        mine = {"diameter_mm": diameter, "spheres": len(of), "T": share, "half_width": half}
        for key, value in {**mine, "asked": counts}.items():
            yield Held(f"{RESULT}: {key} of {diameter:.4g} mm", there.get(key, MISSING), value, SOURCE)
    known = bool(widest) and max(widest) <= asked["partition_percent"] / 100.0
    known = known and number - first >= asked["least_blocks"]
    ends = min(c["insertion"]["from_s"] + c["insertion"]["for_s"] for c in scene["classes"] if c.get("insertion"))
    over_all = {
        "asked": asked["partition_percent"] / 100.0,
        "blocks": number,
        "block_s": size * step,
        "least_blocks": asked["least_blocks"],
        "counted_blocks": number - first,
        "reached": known,
        "longest": number >= round(ends / step) // size,
    }
    for key, value in over_all.items():
        yield Held(f"{RESULT}: {key}", given.get(key, MISSING), value, SOURCE)
    yield Held(f"{RESULT}: ended", given["reached"] or given["longest"], True, "description.json: until")
