"""Predicted time, memory and disk of a screening run, derived independently from scene.json, configuration and measured costs.

Time is start + steps (step + touches touch + triangles triangle + near wire) + evaluations bridge + lists list. Costs were
measured with few and with many spheres: the time of a step of the whole bed is linear in their number n, that of one contact,
wire or bridge is linear in 1/n between the two and constant beyond. The number of spheres on the screen has a closed form: in
time t with L layers (at least one) every class falls to exp(-p tau), d tau = f dt/L, p = (1 - d/a)^2 (a/pitch)^2.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from reference_impl.diagnosis.held import MISSING, Held
from reference_impl.replay.arrays import Floats
from reference_impl.scene.tower import Heights, Plan

G = 9.81
POINTS = 200_001
"""Number of points of the time axis; the program uses 2000."""
LIMIT = 0.004
"""Relative deviation allowed for means over time.

One of the 2000 points of the program may be on the other side of a jump, which is at most that of all spheres coming
to rest, some eight times the mean contacts of a short run.
"""
RESTING, HITS, DELAY_S = 2.25, 4.0, 1.5
"""Contacts of a sphere at rest; collisions of a sphere on the screen per stroke; time until one in the bin rests."""
BRIDGES_EACH, EVENTS_EACH = 2.6, 80.0
"""Bridges per sphere; formations and ruptures of a sphere on the screen per second."""
PACKED, FASTEST = 0.4, 3.0
"""Solid fraction of the bed on the screen; speed of the fastest sphere there over the peak speed of the screen."""
SKIN, FALL = 3.6, 2.0
"""Skin over sqrt(largest diameter x displacement per step at FALL m/s); from 0.4 to 1.2 smallest radii."""
GATHERED_S, IN_BIN = 3.3, 0.93
"""Time after the opening from which retirement saves this share of the loop."""
RANK_B, SPHERE_B, REPLAY_B, REPLAY_EACH_B = 450e6, 20e3, 500e6, 60e3
"""Memory (docs/cluster.md): of a rank, per sphere, of the replay, per sphere there."""
OUTPUT_SPHERE_B, OUTPUT_BRIDGE_B, EVENT_B, STEP_SPHERE_B, STEP_BRIDGE_B = 110.0, 50.0, 105.0, 140.0, 240.0
"""Disk: per sphere and per bridge at an output, per event, per sphere and per bridge at a recorded step."""
WIRES = "analytic"
"""Kind of wires for the machine's costs, analytic."""
NEAREST = ("reduced", "smoke")
"""Scales whose table is used for one without a table."""
MEANS = frozenset({"seconds", "disk_B", "lists", "near", "touches", "events"})
SOURCE = "scene.json and config.json by the formulas of reference_impl/scene/cost.py"


def compared(given: Mapping[str, float], expected: Mapping[str, float]) -> Iterator[Held]:
    """Compare predicted numbers with the reference's; means over time to LIMIT, all others to round-off."""
    for name, value in expected.items():
        allowance = LIMIT * abs(value) if name in MEANS else 0.0
        yield Held(f"cost.{name}", given.get(name, MISSING), value, SOURCE, allowance=allowance)


def predicted(
    config: Mapping[str, Any],
    scene: Mapping[str, Any],
    scale: str,
    machine: Mapping[str, Any],
    study: Mapping[str, Any],
) -> dict[str, float]:
    """Return counts, processor time [s], memory and disk [bytes] of a case on one rank.

    Parameters
    ----------
    config, scene
        config.json and scene.json of the run.
    scale
        Name of its scale.
    machine
        Measured costs with `few` and with `many` spheres (machine.json).
    study
        Stored table of the accuracy study (table.json), of which the relative costs of laws are taken.
    """
    of = counts(config, scene)
    loop, start = _seconds(of, machine)
    opens = float(scene["slide"]["opens_at_s"])
    if scene["retire"]:
        loop *= 1.0 - IN_BIN * max(0.0, 1.0 - GATHERED_S / (scene["duration_s"] - opens))
    if of["bridges"]:
        tables = study["scales"]
        table = tables.get(scale) or next(tables[name] for name in NEAREST if name in tables)
        laws = config["settings"]["laws"]
        law = laws.get("capillary") or ("exact" if laws["preset"] == "exact" else "rabinovich")
        law = "exact" if law == "young_laplace" else law
        start *= table["habit"]["exact_start"] if law == "exact" else 1.0
        loop *= _relative(table, "capillary", law) * _relative(table, "integration", scene["viscous_integration"])
    output = scene["output"]
    outputs, logged = (
        scene["duration_s"] / output["interval_s"],
        output["contact_windows"] * output["contact_window_steps"],
    )
    disk = of["spheres"] * (OUTPUT_SPHERE_B * outputs + STEP_SPHERE_B * logged) + EVENT_B * of["events"]
    return of | {
        "seconds": start + loop,
        "memory_B": RANK_B + SPHERE_B * of["spheres"],
        "disk_B": disk + of["bridges"] * (OUTPUT_BRIDGE_B * outputs + STEP_BRIDGE_B * logged),
        "replay_B": REPLAY_B + REPLAY_EACH_B * of["spheres"],
    }


