"""Convert the raw files of a finished run into tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from pywet.engines import schedule
from pywet.engines.liggghts import contact_model, creation, logs, windows
from pywet.errors import NotWhole
from pywet.geometry.motion import translations
from pywet.runs import retired, tables
from pywet.scene import EngineScene

Part = TypeVar("Part", pd.DataFrame, dict[str, np.ndarray])
TRAJECTORY = ["id", "type", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]


def make(scene: EngineScene, folder: Path, put: Callable[[str, tables.Rows], None]) -> int:
    """Pass every table with its path to `put`, made from the raw files in `folder`; returns the number of spheres.

    Raises `NotWhole` if the raw files are incomplete.
    """
    gone = retired.records(folder) if scene.removes else None
    coming, outputs = creation.ToCome(scene, folder.parent, gone), np.array(scene.output_steps)
    parts, seen = trajectory_parts(folder / logs.TRAJECTORY, scene.time_step_s), Counter[int]()
    nobody = coming.nobody(outputs)
    parts = coming.in_motion(parts, nobody)
    if gone is not None and scene.retire:  # what left at an outlet is no longer there
        parts = retired.with_places(parts, gone, scene.time_step_s, nobody)
    put("trajectory", _counted(parts, seen))
    planned({*seen, *nobody.tolist()}, scene, str(folder / logs.TRAJECTORY))
    for name, table in windows.collect(scene, folder, schedule.recorded(scene), contact_model.touched(scene), coming):
        put(name, table)
    shifts = translations(scene).items()
    rows = [(step, name, *of[k]) for k, step in enumerate(scene.output_steps) for name, of in shifts]
    put("mesh_motion", pd.DataFrame(rows, columns=["step", "mesh", "dx", "dy", "dz"]))
    added = {}
    if gone is not None:
        put("history/retired", tables.to_frame(gone))
        empty = coming.nobody(outputs, leaving=True)

        def whole(records: Iterator[np.ndarray]) -> Iterator[np.ndarray]:
            return retired.with_films(coming.in_records(records, empty), gone, empty[empty > coming.last])

        added = dict.fromkeys(("films", "impulses"), whole)
    at_outputs = ("ledger", "films", *(["energy"] if scene.output.energy else []))
    for name, of in tables.converted(folder, more=added) if scene.effects.bridges else ():
        steps = Counter[int]()
        put(f"history/{name}", _counted(of, steps))
        if name in at_outputs:
            planned(steps, scene, f"the log {name}")
    return seen[0]


def _counted(parts: Iterable[Part], rows: Counter[int]) -> Iterator[Part]:
    """Yield the parts of a table and count their rows by step."""
    for part in parts:
        rows.update(
            dict(zip(*(values.tolist() for values in np.unique(part["step"], return_counts=True)), strict=True))
        )
        yield part


def planned(steps: Iterable[int], scene: EngineScene, what: str) -> None:
    """Raise `NotWhole` unless the steps of a table are the planned output steps."""
    wanted, there = scene.output_steps, sorted({int(step) for step in steps})
    if there != wanted:
        missing, more = sorted(set(wanted) - set(there)), sorted(set(there) - set(wanted))
        wrong = f"lacks step {missing[0]}" if missing else f"has step {more[0]}, which is not one"
        raise NotWhole(
            f"{what} holds {len(there)} output steps and {wrong}; expected the {len(wanted)} from 0 to {wanted[-1]}: "
            "run the case again",
            code="run.steps", given=len(there), expected=len(wanted),
        )  # fmt: skip


def trajectory_parts(path: Path, time_step: float) -> Iterator[pd.DataFrame]:
    """Read the engine's text dump as a table, part by part: step, time, id, type, x … wz."""
    for part in windows.dump_parts(path, TRAJECTORY):
        part = part.astype({"id": np.int64, "type": np.int64})
        part.insert(1, "time", part["step"] * time_step)
        yield part
