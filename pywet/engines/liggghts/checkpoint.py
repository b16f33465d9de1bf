"""Checkpoints of a run: completeness, choice of the one to resume from, truncation of the logs to it.

`engine.partial/checkpoint/` holds `engine.<step>` (LIGGGHTS' restart file: spheres, contact histories, mesh
positions), in a run with the plugin `state.<step>` (its films, bridges, springs, work done, forces), and
`sums.<step>.json`: sizes and check sums of both and of the logs up to that step, written last, by the
process that monitors the engine. A run resumes only from files that agree with their sums.
"""

from __future__ import annotations

import re
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pywet.engines.liggghts import logs, state_file
from pywet.engines.liggghts.restart_file import holds
from pywet.engines.process import OUTPUT
from pywet.engines.run_store import CHECKPOINTS, FINISHED
from pywet.errors import PywetError
from pywet.scene import EngineScene

PARTIAL = ".partial"
"""Suffix of files that may be incomplete."""
LOG = "log.liggghts"
MESSAGES_B = 65536
"""Upper bound on the engine's messages when it is set up again at a checkpoint."""
REFUSAL = re.compile(r"^ERROR(?!.*\bCannot open ).*\bread_restart\.cpp:\d+", re.MULTILINE)
"""Message of the part of the engine that reads restart files, unless the file could not be opened."""
STORED = 2
"""Number of stored checkpoints."""
WRITTEN_S = 10.0
"""Time [s] without a change, by a monotonic clock, after which a restart file counts as completely written."""


@dataclass(frozen=True)
class Checkpoint:
    """Complete files of one step; `state` is None without the plugin, `logs` are the digests of the logs up to that step."""

    step: int
    engine: Path
    state: Path | None
    logs: logs.Sums


def saved(name: str, step: object, whole: bool = True) -> str:
    """Return the path of the state of the engine (`engine`) or plugin (`state`), or of their sums; partial until `whole`."""
    return f"{CHECKPOINTS}/{name}.{step}{'' if whole else PARTIAL}"


def find(folder: Path) -> tuple[Checkpoint | None, list[str]]:
    """Return the latest complete checkpoint in a folder; None if there is none.

    Also return a phrase for each later one that is skipped because a part of it is missing or damaged.
    """
    passed: list[str] = []
    steps = {step for name, step, _ in _files(folder) if name in ("engine", "sums")}
    for step in sorted(steps, reverse=True):
        point = _read(folder, step)
        if isinstance(point, Checkpoint):
            return point, passed
        passed.append(f"step {step} ({point})")
    return None, passed


def latest(folder: Path) -> int:
    """Return the step of the latest checkpoint whose check sums are written; 0 if there is none."""
    return max((step for name, step, _ in _files(folder) if name == "sums"), default=0)


def _read(folder: Path, step: int) -> Checkpoint | str:
    """Return a checkpoint, or a phrase on what is wrong with it."""
    path = folder / CHECKPOINTS / f"sums.{step}.json"
    if not path.exists():
        return "without check sums"
    try:
        read = logs.read_signed(path)
        states, sums = (logs.sums_of(read[part]) for part in ("states", "logs"))
    except (PywetError, AttributeError, KeyError, TypeError, ValueError) as error:
        logs.refuse_unread(path, error)
        return f"{CHECKPOINTS}/{path.name} is damaged"
    engine, state = saved("engine", step), saved("state", step)
    if engine not in states:
        return f"{CHECKPOINTS}/{path.name} is damaged"
    broken = logs.damage(folder, states) or logs.damage(folder, sums, appended=True)
    return broken or Checkpoint(step, folder / engine, folder / state if state in states else None, sums)


def _files(folder: Path, ending: str = "") -> list[tuple[str, int, Path]]:
    """List name, step and path of the checkpoint files in a folder; `ending` selects those that may be incomplete."""
    return [
        (m[1], int(m[2]), path)
        for path in (folder / CHECKPOINTS).glob("*")
        if (m := re.fullmatch(rf"(engine|state|sums)\.(\d+)(\.json)?{re.escape(ending)}", path.name)) and path.is_file()
    ]


def last_step(folder: Path) -> int:
    """Return the last step in the engine's messages, which are written line by line, unlike its log."""
    path = folder / OUTPUT
    if not path.exists():
        return 0
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - MESSAGES_B))
        lines = file.read().decode(errors="replace").splitlines()
    steps = [int(m.group(1)) for line in lines if (m := re.match(r"^\s*(\d+)\s+\d+\s+\S+\s+\S+\s*$", line))]
    return steps[-1] if steps else 0