def _relative(table: Mapping[str, Any], parameter: str, level: str) -> float:
    """Return the cost of a level of a setting over that of the default in moist screening; 1 if not measured."""
    costs = {row["level"]: row["cost"].get("moist") for row in table["parameters"][parameter]}
    return float(costs[level]["ratio"]) if costs.get(level) else 1.0


def counts(config: Mapping[str, Any], scene: Mapping[str, Any]) -> dict[str, float]:
    """Return the operations of the run: steps, neighbour lists, contacts, wires near spheres, bridges, events."""
    tower, heights = Plan.of(config), Heights.of(config)
    bed = _Bed.of(scene, tower)
    time = np.linspace(0.0, scene["duration_s"], POINTS)
    there = bed.staying(time)
    on = there.sum(axis=1)
    wires = next(w for w in scene["walls"] if w["name"] == "wires")
    analytic = bool(wires["analytic_wires"])
    bridges = BRIDGES_EACH * bed.n.sum() if scene["effects"]["bridges"] else 0.0
    steps = scene["duration_s"] / scene["time_step_s"]
    return {
        "steps": steps,
        "lists": scene["duration_s"] * _mean(_lists(bed, scene, heights, tower, time, there)),
        "spheres": float(bed.n.sum()),
        "triangles": 0.0 if analytic else float(len(wires["triangle_part"])),
        "near": float(sum(_mean(there[:, k]) * w for k, w in enumerate(_wires_near(bed, scene, tower)))),
        "touches": _mean(_touching(bed, scene, time, on)),
        "bridges": bridges,
        "evaluations": steps / scene["bridges_every"] * bridges,
        "events": EVENTS_EACH * scene["duration_s"] * _mean(on) if bridges else 0.0,
        "analytic_wires": float(analytic),
    }


def _mean(values: Floats) -> float:
    return float(np.trapezoid(values) / (len(values) - 1))


@dataclass(frozen=True)
class _Bed:
    """Numbers and radii [m] of the classes, probability of passage per attempt, layers per sphere, attempts per second."""

    n: Floats
    radius: Floats
    passes: Floats
    layer: Floats
    frequency: float
    opens: float
    area: float

    @classmethod
    def of(cls, scene: Mapping[str, Any], tower: Plan) -> _Bed:
        n, r = (np.array([float(c[name]) for c in scene["classes"]]) for name in ("count", "radius_m"))
        area = tower.width**2 if tower.sides == 4 else 0.25 * math.pi * tower.width**2
        free = np.maximum(1.0 - 2.0 * r / tower.aperture, 0.0) * tower.aperture / tower.pitch
        frequency = float(scene["vibration"]["frequency_Hz"])
        return cls(n, r, free**2, 4.0 * r**2 / area, frequency, float(scene["slide"]["opens_at_s"]), area)

    def _spent(self, tau: Floats) -> Floats:
        """Return the attempts f t within a stretched time: the integral of the number of layers, which falls to one."""
        height = self.n * self.layer

        def layers(at: Floats) -> Floats:
            return np.asarray(np.exp(-np.multiply.outer(at, self.passes)) @ height)

        p = np.where(self.passes > 0.0, self.passes, 1.0)
        to_end = np.where(
            self.passes > 0.0, -np.expm1(-np.multiply.outer(tau, p)) / p, np.multiply.outer(tau, 1.0 + 0.0 * p)
        )
        whole = to_end @ height
        many = layers(tau) > 1.0
        if not many.any():
            return tau
        last = np.flatnonzero(many)[-1]
        return np.where(many, whole, whole[last] + (tau - tau[last]))

    def staying(self, time: Floats) -> Floats:
        """Return the spheres of each class that have not passed, shape (times, classes)."""
        tries = self.frequency * np.maximum(time - self.opens, 0.0)
        tau = np.linspace(0.0, tries[-1], POINTS)
        stretched = np.interp(tries, self._spent(tau), tau)
        return np.asarray(self.n * np.exp(-np.multiply.outer(stretched, self.passes)))


