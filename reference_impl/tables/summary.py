"""Compare summary.json and results/checks.json with the logs."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from reference_impl.diagnosis.held import MISSING, NONE, Held
from reference_impl.motion.budget import WORKS
from reference_impl.replay import io, plans
from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import ReplayError, where
from reference_impl.replay.plans import enters
from reference_impl.replay.stream import BATCH, Rows
from reference_impl.tables.recomputed import Recomputed

NOT_COMPARED = ("versions of packages",)
"""Parts of summary.json that no log determines."""
LOGS = "the raw logs"


def load(path: Path) -> Any:
    """Read a JSON file of the run."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError, RecursionError) as error:
        raise ReplayError(
            f"{path} is not readable JSON; expected what `pywet run` writes: make the results again"
        ) from error


def checks(file: str, given: Any, expected: Recomputed) -> Iterator[Held]:
    """Compare names, values, limits and verdicts of the checks, and the counts in the sentence on lost spheres."""
    listed = {row.get("name"): row for row in given if isinstance(row, Mapping)} if isinstance(given, list) else {}
    for name, value in expected.checks.items():
        row, limit = listed.get(name, {}), expected.limits[name]
        yield Held(f"{file}: {name}.value", row.get("value"), value, LOGS, 1.0)
        yield Held(f"{file}: {name}.limit", row.get("limit"), limit, "docs/results.md", 1.0)
        yield Held(f"{file}: {name}.ok", row.get("ok"), value <= limit, "its value and limit")
    for other in [name for name in listed if name not in expected.checks]:
        yield Held(f"{file}: {other}", "there", NONE, "docs/results.md")
    message = re.findall(r"\d+", str(listed.get("no_particle_lost", {}).get("text", "")))
    want = ", ".join(map(str, expected.printed))
    yield Held(f"{file}: numbers in the sentence of no_particle_lost", ", ".join(message), want, LOGS)


def held(given: Mapping[str, Any], expected: Recomputed, scene: Mapping[str, Any], folder: Path) -> Iterator[Held]:
    """Compare every number of the summary that follows from the logs, the scene and the engine's own report."""
    path = folder / "engine" / "run.json"
    run = load(path) if path.exists() else {}
    steps, wall = round(scene["duration_s"] / scene["time_step_s"]), float(run.get("wall_s") or 0.0)
    done = steps - int(run.get("resumed_at_step") or 0)
    speed = done * sum(expected.counts.values()) / wall if wall > 0.0 else None
    of = {
        **{key: (scene[key], "scene.json") for key in ("name", "seed", "time_step_s")},
        "steps": (steps, "scene.json"), "simulated_s": (scene["duration_s"], "scene.json"),
        "ranks": (run.get("ranks"), "engine/run.json"), "wall_s": (wall, "engine/run.json"),
        "resumed_at_step": (run.get("resumed_at_step"), "engine/run.json"), "particle_steps_per_s": (speed, "engine/run.json"),
        "mass_kg": (expected.mass, LOGS), "initial_liquid_m3": (expected.initial, LOGS),
        **expected.more,
    }  # fmt: skip
    for key, (value, source) in of.items():
        yield Held(f"summary.json: {key}", given.get(key, MISSING), value, source)
    program = str(run.get("engine", "LIGGGHTS")).lower()
    versions = given.get("versions") or {}
    for name, key in ((program, "engine_version"), ("plugin", "plugin_hash")):
        yield Held(f"summary.json: versions.{name}", versions.get(name), run.get(key), "engine/run.json")
    last = {str(c): float(v) for c, v in expected.liquid.iloc[-1].items()}
    amounts = {c.removesuffix("_m3"): float(v) for c, v in last.items() if c.endswith("_m3") and c != "initial_m3"}
    size = expected.initial or 1.0
    yield from _group("liquid_end_m3", given, amounts, LOGS, size)
    if expected.ends is not None:
        yield from _group("contacts_end", given, expected.ends, LOGS, 1.0)
    yield from _group("spheres", given, expected.counts, LOGS)
    yield from _group("effects", given, scene["effects"], "scene.json")
    yield from _of_ledger(given, scene, folder)
    energy = energies(folder, scene)
    # round-off of their difference
    rounding = 1e-14 * sum(abs(e) for e in energy.values() if e is not None and np.isfinite(e))
    yield from (replace(held, allowance=rounding) for held in _group("energy_J", given, energy, LOGS))
    yield from checks("summary.json", given.get("checks"), expected)


