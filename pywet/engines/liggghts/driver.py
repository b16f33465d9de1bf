"""Runs a prepared scene in LIGGGHTS and turns what it wrote into tables.

A dry scene runs on the stock program; a moist one in worker.py with the plugin. Everything is written into `engine.partial`
first and renamed when the run is complete, so a failed run never looks like a finished one.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.engines.liggghts import deck
from pywet.engines.liggghts.build import ENGINE_VERSION, package_version, plugin_path
from pywet.engines.liggghts.plugin_api import transfer_tables, wall_groups
from pywet.engines.liggghts.tables import prepare_laws
from pywet.errors import PywetError
from pywet.files import write_json, write_table
from pywet.history import tables
from pywet.motion import engine_displacement, slide_displacement
from pywet.scene import Scene, WallMesh

PROGRAM = "liggghts"
Report = Callable[[int, int], None]


@dataclass(frozen=True)
class RunInfo:
    """What a run was: also written to engine/run.json."""

    wall_s: float
    steps: int
    spheres: int
    ranks: int
    engine_version: str
    plugin_hash: str | None
    ledger_error: float | None
    """|Σ films + Σ bridges + Σ walls + left − initial| / initial, the largest over all outputs; None for a dry run."""


def output_steps(scene: Scene) -> list[int]:
    """Steps at which trajectory, liquid and ledger are written."""
    every = deck.output_every(scene)
    return list(range(0, scene.steps + 1, every))


def contact_windows(scene: Scene) -> list[tuple[int, int]]:
    """Half-open windows of steps in which every bridge is logged in every step, spread evenly over the run."""
    count, length = scene.output.contact_windows, scene.output.contact_window_steps
    middles = [int(scene.steps * (k + 0.5) / count) for k in range(count)]
    return [(max(0, m - length // 2), min(m - length // 2 + length, scene.steps + 1)) for m in middles]


def run(
    run_dir: Path,
    ranks: int = 1,
    progress: bool = True,
    *,
    extra: tuple[str, ...] = (),
    integrate: str = "all",
) -> RunInfo:
    """Run the scene in `run_dir`/scene.json; writes engine/, trajectory, mesh motion and (moist) history/.

    `extra` deck lines and the `integrate` group serve driven small scenes (two bodies at constant speed).
    """
    run_dir = Path(run_dir).resolve()
    scene = Scene.read(run_dir / "scene.json")
    version = _check_engine()
    plugin = plugin_path() if scene.effects.bridges else None
    folder = run_dir / "engine.partial"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        deck.write_deck(scene, run_dir, folder, extra=extra, integrate=integrate)
        if scene.effects.bridges:
            _write_history_inputs(scene, run_dir, folder)
        started = time.monotonic()
        with _progress(scene, progress) as report:
            _execute(_command(scene, run_dir, folder, ranks), folder, scene, report)
        wall = time.monotonic() - started
        spheres = _collect(scene, run_dir, folder)
    except OSError as error:
        raise PywetError(
            f"the run in {run_dir} stopped: {error.strerror}; expected a writable folder with free space"
        ) from error
    info = RunInfo(
        wall_s=wall,
        steps=scene.steps,
        spheres=spheres,
        ranks=ranks,
        engine_version=version,
        plugin_hash=plugin.stem.removeprefix("libpywet-") if plugin else None,
        ledger_error=ledger_error(run_dir) if scene.effects.bridges else None,
    )
    write_json(folder / "run.json", asdict(info))
    shutil.rmtree(run_dir / "engine", ignore_errors=True)
    folder.rename(run_dir / "engine")
    return info


def ledger_error(run_dir: Path) -> float:
    """Largest relative error of the liquid's ledger over all outputs of a moist run."""
    ledger = pd.read_parquet(run_dir / "history" / "ledger.parquet")
    held = ledger["films"] + ledger["bridges"] + ledger["walls"] + ledger["left"]
    initial = ledger["initial"].where(ledger["initial"] > 0, 1.0)
    return float(((held - ledger["initial"]).abs() / initial).max())


def _check_engine() -> str:
    if shutil.which(PROGRAM) is None:
        raise PywetError(f"the program {PROGRAM} was not found; expected Debian's package liggghts: run `make setup`")
    version = package_version("liggghts")
    if version is not None and not version.startswith(ENGINE_VERSION):
        raise PywetError(
            f"LIGGGHTS {version} is installed; expected {ENGINE_VERSION} (Debian 12): install that version"
        )
    return version or ENGINE_VERSION


