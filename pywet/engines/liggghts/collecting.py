"""Convert the raw files of a finished run into tables, in the folder `tables` of the engine's folder."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.engines import schedule
from pywet.engines.liggghts import deck, logs, windows
from pywet.engines.run_store import TABLES
from pywet.errors import NotWhole
from pywet.geometry.motion import Floats, engine_displacement
from pywet.runs import retired, tables
from pywet.scene import EngineScene, Slide, Vibration, WallMesh
from pywet.util.files import read_parts, read_table, write_parts, write_table

TRAJECTORY = ["id", "type", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]


def make(scene: EngineScene, folder: Path) -> tuple[int, float | None]:
    """Write all tables into `folder`/tables; returns the number of spheres and (moist) the ledger's error.

    Raises `NotWhole` if the raw files are incomplete.
    """
    made = folder / TABLES
    shutil.rmtree(made, ignore_errors=True)
    gone = retired.records(folder) if scene.removes else None
    at_rest = gone if scene.retire else None  # what left at an outlet is no longer there
    convert_trajectory(folder / logs.TRAJECTORY, made / "trajectory.parquet", scene.time_step_s, at_rest)
    trajectory = steps_of(made / "trajectory.parquet")
    empty = _empty(scene, trajectory, gone)
    planned(pd.concat([trajectory, pd.Series(empty[empty > trajectory.max()])]), scene, str(folder / logs.TRAJECTORY))
    windows.collect(scene, folder, made / "history", deck.touched(scene), empty.min(initial=scene.steps + 1))
    shifts = {wall.name: mesh_translations(scene, wall) for wall in scene.walls}
    rows = [(step, name, *of[k]) for k, step in enumerate(scene.output_steps) for name, of in shifts.items()]
    write_table(pd.DataFrame(rows, columns=["step", "mesh", "dx", "dy", "dz"]), made / "mesh_motion.parquet")
    spheres = int((trajectory == 0).sum())
    if gone is not None:
        write_table(tables.to_frame(gone), made / "history" / "retired.parquet")
    if not scene.effects.bridges:
        return spheres, None
    added = {}
    if gone is not None:
        added = dict.fromkeys(("films", "impulses"), partial(retired.with_films, retired=gone, empty=empty))
    tables.convert(folder, made / "history", more=added)
    for name in ("ledger", "films", *(["energy"] if scene.output.energy else [])):
        planned(steps_of(made / "history" / f"{name}.parquet"), scene, f"the log {name}")
    return spheres, tables.ledger_error(read_table(made / "history" / "ledger.parquet"))


def _empty(scene: EngineScene, trajectory: pd.Series, gone: np.ndarray | None) -> np.ndarray:
    """Return the output steps from the removal of the last sphere on, for which the engine writes no rows."""
    outputs = np.array(scene.output_steps, dtype=np.int64)
    if not scene.outlets or gone is None or len(gone) < int((trajectory == 0).sum()):
        return outputs[:0]
    return outputs[outputs >= gone["step"].max()]


def planned(steps: pd.Series, scene: EngineScene, what: str) -> None:
    """Raise `NotWhole` unless the steps of a table are the planned output steps."""
    wanted, there = scene.output_steps, sorted(int(s) for s in steps.unique())
    if there != wanted:
        missing, more = sorted(set(wanted) - set(there)), sorted(set(there) - set(wanted))
        wrong = f"lacks step {missing[0]}" if missing else f"has step {more[0]}, which is not one"
        raise NotWhole(
            f"{what} holds {len(there)} output steps and {wrong}; expected the {len(wanted)} from 0 to {wanted[-1]}: "
            "run the case again",
            code="run.steps", given=len(there), expected=len(wanted),
        )  # fmt: skip


def mesh_translations(scene: EngineScene, wall: WallMesh) -> Floats:
    """Return the displacement of a mesh from its STL file at the output steps [m], shape (outputs, 3)."""
    way, steps = scene.motion_of(wall), np.asarray(scene.output_steps)
    if isinstance(way, Vibration):
        return engine_displacement(way, steps, scene.time_step_s)
    if isinstance(way, Slide):
        begins, stops = schedule.slides(scene)[wall.name]
        moved = (np.clip(steps, begins, stops) - begins) * scene.time_step_s
        return np.asarray(moved[:, None] * np.asarray(way.velocity_m_per_s))
    return np.zeros((len(steps), 3))


def read_trajectory(path: Path, time_step: float) -> pd.DataFrame:
    """Read the engine's text dump as a table: step, time, id, type, x … wz."""
    return pd.concat(list(_trajectory(path, time_step)), ignore_index=True)


def convert_trajectory(path: Path, table: Path, time_step: float, gone: np.ndarray | None = None) -> None:
    """Convert a raw trajectory to a table, with the retired spheres (`gone`) at their last positions."""
    parts = _trajectory(path, time_step)
    write_parts(parts if gone is None else retired.with_places(parts, gone, time_step), table)


def _trajectory(path: Path, time_step: float) -> Iterator[pd.DataFrame]:
    for part in windows.dump_parts(path, TRAJECTORY):
        part = part.astype({"id": np.int64, "type": np.int64})
        part.insert(1, "time", part["step"] * time_step)
        yield part


def steps_of(path: Path) -> pd.Series:
    """Return the steps of a new table."""
    steps: pd.Series = pd.concat(list(read_parts(path, ["step"])))["step"]
    return steps