def _group(
    name: str, given: Mapping[str, Any], want: Mapping[str, Any], source: str, scale: float | None = None
) -> Iterator[Held]:
    """Compare the entries of one group, without missing or additional ones."""
    there = given.get(name)
    there = there if isinstance(there, Mapping) else {}
    for key, value in want.items():
        yield Held(f"summary.json: {name}.{key}", there.get(key, MISSING), value, source, scale)
    for key in there:
        if key not in want:
            yield Held(f"summary.json: {name}.{key}", there[key], NONE, source)


def _of_ledger(given: Mapping[str, Any], scene: Mapping[str, Any], folder: Path) -> Iterator[Held]:
    """Yield the number of events up to the last output and the error of the ledger; a dry run has neither."""
    if not scene["effects"]["bridges"]:
        yield Held("summary.json: events", given.get("events", MISSING), None, "a run without bridges")
        yield Held("summary.json: ledger_error", given.get("ledger_error", MISSING), None, "a run without bridges")
        return
    log, ledger = where(folder, "events"), io.table(where(folder, "ledger"), "ledger").sort_values("step")
    formed = ended = 0
    for part in Rows(log, "events", ["step", "kind"]).parts(int(plans.plan(folder).outputs[-1]), BATCH):
        formed, ended = formed + int((part["kind"] == 0).sum()), ended + int((part["kind"] != 0).sum())
    yield from _group(
        "events", given, {"formations": formed, "ruptures": ended, "standing_bridges": formed - ended}, LOGS
    )
    held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"] + ledger["retired"]
    # relative to the largest amount, because there is none before the first sphere is inserted
    most = float(ledger["initial"].max())
    error = float((held - ledger["initial"]).abs().max()) / (most if most > 0.0 else 1.0)
    yield Held("summary.json: ledger_error", given.get("ledger_error", MISSING), error, LOGS, 1.0)


def energies(folder: Path, scene: Mapping[str, Any]) -> dict[str, float | None]:
    """Return energies at the end, and works since the start [J], under the summary's names."""
    moist = bool(scene["effects"]["bridges"])
    if moist and scene["output"].get("energy", True):
        with io.readable(where(folder, "energy")):
            table = io.parquet_table(where(folder, "energy")).sort_values("step")
        last, first = table.iloc[-1], table.iloc[0]
        found: dict[str, float | None] = {str(k): float(last[str(k)]) for k in table if k not in ("step", "time")}
        change = sum(float(last[k] - first[k]) for k in ("kinetic", "spin"))
        works = sum(float(last[k]) for k in WORKS if k in table)
        found["unaccounted"] = change - works
        return found
    outputs = plans.plan(folder).outputs
    ends = [_at(folder, scene, int(step)) for step in (outputs[0], outputs[-1])]
    kinetic, spin, height = (ends[1][k] - ends[0][k] for k in range(3))
    height -= _way_without_weight(folder, scene, outputs)
    rest = "contact_bridges_and_wall_motion" if moist else "contact_and_wall_motion"
    return {
        "kinetic": ends[1][0],
        "spin": ends[1][1],
        "gravity": height,
        rest: kinetic + spin - height,
        "unaccounted": None,
    }


def _way_without_weight(folder: Path, scene: Mapping[str, Any], outputs: Floats) -> float:
    """Return the work [J] that gravity did not do on spheres that moved in straight lines before their release."""
    t = io.table(where(folder, "trajectory"), "trajectory", [("step", "=", int(outputs[0]))]).sort_values("id")
    kind = t["type"].to_numpy()
    mass = io.masses(scene)
    waited = np.minimum(enters(dict(scene), kind), outputs[-1]) * scene["time_step_s"]
    speed = t[["vx", "vy", "vz"]].to_numpy(float) @ np.asarray(scene["gravity_m_per_s2"], float)
    return float((np.array([mass[k] for k in kind]) * waited * speed).sum())


def _at(folder: Path, scene: Mapping[str, Any], step: int) -> tuple[float, float, float]:
    """Return translational and rotational kinetic energy, and work of gravity from the origin [J], at an output."""
    t = io.table(where(folder, "trajectory"), "trajectory", [("step", "=", step)])
    if step and scene.get("outlets"):  # spheres that left are counted with their last state
        t = io.table(where(folder, "trajectory"), "trajectory").sort_values("step").drop_duplicates("id", keep="last")
    radius = {c["type"]: c["radius_m"] for c in scene["classes"]}
    m, r = (np.array([of[k] for k in t["type"]]) for of in (io.masses(scene), radius))
    v2, w2 = ((t[[f"{letter}{axis}" for axis in "xyz"]].to_numpy(float) ** 2).sum(axis=1) for letter in "vw")
    fall = t[["x", "y", "z"]].to_numpy(float) @ np.asarray(scene["gravity_m_per_s2"], float)
    return float(0.5 * (m * v2).sum()), float(0.2 * (m * r**2 * w2).sum()), float((m * fall).sum())