def _write_history_inputs(scene: Scene, run_dir: Path, folder: Path) -> None:
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
        "effects": scene.effects.model_dump(),
        "types": [
            {"type": c.type, "radius": c.radius_m, "contact_angle": c.contact_angle_rad, "density": c.density_kg_per_m3}
            for c in scene.classes
        ],
        "output_steps": steps,
    }
    write_json(history / "meta.json", meta)
    write_json(folder / "schedule.json", {"output_steps": steps, "windows": contact_windows(scene)})


def _command(scene: Scene, run_dir: Path, folder: Path, ranks: int) -> list[str]:
    if scene.effects.bridges:
        program = [sys.executable, "-m", "pywet.engines.liggghts.worker", str(run_dir), str(folder)]
    else:
        program = [PROGRAM, "-in", "in.liggghts", "-log", "log.liggghts", "-screen", "screen.log"]
    if ranks > 1:
        return ["mpirun", "--allow-run-as-root", "--bind-to", "none", "--oversubscribe", "-np", str(ranks), *program]
    return program


@contextmanager
def _progress(scene: Scene, wanted: bool) -> Iterator[Report]:
    """A bar with the time to go in a terminal, a line for each tenth of the run in a log file."""
    if not wanted:
        yield lambda done, total: None
    elif sys.stdout.isatty():
        from rich.progress import (
            BarColumn,
            Progress,
            TaskProgressColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
        with Progress(*columns, TimeElapsedColumn(), TextColumn("to go"), TimeRemainingColumn()) as bar:
            task = bar.add_task(scene.name, total=scene.steps)
            yield lambda done, total: bar.update(task, completed=done, total=total)
    else:
        yield _line_reporter(scene)


def _line_reporter(scene: Scene) -> Report:
    started, shown = time.monotonic(), -1

    def report(done: int, total: int) -> None:
        nonlocal shown
        tenth = 10 * done // max(total, 1)
        if tenth == shown:
            return
        shown = tenth
        elapsed = time.monotonic() - started
        tail = f", about {elapsed * (total - done) / done:.0f} s to go" if done and done < total else ""
        print(f"{scene.name}: {100 * done / total:3.0f} % after {elapsed:.0f} s{tail}", flush=True)

    return report


def _execute(command: list[str], folder: Path, scene: Scene, report: Report) -> None:
    environment = {
        **os.environ,
        "OMP_NUM_THREADS": "1",
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    }
    with open(folder / "output.log", "w") as output:
        child = subprocess.Popen(command, cwd=folder, stdout=output, stderr=subprocess.STDOUT, env=environment)
        try:
            while child.poll() is None:
                time.sleep(0.2)
                report(_step_reached(folder), scene.steps)
        except BaseException:
            child.kill()
            raise
    if child.returncode != 0:
        raise PywetError(
            f"{scene.name}: LIGGGHTS stopped: {_reason(folder, child.returncode)} (all messages: {folder / 'screen.log'})"
        )


def _step_reached(folder: Path) -> int:
    """Last step that the engine's thermo output shows; reads only the end of the log."""
    path = folder / "log.liggghts"
    if not path.exists():
        return 0
    with open(path, "rb") as log:
        log.seek(max(0, path.stat().st_size - 4096))
        lines = log.read().decode(errors="replace").splitlines()
    steps = [int(m.group(1)) for line in lines if (m := re.match(r"^\s*(\d+)\s+\d+\s+\S+\s+\S+\s*$", line))]
    return steps[-1] if steps else 0


def _reason(folder: Path, returncode: int) -> str:
    """The engine's first ERROR line, without its decoration; else the last line there is."""
    lines: list[str] = []
    for name in ("output.log", "screen.log", "log.liggghts"):
        path = folder / name
        if path.exists():
            lines += path.read_text(errors="replace").splitlines()
    errors = [line for line in lines if "ERROR" in line]
    if not errors:
        if returncode < 0:
            return f"the program was ended by signal {-returncode} ({signal.strsignal(-returncode)})"
        return lines[-1] if lines else "it wrote nothing"
    text = re.sub(r"^.*?ERROR[^:]*:\s*", "", errors[0])
    text = re.sub(r"\s*\(\.\./\S+\)|\s*\(\S+\.(cpp|h):\d+\)", "", text)
    if "Lost atoms" in text:
        return f"spheres left the simulated box ({text}); enlarge the box or lower the time step"
    return text


def _collect(scene: Scene, run_dir: Path, folder: Path) -> int:
    """Tables from what the engine wrote; returns the number of spheres."""
    trajectory = read_trajectory(folder / "trajectory.txt", scene.time_step_s)
    write_table(trajectory, run_dir / "trajectory.parquet")
    (folder / "trajectory.txt").unlink()
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
