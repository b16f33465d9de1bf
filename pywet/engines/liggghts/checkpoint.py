"""Checkpoints of a run: what they hold, which one a run may go on from, and how the logs are cut back to it.

`engine.partial/checkpoint/` holds pairs `engine.<step>` (LIGGGHTS' restart file: spheres, contact histories, mesh positions) and
`state.<step>` (the plugin's state: films, bridges, work done, forces). Each is written as `….partial` and renamed when both are
whole, the state last. `engine.partial/fingerprint.json` says which scene they belong to. A dry run has no state files; its
engine file counts as whole when the engine has gone on since.
"""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pywet.engines.liggghts import windows
from pywet.files import write_json
from pywet.history.schema import RAW
from pywet.scene import Scene

FOLDER = "checkpoint"
FINGERPRINT = "fingerprint.json"
LOG = "log.liggghts"


@dataclass(frozen=True)
class Checkpoint:
    """A whole pair of files at one step; `state` is None in a dry run."""

    step: int
    engine: Path
    state: Path | None


def fingerprint(run_dir: Path, scene: Scene, *parts: str) -> str:
    """Hash of everything a run follows from: scene, spheres, walls, films, and `parts` (plugin, deck lines)."""
    digest = hashlib.sha256()
    files = [run_dir / "scene.json", run_dir / scene.spheres_file]
    files += [run_dir / "history" / f"{name}.parquet" for name in ("spheres", "triangles")]
    files += [run_dir / wall.stl for wall in scene.walls]
    for path in files:
        digest.update(path.read_bytes() if path.exists() else b"-")
    for part in parts:
        digest.update(b"\0" + part.encode())
    return digest.hexdigest()


def start(folder: Path, mark: str) -> None:
    """Prepare a new run's folder for checkpoints of the scene with this fingerprint."""
    (folder / FOLDER).mkdir(parents=True)
    write_json(folder / FINGERPRINT, {"fingerprint": mark})


def find(folder: Path, mark: str, moist: bool) -> Checkpoint | None:
    """The latest whole checkpoint of the same scene; None where there is none."""
    path = folder / FINGERPRINT
    try:
        if json.loads(path.read_text())["fingerprint"] != mark:
            return None
    except (OSError, ValueError, KeyError):
        return None
    found = _moist(folder / FOLDER) if moist else _dry(folder)
    return max(found, key=lambda c: c.step, default=None)


def _moist(folder: Path) -> list[Checkpoint]:
    found = []
    for state in folder.glob("state.*"):
        engine = folder / state.name.replace("state", "engine")
        if state.suffix[1:].isdigit() and engine.exists() and _intact(state):
            found.append(Checkpoint(int(state.suffix[1:]), engine, state))
    return found


def _dry(folder: Path) -> list[Checkpoint]:
    reached = last_step(folder / LOG)
    found = []
    for path in (folder / FOLDER).glob("engine.*.partial"):
        step = int(path.name.split(".")[1])
        if step < reached:
            found.append(Checkpoint(step, path, None))
    return found


def _intact(state: Path) -> bool:
    """Whether a state file's check sum (CRC-32, its last four bytes) is right."""
    data = state.read_bytes()
    return len(data) > 4 and zlib.crc32(data[:-4]) == int.from_bytes(data[-4:], "little")


def last_step(log: Path) -> int:
    """Last step that the engine's thermo output shows; reads only the end of the log."""
    if not log.exists():
        return 0
    with open(log, "rb") as file:
        file.seek(max(0, log.stat().st_size - 4096))
        lines = file.read().decode(errors="replace").splitlines()
    steps = [int(m.group(1)) for line in lines if (m := re.match(r"^\s*(\d+)\s+\d+\s+\S+\s+\S+\s*$", line))]
    return steps[-1] if steps else 0


def cut_back(folder: Path, step: int, output_every: int) -> None:
    """Take everything after `step` out of the logs; the trajectory's frame at `step` is written again by the engine."""
    for name, dtype in RAW.items():
        for path in folder.glob(f"{name}.*.bin"):
            whole = path.stat().st_size // dtype.itemsize
            steps = np.fromfile(path, dtype=dtype, count=whole)["step"] if whole else np.zeros(0, dtype=np.int64)
            with open(path, "r+b") as file:
                file.truncate(int((steps <= step).sum()) * dtype.itemsize)
    for path in (folder / FOLDER).iterdir():
        if int(path.name.split(".")[1]) > step:
            path.unlink()
    _cut_trajectory(folder / "trajectory.txt", step - 1 if step % output_every == 0 else step)
    for name in (windows.STATES, *windows.SPRINGS):
        _cut_trajectory(folder / f"{name}.txt", step)
    log = folder / LOG
    if log.exists():
        log.replace(folder / f"log.until-{step}.liggghts")


def prune(folder: Path, keep: int = 3) -> None:
    """Leave the files of the last few checkpoints."""
    step_of = {path: int(path.name.split(".")[1]) for path in (folder / FOLDER).iterdir()}
    last = sorted(set(step_of.values()))[-keep:]
    for path, step in step_of.items():
        if step not in last:
            path.unlink(missing_ok=True)


def _cut_trajectory(path: Path, last: int) -> None:
    """Keep the whole frames up to step `last` of the engine's dump."""
    if not path.exists():
        return
    with open(path, "r+b") as dump:
        while True:
            begin = dump.tell()
            head = [dump.readline() for _ in range(9)]
            if not head[8].endswith(b"\n") or int(head[1]) > last:
                break
            count = int(head[3])
            rows = [dump.readline() for _ in range(count)]
            if count and not rows[-1].endswith(b"\n"):
                break
        dump.truncate(begin)
