"""Run a prepared scene in LIGGGHTS: prepare -> job, simulate -> raw logs; `pipeline.collect` converts these into tables.

A dry scene runs on the stock program; a moist one, or one whose wires are analytic, in worker.py with the plugin.
If `engine.partial` contains a complete checkpoint of the same scene, the run resumes from there.
"""

from __future__ import annotations

import shlex
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pywet.engines.liggghts import checkpoint, deck
from pywet.engines.liggghts.build import ENGINE_VERSION, plugin_path
from pywet.engines.liggghts.contact_model import attached
from pywet.engines.liggghts.inputs import write_inputs
from pywet.engines.liggghts.process import LOOP_TIME, execute
from pywet.engines.pipeline import Job, Raw, RunInfo, collect
from pywet.engines.process import Usage, installed, progress_bar
from pywet.errors import EngineError, PywetError
from pywet.planning import time_steps
from pywet.run_folder import alone, check_held
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import read_if_there, write_json
from pywet.util.notices import notice

PROGRAM = "liggghts"
MPIRUN = ("mpirun", "--allow-run-as-root", "--bind-to", "none", "--oversubscribe")
DIES_WITH_MPIRUN = ("setpriv", "--pdeathsig", "KILL")
"""Command of util-linux without which ranks of the stock program continue for a second after mpirun was killed."""
Extend = Callable[[Path, EngineScene], EngineScene | None]


