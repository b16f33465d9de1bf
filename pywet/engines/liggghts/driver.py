"""Run a prepared scene in LIGGGHTS and convert its output into tables.

A dry scene runs on the stock program; a moist one, or one whose wires are analytic, in worker.py with the plugin. Everything is
written into `engine.partial` first and renamed when the run is complete, so a failed run never looks like a finished one.
If `engine.partial` contains a complete checkpoint of the same scene, the run resumes from there.
"""

from __future__ import annotations

import shlex
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pywet import run_folder, run_lock
from pywet.engines.liggghts import checkpoint, collecting, deck
from pywet.engines.liggghts.build import ENGINE_VERSION, plugin_path
from pywet.engines.liggghts.inputs import write_inputs
from pywet.engines.liggghts.process import LOOP_TIME, execute
from pywet.engines.process import Usage, alone, installed, progress_bar
from pywet.errors import EngineError, NotWhole, PywetError
from pywet.planning import time_steps
from pywet.runs import tables
from pywet.scene import EngineScene
from pywet.util.files import read_if_there, read_table, write_json
from pywet.util.notices import notice

PROGRAM = "liggghts"
MPIRUN = ("mpirun", "--allow-run-as-root", "--bind-to", "none", "--oversubscribe")
DIES_WITH_MPIRUN = ("setpriv", "--pdeathsig", "KILL")
"""Command of util-linux without which ranks of the stock program continue for a second after mpirun was killed."""


@dataclass(frozen=True)
class RunInfo:
    """Result of the engine's run, also written to engine/run.json."""

    wall_s: float
    steps: int
    spheres: int
    ranks: int
    engine_version: str
    plugin_hash: str | None
    resumed_at_step: int | None
    """Step of the checkpoint from which this run resumed; None if it started from the beginning. `wall_s` counts from there."""
    ledger_error: float | None
    """|Σ films + Σ bridges + Σ walls + left − initial| / initial, the largest over all outputs; None for a dry run."""
    engine: str = "LIGGGHTS"
    cpu_s: float = 0.0
    """Processor time of the engine's process (with more ranks: of all of them)."""
    loop_cpu_s: float | None = None
    """Processor time of the time steps alone, without Python's start and the compilation of laws; None if not known."""
    peak_memory_B: int | None = None
    """Largest resident memory of the engine's process (not known for several ranks)."""


@dataclass(frozen=True)
class Task:
    """Parameters of one call: what is to be run, where and how."""

    scene: EngineScene
    run_dir: Path
    folder: Path
    mark: str
    ranks: int
    progress: bool
    launch: Callable[..., Usage]
    mpi: str
    deck: dict[str, Any]