def cut_back(folder: Path, point: Checkpoint) -> None:
    """Remove everything after the checkpoint from the logs.

    The engine rewrites the trajectory's frame of that step, unless spheres of that frame were retired.
    """
    for path in logs.files(folder):
        with open(path, "r+b") as file:
            file.truncate(point.logs.get(path.name, (0, 0))[0])
    for _, step, path in _files(folder):
        if step > point.step:
            path.unlink()
    for path in (folder / CHECKPOINTS).glob(f"*{PARTIAL}"):
        path.unlink()
    (folder / FINISHED).unlink(missing_ok=True)
    log = folder / LOG
    if log.exists():
        log.replace(folder / f"log.until-{point.step}.liggghts")


def refused(folder: Path) -> bool:
    """Return whether the engine's messages are that the content of its restart file is wrong.

    An engine that was killed, or short of memory, descriptors or disk space, says nothing about the file.
    """
    return REFUSAL.search((folder / OUTPUT).read_text(errors="replace")) is not None


def drop(folder: Path, point: Checkpoint) -> None:
    """Exclude a checkpoint from any further resumption."""
    (folder / CHECKPOINTS / f"sums.{point.step}.json").unlink()
    point.engine.unlink()


class Recorder:
    """Computes the digests of a run in progress; `watch` is called a few times a second."""

    def __init__(self, folder: Path, scene: EngineScene, plugin: bool, spheres: int, point: Checkpoint | None) -> None:
        self.folder, self.plugin, self.spheres = folder, plugin, spheres
        self.planned, self.end, self.retires = scene.output_steps, scene.steps, scene.removes
        self.step = point.step if point else 0
        self.logs: logs.Sums = dict(point.logs) if point else {}
        self.framed = self._frames_before(self.step) if point else 0
        self.seen: dict[Path, tuple[int, float]] = {}

    def _frames_before(self, step: int) -> int:
        return int(np.searchsorted(self.planned, step, "right" if self.retires else "left"))

    def watch(self) -> None:
        """Write the digests of each checkpoint that has been completed since the last call, and remove all but the last two."""
        if not self.plugin:
            self._name_stock()
        there = {(name, step) for name, step, _ in _files(self.folder)}
        last = "state" if self.plugin else "engine"
        new = sorted(step for name, step in there if name == last and step > self.step)
        for step in new:
            states = [self.folder / saved(name, step) for name in ("engine", "state")[: 1 + self.plugin]]
            spheres = state_file.count(states[1]) if self.plugin else self.spheres
            if not holds(states[0].read_bytes(), spheres):
                for path in states:
                    path.unlink()  # cut off, as by a full disk
                continue
            until = self._frames_before(step)
            framed = step if self.retires else step - 1
            grown = logs.extended(self.folder, self.logs, step, self.planned[self.framed : until], framed)
            if isinstance(grown, str):
                if step < new[-1]:
                    raise self._not_whole(grown)
                return  # perhaps not yet there: looked at again
            sums = {f"{CHECKPOINTS}/{path.name}": logs.checked(path) for path in states}
            logs.write_signed(self.folder / CHECKPOINTS / f"sums.{step}.json", {"states": sums, "logs": grown})
            self.step, self.framed, self.logs = step, until, grown
            self._prune()

    def finish(self) -> logs.Sums:
        """Return the sums of all logs after the engine's end; PywetError if the logs are incomplete."""
        found = logs.extended(self.folder, self.logs, self.end, self.planned[self.framed :], self.end)
        if not isinstance(found, str):
            sizes = {path.name: path.stat().st_size for path in logs.files(self.folder)}
            longer = next((name for name, (size, _) in found.items() if sizes[name] != size), None)
            if longer is None:
                return found
            found = f"{longer} ends in the middle of a step"
        raise self._not_whole(found)

    def _not_whole(self, why: str) -> PywetError:
        return PywetError(
            f"{why}; expected the {len(self.planned)} planned output steps in "
            f"{self.folder} (was the disk full?): call again, the run resumes from its last complete checkpoint",
            code="checkpoint.steps", where=self.folder,
        )  # fmt: skip

    def _name_stock(self) -> None:
        """Rename the stock program's restart file once the engine has continued: only then is it complete, and the engine hangs
        on an incomplete one.
        """
        reached = last_step(self.folder)
        for name, step, path in _files(self.folder, PARTIAL):
            if name != "engine":
                continue
            if step < reached:
                path.rename(path.with_suffix(""))
            elif self._unchanged_s(path) > WRITTEN_S and not holds(path.read_bytes(), self.spheres):
                raise self._not_whole(f"{path} was cut off")

    def _unchanged_s(self, path: Path) -> float:
        """Return the time [s] for which a file has been seen unchanged."""
        size, seen = path.stat().st_size, time.monotonic()
        if path not in self.seen or self.seen[path][0] != size:
            self.seen[path] = size, seen
        return seen - self.seen[path][1]

    def _prune(self) -> None:
        files = _files(self.folder)
        oldest = sorted(step for name, step, _ in files if name == "sums")[-STORED:][0]
        for _, step, path in files:
            if step < oldest:
                path.unlink()
