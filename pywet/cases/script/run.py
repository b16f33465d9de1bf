"""Run a script with liquid: the engine reads it, and the plugin is set up at the line of fix pywet.

An error of the engine ends its process, as it ends the stock program; the parent process then converts the logs into tables.
"""

from __future__ import annotations

import ctypes as C
import json
import os
import signal
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet import run_folder
from pywet.cases.script import folder
from pywet.cases.script.hosts import HOSTS, refuse_ranks
from pywet.cases.script.refusals import of_box, of_state, refusal
from pywet.cases.script.scan import Found, scan
from pywet.cases.script.scene import Spheres, dry_walls, other_forces, reach, scene_of, surface, too_thick
from pywet.cases.script.wet import line
from pywet.ending import Ended, die_with_parent
from pywet.engines.liggghts.inputs import prepare_laws, transfer_tables
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.liggghts.worker import LINE_BUFFERED, plugin_rank
from pywet.errors import EngineError, border
from pywet.geometry import Surface
from pywet.runs import record
from pywet.runs.tables import ledger_error
from pywet.scene import EngineScene
from pywet.util.notices import notice


@dataclass(frozen=True)
class Outcome:
    """Result of a script: folder of its tables, bridges formed and ruptured until its end, relative error of the liquid ledger
    and step of its last output.
    """

    log: Path
    formed: int
    ruptured: int
    ledger_error: float
    last_output: int


def run(path: Path, words: list[str], say: Callable[[str], None], engine: str = "liggghts") -> Outcome | None:
    """Run the script; `words`: engine options such as -var and -log. None on all ranks but the first."""
    refuse_ranks(engine)
    found = scan(path, words, engine)
    if found.problems:
        raise found.problems[0]
    log = found.line.log
    first = plugin_rank() == 0
    if first and log.exists() and any(log.iterdir()):
        if folder.finish(log):
            notice.warning("the raw logs in %s, of a run that was cut off, were collected: pywet replay %s", log, log)
        raise refusal("wet.log", str(log))
    child = os.fork()
    if child == 0:
        die_with_parent()
        os._exit(_engine(found, path, words, say, engine))
    try:
        status = _exit_status(child)
    except KeyboardInterrupt as stop:
        if first and folder.logged(log):
            folder.collect(log, killed=True)
        left = f"its outputs are in {log}/history; to run it again, name another folder after `log`"
        raise Ended(Ended.of(stop).number, left if log.exists() else "nothing is written: call it again") from None
    if not first:
        raise SystemExit(status if status >= 0 else 128 - status)
    there = folder.logged(log)
    if there:
        folder.collect(log, killed=status != 0)  # also of an engine that a full disk has ended
    if status:
        tables = f"; tables until then are in {log}" if there else ""
        if status == REFUSED:  # its message is printed
            raise SystemExit(1)
        raise EngineError(
            f"the engine ended with {status} on {path}, see its last lines{tables}; expected a script that runs",
            code="wet.engine_ended", given=status, where=path,
        )  # fmt: skip
    if not there:
        raise refusal("wet.no_run", str(path))
    ledger = folder.ledger(log)
    formed, ruptured = folder.counts(log)
    return Outcome(log, formed, ruptured, ledger_error(ledger), int(ledger["step"].iloc[-1]))


def _exit_status(child: int) -> int:
    """Wait for the engine's process, which is killed if this one is interrupted."""
    try:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    except BaseException:
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
        raise


REFUSED = 3
"""Exit status of the engine's process if the script was refused."""


def _engine(found: Found, path: Path, words: list[str], say: Callable[[str], None], engine: str) -> int:
    """The engine's process: read the script, return its exit status."""
    for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(stop, signal.SIG_DFL)  # inside the engine there is no Python to answer
    libc = C.CDLL(None)
    libc.setvbuf(C.c_void_p.in_dll(libc, "stdout"), None, LINE_BUFFERED, 0)
    host = HOSTS[engine](words)
    plugin = host.plugin

    def guarded(what: Callable[[], Any]) -> Any:
        """Call a function from the engine, which cannot pass exceptions on: a refusal ends the process, with logs written."""
        try:
            with border(say=say if plugin_rank() == 0 else lambda sentence: None):
                return what()
        except SystemExit:
            plugin.finish()
            libc.fflush(None)
            os._exit(REFUSED)

    script = _Script(found, plugin, host.handle, guarded)
    callback = plugin.know_script(host.handle, lambda when: guarded(script.asked[when]))
    if error := host.read(path):
        print(error, file=sys.stderr, flush=True)
        plugin.finish()
        libc.fflush(None)
        return 1
    last = guarded(script.last)
    host.close()
    plugin.finish()
    guarded(lambda: script.end(last))
    del callback
    return 0