def run(
    run_dir: Path,
    ranks: int = 1,
    progress: bool = True,
    *,
    launch: Callable[..., Usage] = execute,
    keep: bool = False,
    extend: Extend | None = None,
    allow_unstable: bool = False,
    **more: Any,
) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` for a time step that would be unstable, unless `allow_unstable`.
    `launch` starts the engine's process and waits for it. With `keep` a finished run of the same scene with unchanged
    tables is not repeated. `extend` is called with the engine's folder and the scene at the engine's end, and returns
    the scene with more blocks, or None. `more` are fields of `Job`, such as `mpi`: the command before `-n RANKS` that
    starts the ranks in a cluster's job over several nodes.
    """
    run_dir = Path(run_dir).resolve()
    with alone(run_dir):
        job = prepare(run_dir, allow_unstable, ranks=ranks, progress=progress, **more)
        if keep and (account := job.store.account()):
            job.store.tidy()
            notice.info(f"{job.scene.name}: was simulated already; remove {job.store.engine} to do it again")
            return RunInfo(**account)
        raw = simulate(job, launch, extend)
        return collect(raw)


def prepare(run_dir: Path, allow_unstable: bool = False, *, ranks: int = 1, mpi: str = "", **more: Any) -> Job:
    """Read the scene, check program, ranks and time step, build the plugin, and write its inputs."""
    scene = RunDir(run_dir).scene
    version = installed("LIGGGHTS", ENGINE_VERSION, "make setup")
    starter = (shlex.split(mpi) or MPIRUN)[0]
    if ranks > 1 and shutil.which(starter) is None:
        raise EngineError(
            f"{ranks} ranks were asked for but there is no {starter}; expected mpirun of openmpi-bin (run `make setup`), or "
            f"srun within a job of SLURM",
            code="engine.no_mpirun", key="ranks", given=ranks,
        )  # fmt: skip
    if not allow_unstable:
        time_steps.refuse_unstable(scene)
    plugin = plugin_path() if attached(scene) else None
    return Job.of(scene, run_dir, "LIGGGHTS", version, plugin, ranks=ranks, mpi=mpi, **more)


def simulate(job: Job, launch: Callable[..., Usage] = execute, extend: Extend | None = None) -> Raw:
    """Run the engine, or what is left of its run, and the blocks by which `extend` extends it."""
    account, damaged = job.store.finished()
    if account is None:
        account = _run_engine(job, launch, [damaged] if damaged else [])
    else:
        notice.info(f"{job.scene.name}: the engine had come to its end; its output is collected")
    while extend and (longer := extend(job.store.partial, job.scene)):
        job.store.reopen()
        write_json(job.store.run_dir / "scene.json", longer.model_dump(mode="json"))
        write_inputs(longer, job.store.run_dir)
        job = replace(job, scene=longer)
        account = _together(account, _run_engine(job, launch, []))
    return Raw(job, account)


def _together(account: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    """Combine the account of a run with that of the blocks by which it was extended."""
    sums = {
        key: None if account[key] is None or more[key] is None else account[key] + more[key]
        for key in ("wall_s", "cpu_s", "loop_cpu_s")
    }
    peaks = [account["peak_memory_B"], more["peak_memory_B"]]
    return {**account, **sums, "peak_memory_B": None if None in peaks else max(peaks)}


def _run_engine(job: Job, launch: Callable[..., Usage], passed: Sequence[str]) -> dict[str, Any]:
    """Run the engine from the latest intact checkpoint, or from the start; return data that only this process knows."""
    scene, store, folder = job.scene, job.store, job.store.partial
    point, spheres = _begin(job, passed)
    recorder = checkpoint.Recorder(folder, scene, job.plugin is not None, spheres, point)
    started = time.monotonic()
    with progress_bar(scene, job.progress, point.step if point else 0) as report:
        try:

            def watch() -> None:
                check_held(store.run_dir)
                recorder.watch()

            usage = launch(_command(job, point.step if point else 0), folder, scene, report, watch)
        except PywetError:
            if point and checkpoint.refused(folder):
                checkpoint.drop(folder, point)
            raise
    # the worker's own record; of the stock program nearly all time is that of the steps
    pieces = read_if_there(folder / LOOP_TIME) or [] if job.plugin else [{"run_s": usage.cpu_s, "checkpoint_s": 0.0}]
    account = {
        "wall_s": time.monotonic() - started,
        "ranks": job.ranks,
        "resumed_at_step": point.step if point else None,
        "cpu_s": usage.cpu_s,
        "loop_cpu_s": sum(piece["run_s"] + piece["checkpoint_s"] for piece in pieces) if pieces else None,
        "peak_memory_B": usage.peak_memory_B if job.ranks == 1 else None,
    }
    store.finish(recorder.finish(), account)
    return account


def _begin(job: Job, passed: Sequence[str]) -> tuple[checkpoint.Checkpoint | None, int]:
    """Prepare a folder for the engine: truncated to the latest complete checkpoint of the same scene, or a new one.

    Also return the number of spheres. A refusal (spheres, laws) leaves an unfinished run in the folder unchanged.
    `passed`: what is damaged.
    """
    scene, store = job.scene, job.store
    point, damaged = checkpoint.find(store.partial) if store.is_begun else (None, [])
    damaged = [*passed, *damaged]
    why = f"; passed over: {', '.join(damaged[:3])}{' and older ones' if damaged[3:] else ''}" if damaged else ""
    how: dict[str, Any] = {"ranks": job.ranks, "extra": job.extra, "integrate": job.integrate}
    if point is None:
        with store.new() as folder:
            spheres = deck.write_deck(scene, store.run_dir, folder, **how)
        if damaged:
            notice.warning(f"{scene.name}: starts again{why}")
        return None, spheres
    store.forget_other()
    spheres = deck.write_deck(scene, store.run_dir, store.partial, resume=point, **how)
    checkpoint.cut_back(store.partial, point)
    if job.progress or damaged:
        notice.info(f"{scene.name}: resumes from its checkpoint at step {point.step} of {scene.steps}{why}")
    return point, spheres


def _command(job: Job, done: int) -> list[str]:
    if job.plugin:
        # -P: it works in the run directory, where nothing may be taken for a module
        program = [sys.executable, "-P", "-m", "pywet.engines.liggghts.worker"]
        program += [str(job.store.run_dir), str(job.store.partial), str(done), str(job.ranks)]
    else:
        program = ["stdbuf", "-oL", PROGRAM, "-in", "in.liggghts", "-log", "log.liggghts"]  # an abort flushes nothing
    if job.ranks > 1:
        return [*(shlex.split(job.mpi) or MPIRUN), "-n", str(job.ranks), *DIES_WITH_MPIRUN, *program]
    return program