def run(
    run_dir: Path,
    ranks: int = 1,
    progress: bool = True,
    *,
    extra: tuple[str, ...] = (),
    integrate: str = "all",
    allow_unstable: bool = False,
    launch: Callable[..., Usage] = execute,
    keep: bool = False,
    mpi: str = "",
    extend: Callable[[Path, EngineScene], EngineScene | None] | None = None,
) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` for a time step that would be unstable, unless `allow_unstable`.
    `extra` deck lines and the `integrate` group are used by driven small scenes (two bodies at constant speed);
    `launch` starts the engine's process and waits for it. With `keep` a finished run of the same scene with unchanged
    tables is not repeated. `mpi` is the command before `-n RANKS` that starts the ranks in a cluster's job over several
    nodes. `extend` is called with the engine's folder and the scene at the engine's end, and returns the scene with more
    blocks, or None.
    """
    run_dir = Path(run_dir).resolve()
    with alone(run_dir):
        scene = EngineScene.read(run_dir / "scene.json")
        version = _check_engine(ranks, shlex.split(mpi) or MPIRUN)
        if not allow_unstable:
            time_steps.refuse_unstable(scene)
        attached = deck.attached(scene)
        plugin = plugin_path() if attached else None
        folder = run_dir / "engine.partial"
        mark = checkpoint.fingerprint(run_dir, scene, version, plugin.name if plugin else "", *extra, integrate)
        task = Task(
            scene, run_dir, folder, mark, ranks, progress, launch, mpi, {"extra": extra, "integrate": integrate}
        )
        fixed = {"engine_version": version, "plugin_hash": plugin.stem.removeprefix("libpywet-") if plugin else None}
        done = collecting.finished_run(run_dir, mark) if keep else None
        if done:
            write_inputs(scene, run_dir)
            collecting.tidy(run_dir / "engine")
            notice.info(f"{scene.name}: was simulated already; remove {run_dir / 'engine'} to do it again")
            return RunInfo(**done)
        account, damaged = checkpoint.finished(folder, mark)
        if account is None:
            account = _simulate(task, [damaged] if damaged else [])
        else:
            write_inputs(scene, run_dir)
            notice.info(f"{scene.name}: the engine had come to its end; its output is collected")
        while extend and (longer := extend(folder, task.scene)):
            checkpoint.reopen(folder)
            write_json(run_dir / "scene.json", longer.model_dump(mode="json"))
            task = replace(task, scene=longer)
            account = _together(account, _simulate(task, []))
        return _collect(task, {**fixed, **account})


def _together(account: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    """Combine the account of a run with that of the blocks by which it was extended."""
    sums = {
        key: None if account[key] is None or more[key] is None else account[key] + more[key]
        for key in ("wall_s", "cpu_s", "loop_cpu_s")
    }
    peaks = [account["peak_memory_B"], more["peak_memory_B"]]
    return {**account, **sums, "peak_memory_B": None if None in peaks else max(peaks)}


def _simulate(task: Task, passed: list[str]) -> dict[str, Any]:
    """Run the engine from the latest intact checkpoint, or from the start; return data that only this process knows."""
    scene, folder = task.scene, task.folder
    run_folder.refuse_foreign(task.run_dir, "engine")
    point = _begin(task, passed)
    if not collecting.belongs(task.run_dir, task.mark):
        tables.forget(task.run_dir)
    spheres = len(read_table(task.run_dir / scene.spheres_file))
    recorder = checkpoint.Recorder(folder, scene, deck.attached(scene), spheres, point)
    started = time.monotonic()
    with progress_bar(scene, task.progress) as report:
        try:

            def watch() -> None:
                run_lock.check_held(task.run_dir)
                recorder.watch()

            usage = task.launch(_command(task, point.step if point else 0), folder, scene, report, watch)
        except PywetError:
            if point and checkpoint.unread(folder):
                checkpoint.drop(folder, point)
            raise
    account = {
        "wall_s": time.monotonic() - started,
        "ranks": task.ranks,
        "resumed_at_step": point.step if point else None,
        "cpu_s": usage.cpu_s,
        "loop_cpu_s": _loop_cpu(folder, scene, usage),
        "peak_memory_B": usage.peak_memory_B if task.ranks == 1 else None,
    }
    checkpoint.finish(folder, recorder.finish(), account)
    return account


def _collect(task: Task, known: dict[str, Any]) -> RunInfo:
    """Make the tables and run.json of a run whose engine has finished."""
    try:
        spheres, error = collecting.make(task.scene, task.folder)
    except NotWhole:
        checkpoint.disown(task.folder)
        raise
    info = RunInfo(steps=task.scene.steps, spheres=spheres, ledger_error=error, **known)
    collecting.publish(task.run_dir, task.folder, asdict(info), task.mark)
    return info


def _loop_cpu(folder: Path, scene: EngineScene, usage: Usage) -> float | None:
    """Return the processor time of the steps: the worker's own record; for the stock program nearly all of its time."""
    if not deck.attached(scene):
        return usage.cpu_s
    pieces = read_if_there(folder / LOOP_TIME) or []
    return sum(piece["run_s"] + piece["checkpoint_s"] for piece in pieces) if pieces else None


def _begin(task: Task, passed: list[str]) -> checkpoint.Checkpoint | None:
    """Prepare a folder for the engine: truncated to the latest complete checkpoint of the same scene, or a new one.

    A refusal here (spheres, laws) leaves an unfinished run in the folder unchanged.
    """
    scene, folder = task.scene, task.folder
    point, damaged = checkpoint.find(folder, task.mark)
    passed = passed + damaged
    ready = folder if point else folder.with_name("engine.partial.new")
    if point is None:
        run_folder.make_folder(task.run_dir, ready.name)
        checkpoint.start(ready, task.mark)
    deck.write_deck(scene, task.run_dir, ready, resume=point, ranks=task.ranks, **task.deck)
    write_inputs(scene, task.run_dir)
    why = f"; passed over: {', '.join(passed[:3])}{' and older ones' if passed[3:] else ''}" if passed else ""
    if point is None:
        run_folder.remove_folder(task.run_dir, folder.name)
        run_folder.rename_folder(task.run_dir, ready.name, folder.name)
        if passed:
            notice.warning(f"{scene.name}: begins anew{why}")
    else:
        checkpoint.cut_back(folder, point)
        if task.progress or passed:
            notice.info(f"{scene.name}: goes on from its checkpoint at step {point.step} of {scene.steps}{why}")
    return point


def _check_engine(ranks: int, mpi: Sequence[str]) -> str:
    version = installed("LIGGGHTS", ENGINE_VERSION, "make setup")
    if ranks > 1 and shutil.which(mpi[0]) is None:
        raise EngineError(
            f"{ranks} ranks were asked for but there is no {mpi[0]}; expected mpirun of openmpi-bin (run `make setup`), or "
            f"srun within a job of SLURM",
            code="engine.no_mpirun", key="ranks", given=ranks,
        )  # fmt: skip
    return version


def _command(task: Task, done: int) -> list[str]:
    if deck.attached(task.scene):
        # -P: it works in the run directory, where nothing may be taken for a module
        program = [sys.executable, "-P", "-m", "pywet.engines.liggghts.worker", str(task.run_dir), str(task.folder)]
        program += [str(done), str(task.ranks)]
    else:
        program = ["stdbuf", "-oL", PROGRAM, "-in", "in.liggghts", "-log", "log.liggghts"]  # an abort flushes nothing
    if task.ranks > 1:
        return [*(shlex.split(task.mpi) or MPIRUN), "-n", str(task.ranks), *DIES_WITH_MPIRUN, *program]
    return program