class _Script:
    """State of a LIGGGHTS script while its lines are executed."""

    def __init__(self, found: Found, plugin: Plugin, engine: C.c_void_p, guarded: Callable[..., Any]) -> None:
        self.wet, self.line = found.wet, found.line
        self._plugin, self._engine, self._guarded = plugin, engine, guarded
        self._spheres, self._meshes, self._surfaces = Spheres(found.wet), dict[str, str](), list[Surface]()
        self._time_step = self._thickest = 0.0
        self._gravity: list[float] = []
        self._periodic: list[float] = []
        self._log: Path | None = None
        self._lock = ExitStack()
        self.asked = {b"line": self._at_line, b"run": self.check, b"begin": self.begin}

    def _at_line(self) -> None:
        """Compare the line of the engine, which follows jumps and knows all variables, with that of the text."""
        if (read := line(self._plugin.script_words())) != self.line:
            raise refusal("wet.line", str(read), str(self.line))
        self._state()

    def _state(self) -> dict[str, Any]:
        state: dict[str, Any] = json.loads(self._plugin.script_state())
        for problem in of_state(state, self.wet.walls):
            raise problem
        return state

    def begin(self) -> None:
        """Start the first run: store the poses of the meshes at this time, and the inserted spheres."""
        state, plugin = self._state(), self._plugin
        table = self._spheres.take_in(plugin.script_spheres(int(state["spheres"])), int(state["step"]))
        if table["id"].tolist() != list(range(1, len(table) + 1)):
            raise refusal("wet.ids")
        self._long_enough(state)
        self._periodic = [float(length) for length in state["periodic"]]
        self._meshes = self._wet_meshes(state)
        fixes = {fix["id"]: fix for fix in state["fixes"]}
        surfaces = [surface(n, plugin.script_triangles(n, fixes[n]["triangles"])) for n in self._meshes]
        self._time_step = float(state["time_step"])
        self._gravity = [float(g) for g in state["gravity"]]
        scene = scene_of(self.wet, self._time_step, self._spheres, surfaces, self._gravity)
        skin, self._thickest = reach(self._spheres, state)
        self._log = self.line.log.resolve()
        raw = self._log / "engine"
        if plugin_rank() == 0:
            noted: dict[str, Any] = {"restored": bool(state["restored"]), "other_forces": other_forces(state)}
            noted |= {
                "window_steps": self.line.windows,
                "dry_walls": dry_walls(state, self.wet),
                "periodic_m": self._periodic,
            }
            self._lock.enter_context(run_folder.hold(self._log))  # until this process ends
            folder.begin(self._log, surfaces, scene, noted)
            record.leave_reference(self._log, self.wet.laws.reference)
        self._note(scene, table)
        raw.mkdir(parents=True, exist_ok=True)
        prepare_laws(scene)
        plugin.configure(scene, table, transfer_tables(scene), {s.name: s.corners for s in surfaces})
        plugin.set_every(self.line.every, int(state["step"]), skin, self._thickest)
        plugin.set_script(self.line.windows, lambda rows, step: self._guarded(lambda: self._enter(rows, step)))
        self._surfaces = surfaces
        plugin.attach(self._engine, raw, self.line.name)
        plugin.resume_script(int(state["restored"]))

    def _long_enough(self, state: dict[str, Any]) -> None:
        for problem in of_box(state["periodic"], float(state["reach"]), float(state["skin"])):
            raise problem

    def _wet_meshes(self, state: dict[str, Any]) -> dict[str, str]:
        """Return the meshes that carry liquid, and the engine's mesh that each corresponds to."""
        return {fix["id"]: fix["is"] for fix in state["fixes"] if "is" in fix and fix["id"] in self.wet.wet_walls}

    def _enter(self, rows: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
        """Register inserted spheres."""
        known, scene = len(self._spheres.classes), None
        table = self._spheres.take_in(rows, step)
        if (thick := too_thick(table, self._thickest)) is not None:
            raise refusal("wet.film", thick)
        if len(self._spheres.classes) > known:
            scene = scene_of(self.wet, self._time_step, self._spheres, self._surfaces, self._gravity)
            prepare_laws(scene)
            self._plugin.add_classes(scene, known, transfer_tables(scene))
        self._note(scene, table)
        return table["type"].to_numpy(), table["film"].to_numpy()

    def _note(self, scene: EngineScene | None, come: pd.DataFrame) -> None:
        """Log inserted spheres, and the scene if it has changed."""
        if self._log and plugin_rank() == 0:
            if scene:
                folder.write_scene(self._log, scene)
            folder.note(self._log, come)

    def last(self) -> int:
        """Return the last step of the script, which need not be an output; on all ranks: the engine compares their radii."""
        return int(json.loads(self._plugin.script_state())["last"]) if self._log else -1

    def end(self, last: int) -> None:
        """Note the last step of the script, whose logs are complete."""
        if self._log and plugin_rank() == 0:
            folder.note_end(self._log, last)
            for k in self._spheres.unused:
                notice.warning("%s: entry %d of first_films applied to no sphere", self.line.liquid, k)

    def check(self) -> None:
        """Check the state of the engine at the start of a run."""
        state = self._state()
        if not self._log:
            return
        if state["time_step"] != self._time_step:
            raise refusal("wet.time_step", state["time_step"], self._time_step)
        if state["periodic"] != self._periodic:
            was, now = (max(lengths) for lengths in (self._periodic, state["periodic"]))
            raise refusal("wet.box", now, was)
        self._long_enough(state)
        others = other_forces(state)
        if state["gravity"] != self._gravity:
            others.append("gravity that changes between runs")
        if others and plugin_rank() == 0:  # so that no replay assumes them to be known
            folder.note_forces(self._log, others)
        if state["last"] not in (-1, state["step"]):
            raise refusal("wet.step", state["step"], state["last"])
        now = self._wet_meshes(state)
        if lost := [name for name, which in self._meshes.items() if now.get(name) != which]:
            raise refusal("wet.lost_wall", lost[0])
