"""Run a batch in the engine, replay it, and report the outcome of every cell.

A cell that stops the run by a guard is recorded and removed, and the others run again. The engine's processes are
forked from a server with all modules imported and compiled, so that a run of a few milliseconds does not wait for
seconds of start-up.
"""

from __future__ import annotations

import multiprocessing as mp
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pywet import run_folder
from pywet.ending import die_with_parent
from pywet.engines.liggghts import driver, process
from pywet.engines.process import Usage
from pywet.errors import PywetError, StoppedRun
from pywet.scene import EngineScene
from reference_impl.replay.replay import replay as recompute
from studies.stability import cells, judge
from studies.stability.cells import Batch

PRELOAD = ["studies.stability.warm"]


def _child(run_dir: str, folder: str, step: str, ranks: str) -> None:
    """Execute `python -m pywet.engines.liggghts.worker` in a forked process."""
    from pywet.engines.liggghts import worker

    log = os.open(str(Path(folder) / "output.log"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    die_with_parent()
    code = 0
    try:
        worker.run(Path(run_dir), Path(folder), int(step), int(ranks))
    except PywetError as error:
        os.write(2, f"ERROR: {error}\n".encode())
        code = 1
    os._exit(code)


def _forked(command: list[str], folder: Path, scene: EngineScene, report: Any, watch: Any = None) -> Usage:
    """Replacement of `process.execute` on one rank, without measuring its resource use."""
    if "pywet.engines.liggghts.worker" not in command or command[0] == "mpirun":
        return process.execute(command, folder, scene, report, watch or (lambda: None))
    server = mp.get_context("forkserver")
    server.set_forkserver_preload(PRELOAD)
    child = server.Process(target=_child, args=tuple(command[-4:]))
    child.start()
    child.join()
    if child.exitcode != 0:
        raise process.stopped(scene, folder, child.exitcode or 0)
    return Usage(0.0, None)


def run_cells(batch: Batch, run_dir: Path, allow_unstable: bool = False) -> tuple[Batch, dict[str, str]]:
    """Run until no guard stops the run.

    Returns the final batch, and the messages of the removed cells. A message that names no sphere is assigned to
    all cells.
    """
    stopped: dict[str, str] = {}
    while True:
        run_folder.discard(run_dir)
        cells.prepare(batch, run_dir)
        try:
            driver.run(run_dir, batch.ranks, progress=False, allow_unstable=allow_unstable, launch=_forked)
            return batch, stopped
        except PywetError as error:
            message, spheres = (error.reason, error.spheres) if isinstance(error, StoppedRun) else ("", ())
            name = batch.owner()[spheres[0]] if spheres else ""
            if not name or name in stopped:
                return batch, {**{c.name: message or str(error) for c in batch.cells}, **stopped}
            stopped[name] = message
            batch = batch.without({name})


def objected(batch: Batch, run_dir: Path) -> dict[str, str]:
    """Return the quantities in which the replay disagrees, by the cell of the worst record ("" if it names no sphere)."""
    message: dict[str, list[str]] = {}
    for name, q in recompute(run_dir)["quantities"].items():
        if not q["ok"]:
            cell = batch.owner()[int(q["worst"]["i"])] if q["worst"].get("i") else ""
            message.setdefault(cell, []).append(f"{name} off by {q['largest']:.1e} (limit {q['tolerance']:.0e})")
    return {cell: "; ".join(sentences) for cell, sentences in message.items()}


STOPPED = {"state": "stopped", "message": "", "ledger": 0.0, "made": 0.0, "allowed": 0.0, "events": 0}
"""Verdict of a cell that a guard stopped."""
PASSIVE = "lian"
"""Tangential law with one coefficient for sliding and spin, which is passive.

With two, as in Elskamp (28), (29), and a torque that is the force times its arm, a sphere that initially slides gains
energy.
"""


def by_the_law(batch: Batch, names: set[str], run_dir: Path, allow_unstable: bool) -> set[str]:
    """Return cells among `names` that create no energy with a passive tangential law: their energy is due to the law."""
    if batch.effects.viscous_tangential in (None, PASSIVE) or not names:
        return set()
    passive = replace(
        batch,
        effects=batch.effects.model_copy(update={"viscous_tangential": PASSIVE}),
        cells=tuple(c for c in batch.cells if c.name in names),
    )
    left, stopped = run_cells(passive, run_dir, allow_unstable)
    if len(stopped) == len(passive.cells):
        return set()
    verdicts = judge.verdicts(left, run_dir)
    return {name for name, v in verdicts.items() if v["state"] == "stable" and name not in stopped}


def judged(batch: Batch, run_dir: Path, allow_unstable: bool = False) -> pd.DataFrame:
    """Run a batch and judge every cell of it: one row a cell."""
    left, stopped = run_cells(batch, run_dir, allow_unstable)
    rows: list[dict[str, Any]] = []
    replayed, budget_errors, verdicts = {}, {"identity": 0.0, "drag": 0.0}, {}
    if len(stopped) < len(batch.cells):
        verdicts = judge.verdicts(left, run_dir)
        replayed, budget_errors = objected(left, run_dir), judge.budget(run_dir)
    verdicts |= {name: {**STOPPED, "message": message} for name, message in stopped.items()}
    made = {name for name, v in verdicts.items() if v["state"] == "energy"}
    explained = by_the_law(left, made, run_dir.with_name(run_dir.name + "-passive"), allow_unstable)
    for cell in batch.cells:
        v = verdicts[cell.name]
        objection = "; ".join(filter(None, [replayed.get(cell.name, ""), replayed.get("", "")]))
        state = v["state"] if v["state"] != "stable" or not objection else "replay"
        if state == "stable" and (budget_errors["identity"] > 1e-12 or budget_errors["drag"] > 1e-12):
            state = "energy"
        if state == "energy" and cell.name in explained and not objection:
            state = "law"
        rows.append({
            "case": cell.name, **v, "state": state, "replay": "" if v["message"] else objection or "agrees",
            "identity": budget_errors["identity"], **cell.says,
        })  # fmt: skip
    return pd.DataFrame(rows).drop(columns="raw", errors="ignore")
