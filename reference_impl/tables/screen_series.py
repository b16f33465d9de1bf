"""Time series of a screen: hold-up, products, their liquid, liquid on the screen and pegged spheres of each class.

One pass over the outputs of a run; the means in screen.json are taken over its rows.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from reference_impl.motion.window import way_of
from reference_impl.replay import images, plans
from reference_impl.replay.arrays import Floats
from reference_impl.tables import period, screen_wall
from reference_impl.tables.period import BLOCKS, STUDENT
from reference_impl.tables.recomputed import Bodies, Output, outputs

MOTION = ["x", "y", "z", "vx", "vy", "vz"]


def table(folder: Path, scene: Mapping[str, Any], every: pd.DataFrame, deck: int) -> pd.DataFrame:
    """Return the series of a deck, from all spheres (plant.spheres) and the outputs of a run, read once."""
    step, steps = scene["time_step_s"], plans.plan(folder).outputs
    columns: dict[str, Any] = {"step": steps.astype(float), "time_s": steps * step}
    columns["hold_up_kg"] = period.inside(every, steps, step)
    gone = period.in_steps(every["out"], step)
    for product in ("overs", "unders"):
        left = (every["product"] == product).to_numpy() & (gone <= steps[:, None])
        for name, of in (("kg", "kg"), ("liquid_m3", "m3")):
            amount = every[of].fillna(0.0).to_numpy(float)
            columns[f"{product}_{name}"] = [math.fsum(amount[row]) for row in left]
    wall = screen_wall.of(scene, deck)
    return pd.DataFrame(columns | (_of_wall(folder, scene, wall, deck) if wall is not None else {}))


def _of_wall(folder: Path, scene: Mapping[str, Any], wall: dict[str, Any], deck: int) -> dict[str, list[float]]:
    """Return the liquid on the screen with its cross wires [m3] and the pegged spheres of each class at every output.

    A sphere pegs if it is caught at this output and at all others of a period of the screen's motion that begins or ends there,
    or contains it, and has hardly moved along the screen from the first to the last of them.
    """
    of = Bodies.of(folder, scene, lambda wall: str(wall["name"]))
    wires = np.isin(of.walls, [wall["name"], screen_wall.numbered(screen_wall.CROSS, deck)])
    caught = _Caught(folder, scene, wall, of)
    liquid: list[float] = []
    pegs: list[Floats] = []
    counted: list[Floats] = []
    box = images.of(folder)
    steps = plans.plan(folder).outputs
    length = min(max(1, caught.outputs_of_period(steps)), len(steps) - 1)
    recent: deque[tuple[Floats, Floats]] = deque(maxlen=length + 1)
    for o in outputs(folder, scene, of, MOTION):
        recent.append(caught.at(o))
        pegs.append(np.zeros(len(of.ids), bool))
        counted.append(~o.waits)
        liquid.append(math.fsum(o.walls[wires]))
        if length and len(recent) > length:
            moved = np.sqrt((box.nearest(recent[-1][0] - recent[0][0]) ** 2).sum(axis=1))
            stays = np.all([now for _, now in recent], axis=0) & (moved < 0.25 * caught.radius)
            pegs[-len(recent) :] = [row | stays for row in pegs[-len(recent) :]]
    both = [row & inside for row, inside in zip(pegs, counted, strict=True)]
    even = screen_wall.level(folder, scene, wall)
    kinds = {f"pegged_{c['type']}": of.kind == c["type"] for c in scene["classes"] if even}
    return {"screen_liquid_m3": liquid} | {k: [float((row & rows).sum()) for row in both] for k, rows in kinds.items()}


class _Caught:
    """Spheres in the apertures of a screen that move with it.

    The centre is within a radius of the plane, of a plate below 0.9 radii above its upper face; with a vibrating screen the
    speed relative to it is at most half of 2 pi f times the root of the sum of squared amplitudes.
    """

    def __init__(self, folder: Path, scene: Mapping[str, Any], wall: dict[str, Any], of: Bodies) -> None:
        way = way_of(dict(scene), wall) if wall["motion"] == "vibrates" else {}
        self._a, self._phase = (np.array(way.get(key, [0.0] * 3), float) for key in ("amplitude_m", "phase_rad"))
        self._rate, self._step = 2.0 * math.pi * way.get("frequency_Hz", 0.0), scene["time_step_s"]
        total = plans.plan(folder).steps
        parts = [
            summed(float(a), self._rate, float(p), self._step, total) for a, p in zip(self._a, self._phase, strict=True)
        ]
        self._displaced = np.stack(parts, axis=1)
        self._limit = 0.5 * self._rate * math.sqrt(float((self._a**2).sum())) if way else math.inf
        plane, plate = screen_wall.plane(folder, scene, wall), None
        if wall["name"] != "wires":
            plate = screen_wall.faces(folder, wall)
        self._low, self._high = plate or (plane, plane)
        self._above = 0.9 if plate else 1.0
        self.radius = np.array([c["radius_m"] for c in scene["classes"]])[of.kind - 1]

    def outputs_of_period(self, steps: Floats) -> int:
        """Return how many outputs a period of the screen takes, rounded up; 0 for a screen at rest."""
        if not self._rate or len(steps) < 2:
            return 0
        return math.ceil(2.0 * math.pi / self._rate / (float(steps[1] - steps[0]) * self._step) - 1e-6)

    def at(self, o: Output) -> tuple[Floats, Floats]:
        """Return places relative to the screen, and which spheres are caught."""
        place, now = np.zeros((len(self.radius), 3)), np.zeros(len(self.radius), bool)
        place[o.at] = o.places.rows(["x", "y", "z"]) - self._displaced[o.step]
        swing = np.cos(self._rate * (o.step * self._step) + self._phase)
        v = o.places.rows(["vx", "vy", "vz"]) - self._a * self._rate * swing
        z, radius = place[o.at, 2], self.radius[o.at]
        near = (z - self._high < self._above * radius) & (self._low - z < radius)
        now[o.at] = near & (np.sqrt((v**2).sum(axis=1)) <= self._limit)
        return place, now


def on_screen(
    table: pd.DataFrame, given: Mapping[str, Any], apertures: int, lengths: Mapping[str, float] | None = None
) -> dict[str, float | None]:
    """Return the means over the averaging period of pegged spheres, the share that they block, and liquid on the screen.

    Of a screen that is not horizontal nothing is known to peg. `lengths`: for slots, what a sphere of each column blocks over
    the length of a slot; otherwise it blocks one aperture.
    """
    rows = table[(table["time_s"] >= given["from_s"]) & (table["time_s"] <= given["to_s"])]
    columns = [c for c in rows if str(c).startswith("pegged_")]
    counts, found = rows[columns].to_numpy(float).tolist(), dict[str, float | None]()
    if not columns:
        found |= dict.fromkeys(("pegged", "pegged_half_width", "pegged_share", "pegged_share_half_width"))
        return {**found, "screen_liquid_m3": in_blocks(rows["screen_liquid_m3"].tolist())[0]}
    blocks = [1.0 if lengths is None else lengths[c] for c in columns]
    found["pegged"], found["pegged_half_width"] = in_blocks([math.fsum(row) for row in counts])
    shares = [math.fsum(n * b for n, b in zip(row, blocks, strict=True)) / apertures for row in counts]
    found["pegged_share"], found["pegged_share_half_width"] = in_blocks(shares)
    return {**found, "screen_liquid_m3": in_blocks(rows["screen_liquid_m3"].tolist())[0]}


def in_blocks(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Return the mean of the last values in eight blocks of equal length, and half its 95 % interval; for fewer only the mean."""
    if len(values) < BLOCKS:
        return (math.fsum(values) / len(values) if values else None), None
    size = len(values) // BLOCKS
    last = np.array(values[len(values) - BLOCKS * size :], float).reshape(BLOCKS, size)
    means = [math.fsum(row) / size for row in last.tolist()]
    mean = math.fsum(means) / BLOCKS
    return mean, STUDENT * math.sqrt(math.fsum((m - mean) ** 2 for m in means) / (BLOCKS - 1) / BLOCKS)


def summed(amplitude: float, rate: float, phase: float, step: float, total: int) -> Floats:
    """Return the displacement of a vibration after 0 to `total` steps, summed like the engine's mesh motion.

    Time is a sum of steps, a position one of velocity times step, some tenths of a µm from the sine.
    """
    at = np.cumsum(np.full(total, step))
    return np.concatenate([np.zeros(1), np.cumsum(amplitude * rate * np.cos(rate * at + phase) * step)])
