"""Run directory of a script, laid out like that of a scene: initial state, and tables made from the raw logs at the end."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.engines.liggghts.inputs import meta, transfer_tables
from pywet.geometry import Surface, write_stl
from pywet.geometry.initial import part_table, triangle_table
from pywet.runs import tables
from pywet.scene import EngineScene
from pywet.schema import FORMATION, RAW
from pywet.util.files import read_json, read_table, write_json, write_parts, write_table

SCRIPT = "script.json"
"""File that marks the run of a script.

It contains the output steps, steps of contact windows, the step at which the script ended, whether the run resumes from a
restart file, other forces on spheres, walls without films, and lengths of the box along x, y, z where it is periodic (else 0).
"""
LOGGED = "ledger.0.bin"
"""Raw log that is there as long as all are."""
COME = "come.bin"
"""Raw log of inserted spheres."""
OF_COME = np.dtype([("id", "<i8"), ("type", "<i8"), ("radius", "<f8"), ("film", "<f8"), ("enters", "<i8")])


def begin(log: Path, surfaces: Sequence[Surface], scene: EngineScene, noted: Mapping[str, Any]) -> None:
    """Write the data that do not change: walls as they are at the fix; `noted` for script.json."""
    run_folder.claim(log)
    (log / "engine").mkdir(exist_ok=True)
    write_json(log / SCRIPT, dict(noted))
    for surface, wall in zip(surfaces, scene.walls, strict=True):
        write_stl(surface, log / wall.stl)
    if surfaces:
        write_table(triangle_table(surfaces), log / "history" / "triangles.parquet")
        write_table(part_table(scene, surfaces), log / "history" / "parts.parquet")


def note_forces(log: Path, others: Sequence[str]) -> None:
    """Add unknown forces to those listed in script.json."""
    noted = dict(read_json(log / SCRIPT, "run the script again"))
    write_json(log / SCRIPT, {**noted, "other_forces": list(dict.fromkeys([*noted["other_forces"], *others]))})


def note_end(log: Path, step: int) -> None:
    """Add the last step of the script to script.json."""
    write_json(log / SCRIPT, {**dict(read_json(log / SCRIPT, "run the script again")), "ended_at_step": step})


def ended_at_step(log: Path) -> int | None:
    """Return the last step of a finished script; None if its command `quit` ended the engine."""
    step: int | None = dict(read_json(log / SCRIPT, "run the script again")).get("ended_at_step")
    return step


def write_scene(log: Path, scene: EngineScene) -> None:
    """Write the data that change when spheres of another class are inserted."""
    write_json(log / "scene.json", scene.model_dump(mode="json"))
    write_table(transfer_tables(scene), log / "history" / "transfer.parquet")
    write_json(log / "history" / "meta.json", meta(scene, []))


def note(log: Path, come: pd.DataFrame) -> None:
    """Append inserted spheres to the log at once, so that they are known even if the engine fails."""
    records = come[list(OF_COME.names or ())].to_records(index=False).astype(OF_COME)
    with open(log / "engine" / COME, "ab") as file:
        file.write(records.tobytes())


def ledger(log: Path) -> pd.DataFrame:
    """Return the ledger of a finished run, one row per output."""
    return read_table(log / "history" / "ledger.parquet")


def counts(log: Path) -> tuple[int, int]:
    """Return the numbers of formations and ruptures until the end of a finished run, which need not be an output."""
    last = ledger(log).iloc[-1]
    events = read_table(log / "history" / "events.parquet", columns=["step", "kind"])
    formed = events["kind"][events["step"] > last["step"]] == FORMATION
    return int(last["formations"] + formed.sum()), int(last["ruptures"] + (~formed).sum())


def logged(log: Path) -> bool:
    """Return whether the engine has opened its raw logs."""
    return (log / "engine" / LOGGED).exists()


def finish(log: Path) -> bool:
    """Collect the raw logs that a call left, if it was killed or its disk was full; return whether there were any."""
    if not logged(log):
        return False
    with run_folder.hold(log):
        if there := logged(log):
            collect(log, killed=ended_at_step(log) is None)
    return there


def collect(log: Path, killed: bool = False) -> None:
    """Convert the raw logs into tables and delete them; `killed`: the engine could not finish them."""
    with run_folder.hold(log):
        _collect(log, killed)


def _collect(log: Path, killed: bool) -> None:
    raw, history = log / "engine", log / "history"
    if killed:
        _cut(raw)
    come = pd.DataFrame(np.fromfile(raw / COME, OF_COME)).sort_values("id", ignore_index=True)
    write_table(come, history / "spheres.parquet")
    for name, rows in tables.converted(raw):
        tables.write(rows, history / f"{name}.parquet")
    for name in ("retired", "poses"):
        write_parts(map(tables.to_columns, tables.raw_parts(raw, name)), history / f"{name}.parquet")
    scene = dict(read_json(log / "scene.json", "run the script again"))
    _mesh_motion(log, [wall["name"] for wall in scene["walls"]])
    write_parts(_trajectory(raw), log / "trajectory.parquet")
    outputs = [int(step) for step in ledger(log)["step"]]
    count = come["type"].value_counts()
    for of in scene["classes"]:
        of["count"] = int(count.get(of["type"], 0))
    scene["duration_s"] = max([1, *outputs]) * scene["time_step_s"]
    scene["output"] = {**scene["output"], "interval_s": max([1, *np.diff(outputs).tolist()]) * scene["time_step_s"]}
    write_json(log / "scene.json", scene)
    meant = dict(read_json(history / "meta.json", "run the script again"))
    write_json(history / "meta.json", {**meant, "output_steps": outputs})
    noted = dict(read_json(log / SCRIPT, "run the script again"))
    contacts = read_table(history / "contacts.parquet", columns=["step"])["step"]
    last = max([0, *outputs, *contacts.tail(1)])
    write_json(log / SCRIPT, {**noted, "output_steps": outputs, "last_step": int(last)})
    for path in sorted(raw.glob("*.bin"), key=lambda path: path.name != LOGGED):  # the first marks that all are there
        path.unlink()


def _cut(raw: Path) -> None:
    """Cut the raw logs after the last output: of later records some were not written, and one only in part."""
    outputs = np.fromfile(raw / LOGGED, RAW["ledger"])["step"]
    for path in raw.glob("*.*.bin"):
        kind = RAW[path.name.partition(".")[0]]
        count = path.stat().st_size // kind.itemsize
        steps = np.memmap(path, kind, "r", shape=count)["step"] if count else outputs[:0]
        os.truncate(path, kind.itemsize * int(np.searchsorted(steps, outputs.max(initial=-1), "right")))


def _mesh_motion(log: Path, names: list[str]) -> None:
    """Return the displacement of the meshes at the outputs, from their position at the line of fix pywet."""
    if not names:
        empty = {name: np.zeros(0) for name in ("dx", "dy", "dz")}
        table = pd.DataFrame({"step": np.zeros(0, np.int64), "mesh": np.zeros(0, object), **empty})
        return write_table(table, log / "mesh_motion.parquet")
    poses = read_table(log / "history" / "poses.parquet")
    steps = read_table(log / "history" / "ledger.parquet", columns=["step"])["step"]
    rows = poses[poses["step"].isin(steps)].sort_values(["step", "mesh"])
    moved = {f"d{axis}": rows[f"shift_{axis}"] for axis in "xyz"}
    table = pd.DataFrame({"step": rows["step"], "mesh": [names[k] for k in rows["mesh"]], **moved})
    write_table(table.reset_index(drop=True), log / "mesh_motion.parquet")


def _trajectory(raw: Path) -> Iterator[dict[str, np.ndarray]]:
    for part in tables.raw_parts(raw, "states"):
        columns = tables.to_columns(tables.in_order(part, ["step", "id"]))
        names = {**{f"x_{a}": a for a in "xyz"}, **{f"{q}_{a}": f"{q}{a}" for q in "vw" for a in "xyz"}}
        found = {names.get(name, name): values for name, values in columns.items()}
        yield {**found, **{name: found[name].astype(np.int64) for name in ("id", "type")}}
