"""Runs a prepared scene in LIGGGHTS and turns what it wrote into tables.

A dry scene runs on the stock program; a moist one in worker.py with the plugin. Everything is written into `engine.partial`
first and renamed when the run is complete, so a failed run never looks like a finished one. Where `engine.partial` holds a
whole checkpoint of the same scene, the run goes on from there.
"""

from __future__ import annotations

import fcntl
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pywet import advisor
from pywet.engines.liggghts import checkpoint, deck, windows
from pywet.engines.liggghts.build import ENGINE_VERSION, package_version, plugin_path
from pywet.engines.liggghts.plugin_api import transfer_tables, wall_groups
from pywet.engines.liggghts.process import LOOP_TIME, Usage, execute, progress_bar
from pywet.engines.liggghts.tables import prepare_laws
from pywet.errors import PywetError
from pywet.files import write_json, write_table
from pywet.history import tables
from pywet.motion import engine_displacement, slide_displacement
from pywet.scene import Scene, WallMesh

PROGRAM = "liggghts"


@dataclass(frozen=True)
class RunInfo:
    """What a run was: also written to engine/run.json."""

    wall_s: float
    steps: int
    spheres: int
    ranks: int
    engine_version: str
    plugin_hash: str | None
    resumed_at_step: int | None
    """Checkpoint this run went on from; None when it began at the start. `wall_s` counts from there."""
    ledger_error: float | None
    """|Σ films + Σ bridges + Σ walls + left − initial| / initial, the largest over all outputs; None for a dry run."""
    engine: str = "LIGGGHTS"
    cpu_s: float = 0.0
    """Processor time of the engine's process (with more ranks: of all of them)."""
    loop_cpu_s: float | None = None
    """The same for the time steps alone, without Python's start and the compilation of laws; None where not known."""
    peak_memory_B: int | None = None
    """Largest resident memory of the engine's process (of one rank: not known with more)."""


def output_steps(scene: Scene) -> list[int]:
    """Steps at which trajectory, liquid and ledger are written."""
    every = deck.output_every(scene)
    return list(range(0, scene.steps + 1, every))


def run(
    run_dir: Path,
    ranks: int = 1,
    progress: bool = True,
    *,
    extra: tuple[str, ...] = (),
    integrate: str = "all",
    allow_unstable: bool = False,
    launch: Callable[..., Usage] = execute,
) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    Raises `PywetError` for a time step that would be unstable, unless `allow_unstable`.
    `extra` deck lines and the `integrate` group serve driven small scenes (two bodies at constant speed); `launch` starts the
    engine's process and waits for it.
    """
    run_dir = Path(run_dir).resolve()
    scene = Scene.read(run_dir / "scene.json")
    version = _check_engine(ranks)
    if not allow_unstable:
        advisor.refuse_unstable(scene)
    plugin = plugin_path() if scene.effects.bridges else None
    folder = run_dir / "engine.partial"
    mark = checkpoint.fingerprint(run_dir, scene, version, plugin.name if plugin else "", *extra, integrate)
    try:
        with alone(run_dir):
            point = _begin(scene, folder, mark)
            if point and progress:
                print(f"{scene.name}: goes on from its checkpoint at step {point.step} of {scene.steps}", flush=True)
            deck.write_deck(scene, run_dir, folder, extra=extra, integrate=integrate, resume=point)
            if scene.effects.bridges:
                _write_history_inputs(scene, run_dir, folder, point)
            started = time.monotonic()
            with progress_bar(scene, progress) as report:
                watch = (lambda: None) if scene.effects.bridges else (lambda: checkpoint.prune(folder))
                usage = launch(_command(scene, run_dir, folder, ranks), folder, scene, report, watch)
            wall = time.monotonic() - started
            spheres = _collect(scene, run_dir, folder)
            info = RunInfo(
                wall_s=wall,
                steps=scene.steps,
                spheres=spheres,
                ranks=ranks,
                engine_version=version,
                plugin_hash=plugin.stem.removeprefix("libpywet-") if plugin else None,
                resumed_at_step=point.step if point else None,
                ledger_error=ledger_error(run_dir) if scene.effects.bridges else None,
                cpu_s=usage.cpu_s,
                loop_cpu_s=_loop_cpu(folder, scene, usage),
                peak_memory_B=usage.peak_memory_B if ranks == 1 else None,
            )
            _finish(run_dir, folder, info)
    except OSError as error:
        raise PywetError(
            f"the run in {run_dir} stopped: {error.strerror}; expected a writable folder with free space"
        ) from error
    return info


def _loop_cpu(folder: Path, scene: Scene, usage: Usage) -> float | None:
    """Processor time of the steps: the worker's own account; the stock program starts within hundredths of a second."""
    if not scene.effects.bridges:
        return usage.cpu_s
    account = folder / LOOP_TIME
    return float(account.read_text()) if account.exists() else None


