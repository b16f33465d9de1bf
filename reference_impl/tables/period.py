"""Averaging period of a screen: whether it is continuous, from where its means are taken, and up to where.

It starts at `--from`, else with the block that `until.from_s` asks for, else where hold-up and outflow are both steady: where the
squared deviations from the mean of the rest, over the square of its length, are least (White 1997).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.replay import plans
from reference_impl.replay.arrays import Floats

BLOCKS = 8
STUDENT = 2.3646242515927844
"""Two-sided 95 % point of Student's distribution with seven degrees of freedom."""
TIE = 1e-9
"""Relative difference of two sums of squares that round-off may decide."""


def of(
    folder: Path, scene: Mapping[str, Any], every: pd.DataFrame, options: Mapping[str, Any]
) -> tuple[dict[str, Any], Sequence[Any]]:
    """Return kind, steady and to_s of screen.json, and the possible values of from_s [s]; several where round-off decides."""
    step, steps = scene["time_step_s"], round(scene["duration_s"] / scene["time_step_s"])
    last = float(steps // plans.outputs_every(dict(scene)) * plans.outputs_every(dict(scene)) * step)
    times = [(c["insertion"]["from_s"], c["insertion"]["for_s"]) for c in scene["classes"] if c.get("insertion")]
    if not times or not scene.get("outlets"):
        start = 0.0 if scene.get("outlets") else float(scene["slide"]["opens_at_s"])
        return {"kind": "batch", "to_s": last, "steady": True}, (start,)
    first, end = min(a for a, _ in times), min(last, max(a + b for a, b in times))
    found = {"kind": "continuous", "to_s": end}
    if "from" in options:
        return {**found, "steady": True}, (float(options["from"]),)
    if (asked := of_blocks(folder, scene)) is not None:
        return {**found, "steady": True}, (asked,)
    starts = steady(scene, every, end)
    return (
        {**found, "steady": tuple({s is not None for s in starts})},
        tuple(first + 0.5 * (end - first) if s is None else s for s in starts),
    )


def of_blocks(folder: Path, scene: Mapping[str, Any]) -> float | None:
    """Return the time [s] of the first block that begins at `until.from_s` of the description or later; None without it."""
    asked = json.loads((folder / "description.json").read_text())["until"]["from_s"] if scene.get("blocks") else None
    if asked is None:
        return None
    every = round(scene["duration_s"] / scene["time_step_s"]) // scene["blocks"]
    blocks = [k for k in range(scene["blocks"]) if k * every >= asked / scene["time_step_s"] - 1e-9 * every]
    return float((blocks[0] if blocks else scene["blocks"]) * every * scene["time_step_s"])


def in_steps(times: pd.Series, step: float) -> Floats:
    """Return the first step at or after each time; infinite without a time."""
    return np.ceil(times.fillna(math.inf).to_numpy(float) / step - 1e-6)


def inside(every: pd.DataFrame, steps: Floats, step: float) -> Floats:
    """Return the mass [kg] that had entered and not left after each of some steps."""
    come, gone, kg = in_steps(every["in"], step), in_steps(every["out"], step), every["kg"].to_numpy(float)
    return np.array([math.fsum(kg[(come <= s) & (gone > s)]) for s in steps])


def steady(scene: Mapping[str, Any], every: pd.DataFrame, end: float) -> list[float | None]:
    """Return the times [s] from which the run may be steady; None: it is not."""
    step = scene["time_step_s"]
    length = plans.checkpoints_every(dict(scene), round(scene["duration_s"] / step))
    many = int(end / (length * step) + 1e-9)
    if many < 2:
        return [None]
    at = length * np.arange(1, many + 1)
    gone, kg = in_steps(every["out"], step), every["kg"].to_numpy(float)
    outflow = np.array([math.fsum(kg[(gone > s - length) & (gone <= s)]) for s in at])
    found = {
        None if None in pair else float(at[max(pair)] * step)  # type: ignore[type-var]
        for pair in product(starts(inside(every, at, step)), starts(outflow))
    }
    return sorted(found, key=lambda s: (s is None, s))


def starts(values: Floats) -> list[int | None]:
    """Return the indices from which a series may be steady; None: it is not by its middle."""
    n = len(values)
    if n < 2 * BLOCKS:
        return [None]
    squares = []
    for d in range(n - BLOCKS + 1):
        rest = values[d:].tolist()
        mean = math.fsum(rest) / len(rest)
        squares.append(math.fsum((v - mean) ** 2 for v in rest) / len(rest) ** 2)
    rounding = (1e-14 * float(np.abs(values).max())) ** 2
    least = min(squares)
    close = [d for d, s in enumerate(squares) if s <= least * (1.0 + TIE) + rounding]
    return [*dict.fromkeys(d if d <= n // 2 else None for d in close)]
