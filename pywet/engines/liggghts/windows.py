"""Motion, forces and contact springs of all spheres in each step of the sampling windows: deck lines and tables.

They are dumps of the engine, made only in the windows; without `output.window_trajectories` the deck contains none.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from pyarrow import csv

from pywet.engines.liggghts.creation import ToCome
from pywet.engines.schedule import Window
from pywet.errors import NotWhole, one_line
from pywet.runs.tables import read_raw, to_frame
from pywet.scene import EngineScene

STATES = "states"
SPRINGS = ("pair_springs", "wall_springs")
COLUMNS: dict[str, list[str]] = {
    STATES: ["id", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "fx", "fy", "fz", "tx", "ty", "tz"],
    "pair_springs": ["i", "j", "image", "sx", "sy", "sz"],
    "wall_springs": ["mesh", "triangle", "i", "sx", "sy", "sz"],
}
"""Columns of each dump: position, velocity and spin after the step, force and torque in it; displacement of dry contacts."""
NEVER = 9.0e15


def next_step(windows: list[Window]) -> list[str]:
    """Return the engine's formula for the next output step after `step`, as terms, because it truncates long lines."""
    terms, before = [], -1
    for first, last in windows:
        terms.append(f"(step>={before})*(step<{first})*{first}+(step>={first})*(step<{last - 1})*(step+1)")
        before = last - 1
    return [*terms, f"(step>={before})*{NEVER:.0f}"]


def deck_lines(scene: EngineScene, windows: list[Window], touched: Sequence[str]) -> dict[str, Any] | None:
    """Return the values for the set-up's template, None without windows; `touched`: walls whose contacts the engine computes."""
    if not windows:
        return None
    motion = ["id", "x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz"]
    words = [*motion, "fx", "fy", "fz", "tqx", "tqy", "tqz"]
    dumps = [{"name": STATES, "style": "custom", "columns": " ".join(words), "format": "%d" + " %.17g" * 15}]
    springs = SPRINGS if touched else SPRINGS[:1]
    for name in springs if scene.effects.tangential_history else ():
        columns = " ".join(f"c_{name}[{k}]" for k in range(1, 7))
        dumps.append({"name": name, "style": "local", "columns": columns, "format": "%.0f %.0f %.0f %.17g %.17g %.17g"})
    return {"next_step": next_step(windows), "first": windows[0][0] == 0, "dumps": dumps, "springs": len(dumps) > 1}


def read_dump(path: Path, columns: list[str]) -> pd.DataFrame:
    """Read all frames of one of the engine's text dumps, with a column `step`."""
    return pd.concat(list(dump_parts(path, columns)), ignore_index=True)


def dump_parts(path: Path, columns: list[str], most_bytes: int = 1 << 25) -> Iterator[pd.DataFrame]:
    """Read a dump of the engine some frames at a time; at least one part is returned."""
    steps, counts, text, given = [], [], bytearray(), False
    try:
        with open(path, "rb") as dump:
            while dump.readline():
                head = list(islice(dump, 8))
                steps.append(int(head[0]))
                counts.append(int(head[2]))
                lines = list(islice(dump, counts[-1]))
                if len(lines) != counts[-1] or not (not lines or lines[-1].endswith(b"\n")):
                    raise IndexError
                text += b"".join(lines)
                if len(text) > most_bytes:
                    yield _frames(text, steps, counts, columns)
                    steps, counts, text, given = [], [], bytearray(), True
        if text or not given:
            yield _frames(text, steps, counts, columns)
    except IndexError as error:
        raise NotWhole(
            f"{path} ends in the middle of a step; the run was cut off: run the case again",
            code="run.dump_cut_off", where=path,
        ) from error  # fmt: skip
    except (ValueError, OverflowError) as error:  # of int, of a step beyond 64 bits, of the reader's, of too few rows
        raise NotWhole(
            f"{path} is not the engine's dump ({one_line(error)}): run the case again", code="run.dump", where=path
        ) from error


def _frames(text: bytearray, steps: list[int], counts: list[int], columns: list[str]) -> pd.DataFrame:
    """Return the rows of some frames as a table."""
    if not text:
        return pd.DataFrame({"step": np.zeros(0, dtype=np.int64), **{c: np.zeros(0) for c in columns}})
    end = ["end of line"] if text.endswith(b" \n") else []
    table = csv.read_csv(
        io.BytesIO(text),
        csv.ReadOptions(column_names=[*columns, *end]),
        csv.ParseOptions(delimiter=" "),
        csv.ConvertOptions(include_columns=columns, column_types=dict.fromkeys(columns, pa.float64())),
    ).to_pandas()
    table.insert(0, "step", np.repeat(np.array(steps, dtype=np.int64), counts))
    return table


def wall_springs(scene: EngineScene, folder: Path, touched: Sequence[str]) -> pd.DataFrame:
    """Return the tangential displacements of wall contacts, of the engine for `touched` walls and of the plugin.

    Meshes are numbered as in the scene.
    """
    path, springs = folder / "wall_springs.txt", []
    if path.exists():
        meshes = np.array([k for k, w in enumerate(scene.walls) if w.name in touched])
        table = read_dump(path, COLUMNS["wall_springs"])
        springs.append(table.assign(mesh=meshes[table["mesh"].astype(np.int64)]))
    if len(touched) < len(scene.walls):
        of_wires = to_frame(read_raw(folder, "wire_springs"))
        springs.append(of_wires.set_axis(["step", *COLUMNS["wall_springs"]], axis=1))
    return pd.concat(springs, ignore_index=True)


def collect(
    scene: EngineScene, folder: Path, windows: Sequence[Window], touched: Sequence[str], coming: ToCome
) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield path and table of each dump in `folder`, `history/window_<name>`; `windows` and `touched` as in `deck_lines`.

    `coming`: spheres that the engine does not hold at first.
    """
    plugin = scene.effects.tangential_history and len(touched) < len(scene.walls)
    for name in (STATES, *SPRINGS) if windows else ():
        path = folder / f"{name}.txt"
        if not path.exists() and not (name == "wall_springs" and plugin):
            continue
        table = wall_springs(scene, folder, touched) if name == "wall_springs" else read_dump(path, COLUMNS[name])
        table = table.drop_duplicates(["step", *COLUMNS[name][:3]], keep="last")
        steps = np.array([step for window in windows for step in range(*window)])
        nobody = coming.nobody(steps)
        wanted = np.setdiff1d(steps, nobody).tolist()
        if name == STATES and table["step"].drop_duplicates().sort_values().tolist() != wanted:
            raise NotWhole(
                f"{path} does not hold the {len(wanted)} steps of the windows: run the case again",
                code="run.windows", where=path,
            )  # fmt: skip
        if name == STATES:
            table = coming.motion(table, nobody)
        whole = [c for c in ("step", "id", "i", "j", "image", "mesh", "triangle") if c in table]
        yield f"history/window_{name}", table.astype(dict.fromkeys(whole, np.int64))