@contextmanager
def alone(run_dir: Path) -> Iterator[None]:
    """Hold the run directory; the lock goes with the process, also when that is killed."""
    with open(run_dir / ".engine.lock", "w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise PywetError(f"another run is at work in {run_dir}; wait for it or stop it") from error
        yield


def _begin(scene: Scene, folder: Path, mark: str) -> checkpoint.Checkpoint | None:
    """A folder cut back to the latest whole checkpoint of the same scene, or an empty one.

    A checkpoint between two stages is passed over: what the next stage stops there, such as the slide, is not part of it.
    """
    point = checkpoint.find(folder, mark, scene.effects.bridges, deck.boundaries(scene) - {scene.steps})
    if point is None:
        shutil.rmtree(folder, ignore_errors=True)
        checkpoint.start(folder, mark)
    else:
        checkpoint.cut_back(folder, point.step, deck.output_every(scene))
    return point


def _finish(run_dir: Path, folder: Path, info: RunInfo) -> None:
    """The run is whole: checkpoints go, the folder gets its name."""
    shutil.rmtree(folder / checkpoint.FOLDER)
    (folder / checkpoint.FINGERPRINT).unlink()
    write_json(folder / "run.json", asdict(info))
    shutil.rmtree(run_dir / "engine", ignore_errors=True)
    folder.rename(run_dir / "engine")


def ledger_error(run_dir: Path) -> float:
    """Largest relative error of the liquid's ledger over all outputs of a moist run."""
    ledger = pd.read_parquet(run_dir / "history" / "ledger.parquet")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"]
    initial = ledger["initial"].where(ledger["initial"] > 0, 1.0)
    return float(((held - ledger["initial"]).abs() / initial).max())


def _check_engine(ranks: int) -> str:
    if shutil.which(PROGRAM) is None:
        raise PywetError(f"the program {PROGRAM} was not found; expected Debian's package liggghts: run `make setup`")
    if ranks > 1 and shutil.which("mpirun") is None:
        raise PywetError(f"{ranks} ranks were asked for but there is no mpirun; expected openmpi-bin: run `make setup`")
    version = package_version("liggghts")
    if version is not None and not version.startswith(ENGINE_VERSION):
        raise PywetError(
            f"LIGGGHTS {version} is installed; expected {ENGINE_VERSION} (Debian 12): install that version"
        )
    return version or ENGINE_VERSION


def _write_history_inputs(scene: Scene, run_dir: Path, folder: Path, point: checkpoint.Checkpoint | None) -> None:
    history = run_dir / "history"
    prepare_laws(scene)
    write_table(transfer_tables(scene), history / "transfer.parquet")
    if scene.walls:
        groups = wall_groups(scene)
        parts = pd.read_parquet(history / "parts.parquet")
        parts["part_class"] = [
            groups[(np.inf if np.isnan(w) else w, a)]
            for w, a in zip(parts["half_width"], parts["contact_angle"], strict=True)
        ]
        write_table(parts, history / "parts.parquet")
    liquid = scene.liquid
    assert liquid is not None
    steps = output_steps(scene)
    meta = {
        "surface_tension": liquid.surface_tension_N_per_m,
        "viscosity": liquid.viscosity_Pa_s,
        "time_step": scene.time_step_s,
        "viscous_integration": scene.viscous_integration,
        "effects": scene.effects.model_dump(),
        "types": [
            {"type": c.type, "radius": c.radius_m, "contact_angle": c.contact_angle_rad, "density": c.density_kg_per_m3}
            for c in scene.classes
        ],
        "output_steps": steps,
    }
    write_json(history / "meta.json", meta)
    resume = None
    if point is not None:
        resume = {"state": str(point.state), "restore_forces": point.step not in deck.boundaries(scene)}
    schedule = {"output_steps": steps, "windows": windows.contact_windows(scene), "resume": resume}
    write_json(folder / "schedule.json", schedule)


def _command(scene: Scene, run_dir: Path, folder: Path, ranks: int) -> list[str]:
    if scene.effects.bridges:
        program = [sys.executable, "-m", "pywet.engines.liggghts.worker", str(run_dir), str(folder)]
    else:
        program = ["stdbuf", "-oL", PROGRAM, "-in", "in.liggghts", "-log", "log.liggghts"]  # an abort flushes nothing
    if ranks > 1:
        return ["mpirun", "--allow-run-as-root", "--bind-to", "none", "--oversubscribe", "-np", str(ranks), *program]
    return program


def _collect(scene: Scene, run_dir: Path, folder: Path) -> int:
    """Tables from what the engine wrote; returns the number of spheres."""
    trajectory = read_trajectory(folder / "trajectory.txt", scene.time_step_s)
    write_table(trajectory, run_dir / "trajectory.parquet")
    (folder / "trajectory.txt").unlink()
    windows.collect(scene, folder, run_dir / "history")
    steps = sorted(int(s) for s in trajectory["step"].unique())
    rows = [(step, wall.name, *mesh_translation(scene, wall, step)) for step in steps for wall in scene.walls]
    write_table(pd.DataFrame(rows, columns=["step", "mesh", "dx", "dy", "dz"]), run_dir / "mesh_motion.parquet")
    if scene.effects.bridges:
        tables.convert(folder, run_dir / "history")
        for path in folder.glob("*.bin"):
            path.unlink()
    return int((trajectory["step"] == steps[0]).sum())


def mesh_translation(scene: Scene, wall: WallMesh, step: int) -> tuple[float, ...]:
    """How far a mesh is from its STL file after `step` steps [m]."""
    if wall.motion == "vibrates" and scene.vibration is not None:
        return tuple(float(d) for d in engine_displacement(scene.vibration, step, scene.time_step_s))
    if wall.motion == "slides" and scene.slide is not None:
        return tuple(float(d) for d in slide_displacement(scene.slide, step * scene.time_step_s))
    return (0.0, 0.0, 0.0)


def read_trajectory(path: Path, time_step: float) -> pd.DataFrame:
    """The engine's text dump as a table: step, time, id, type, x … wz."""
    names = ["id", "type", "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz"]
    frames = []
    with open(path) as dump:
        while dump.readline():
            step = int(dump.readline())
            dump.readline()
            count = int(dump.readline())
            for _ in range(5):
                dump.readline()
            block = np.array([dump.readline().split() for _ in range(count)], dtype=float).reshape(count, len(names))
            frame = pd.DataFrame(block, columns=names).astype({"id": np.int64, "type": np.int64})
            frame.insert(0, "step", step)
            frame.insert(1, "time", step * time_step)
            frames.append(frame)
    return pd.concat(frames, ignore_index=True)