def _touching(bed: _Bed, scene: Mapping[str, Any], time: Floats, on: Floats) -> Floats:
    """Return contacts: of spheres at rest in the feed bin and, after a delay, in the collecting bin; else in hops."""
    mass = {c["type"]: 4.0 / 3.0 * math.pi * c["radius_m"] ** 3 * c["density_kg_per_m3"] for c in scene["classes"]}
    durations = []
    for pair in scene["pairs"]:
        m = mass[pair["a"]] if pair["b"] == 0 else 1.0 / (1.0 / mass[pair["a"]] + 1.0 / mass[pair["b"]])
        damped = math.hypot(math.pi, math.log(pair["restitution"])) / math.pi
        durations.append(math.pi * math.sqrt(m / pair["normal_stiffness_N_per_m"]) * damped)
        durations.append(math.pi * math.sqrt(2.0 * m / (7.0 * pair["tangential_stiffness_N_per_m"])))
    hops = min(RESTING, HITS * bed.frequency * min(durations))
    everyone = bed.n.sum()
    passed = everyone - np.interp(time - DELAY_S, time, on)
    lands = min(math.sqrt(2.0 * (scene["box_high_m"][2] - scene["screen_z_m"]) / G), bed.opens)
    at_rest = np.where(time < lands, 0.0, np.where(time < bed.opens, everyone, passed))
    return np.asarray(hops * everyone + (RESTING - hops) * at_rest)


def _skin(scene: Mapping[str, Any], bed: _Bed) -> float:
    way = FALL * scene["time_step_s"]
    best = SKIN * math.sqrt(2.0 * bed.radius.max() * way)
    return float(np.clip(best, 0.4 * bed.radius.min(), 1.2 * bed.radius.min()))


def _lists(
    bed: _Bed, scene: Mapping[str, Any], heights: Heights, tower: Plan, time: Floats, there: Floats
) -> Floats:  # fmt: skip
    """Return lists per second: as often as the fastest body moves by half a skin, in whole steps."""
    layers = np.maximum(there @ bed.layer, 1.0)
    rate = np.where(time > bed.opens, bed.frequency * (there @ bed.passes) / layers, 0.0)
    bottom = tower.thickness - heights.bin_floor
    drop, hit = math.sqrt(2.0 * G * heights.slide_top), math.sqrt(2.0 * G * bottom)
    wall = 2.0 * math.pi * bed.frequency * math.dist(scene["vibration"]["amplitude_m"], (0.0, 0.0, 0.0))
    falls = G * (time - bed.opens)
    screen = np.where(falls > 2.0 * drop, FASTEST * wall, np.clip(falls, 0.0, max(drop, FASTEST * wall)))
    flying = rate * hit / G
    below = np.minimum(falls - drop, hit * flying / (1.0 + flying))
    fastest = np.maximum.reduce([screen, below, np.full_like(screen, wall)])
    dt = scene["time_step_s"]
    return np.asarray(1.0 / (dt * np.ceil(0.5 * _skin(scene, bed) / (fastest * dt))))


def _wires_near(bed: _Bed, scene: Mapping[str, Any], tower: Plan) -> Floats:
    """Return the wires within reach of one sphere of each class: wire length times half a circle, over the bed's volume."""
    reach = bed.radius + 0.5 * tower.wire + 1.5 * _skin(scene, bed)
    height = 4.0 / 3.0 * math.pi * (bed.n @ bed.radius**3) / (PACKED * bed.area)
    return np.asarray(math.pi / tower.pitch * reach**2 / np.maximum(height, reach))


def _seconds(of: Mapping[str, float], machine: Mapping[str, Any]) -> tuple[float, float]:
    """Return the processor time of the loop and of the start [s]."""
    few, many, n = machine["few"], machine["many"], of["spheres"]
    program = "moist" if of["bridges"] else WIRES if of["analytic_wires"] else "stock"

    def bed(name: str) -> float:
        part = (n - few["spheres"]) / (many["spheres"] - few["spheres"])
        return float(max(few[name] * (1.0 - part) + many[name] * part, 0.0))

    def one(name: str) -> float:
        part = (1.0 / n - 1.0 / many["spheres"]) / (1.0 / few["spheres"] - 1.0 / many["spheres"])
        part = min(max(part, 0.0), 1.0)
        return float(part * few[name] + (1.0 - part) * many[name])

    meshes = of["triangles"] - (bed("triangles") if program == "stock" else 0.0)
    step = bed("step_stock" if program == "stock" else "step") + few["triangle"] * meshes
    step += of["touches"] * one("touch") + of["near"] * one(WIRES if of["analytic_wires"] else "mesh")
    lists = bed(f"list_{program}")
    if program == "moist" and not of["analytic_wires"]:
        lists += max(0.0, bed("list_stock") - bed(f"list_{WIRES}"))
    return of["steps"] * step + of["evaluations"] * one("bridge") + of["lists"] * lists, bed(f"start_{program}")
