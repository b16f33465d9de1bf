"""Calls that make one mistake each, by its code: for the messages that are rendered once (test_messages.py)."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pandas as pd
import pytest
import scipy.optimize

from pywet import config, stages
from pywet.calibration import experiments, question
from pywet.cases.script import run as script_run
from pywet.cases.small import bridge_engine, bridge_query, scenes
from pywet.collisions.spheres import forms, problem
from pywet.collisions.spheres.equal import three_equal_spheres
from pywet.compare import command as compare_command
from pywet.compare import digest, quantities, verdict
from pywet.cost import choice
from pywet.engines import process
from pywet.engines.liggghts import build, deck, logs, windows, worker
from pywet.engines.liggghts import process as engine_process
from pywet.engines.liggghts.creation import ToCome
from pywet.engines.liggghts.plugin_api import Plugin
from pywet.engines.yade import worker as yade_worker
from pywet.errors import PywetError, arguments
from pywet.geometry import cad, surface
from pywet.laws import checks, force_law, transfer
from pywet.laws.exact_bridge import table as exact_table
from pywet.laws.kinds import KINDS
from pywet.planning import numbers, retirement, time_steps
from pywet.planning.surroundings import Surroundings
from pywet.products import kinetics, outlets, streams
from pywet.products.size_classes import LogNormal, SizeDistribution, sieve_analysis
from pywet.report import collect, render, scene_page, vtk, vtkhdf
from pywet.run_folder import LOCK, claim, hold, refuse_within
from pywet.runs import summary, tables
from pywet.runs.loaded import Run
from pywet.runs.record import Status
from pywet.runs.rundir import RunDir
from pywet.schema import SPHERE, TABLES
from pywet.util import caches, files, options
from pywet.util.options import LIMITS
from tests.cases.screening import synthetic
from tests.cases.script import scripts
from tests.import_graph import ROOT

OF_SHEDDING = f"def law({', '.join(KINDS['shedding'].parts[0].arguments)}):\n    return 0.0\n"
LAUNCH = "srun: error: task 0 launch failed: Unspecified error\n"
Call = Callable[[Path], Any]


def patched(where: Any, name: str, value: Any, call: Callable[[], Any]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(where, name, value)
        call()


def written(folder: Path, text: str | bytes, name: str = "file") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def without_locks(*_: object) -> None:
    raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))


def no_fit(*_: object, **__: object) -> None:
    raise RuntimeError("Optimal parameters not found")


def raised(error: PywetError) -> None:
    raise error


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe")
    return folder / "pipe"


def device(folder: Path) -> Path:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(folder / "socket"))
    return folder / "socket"


def run_of(folder: Path, moist: bool = False) -> Run:
    return Run(synthetic.make(folder / "run", moist=moist))


def query(folder: Path, *laws: str) -> bridge_query.Query:
    given = {
        "bodies": [{"radius_m": 0.002, "contact_angle_deg": 10}, {"wall": "large", "contact_angle_deg": 30}],
        "volume_m3": 1e-10, "surface_tension_N_per_m": 0.07, "separations_m": [0.0], "laws": laws,
    }  # fmt: skip
    return bridge_query.checked(given, folder / "query.json")


def triangles(count: int, size_m: float = 1.0) -> np.ndarray:
    """Sheets of one triangle that share an edge, each turned about it."""
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    tips = np.stack([np.cos(turn), np.sin(turn), np.full(count, 0.5)], axis=1)
    edge = np.broadcast_to([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]], (count, 2, 3))
    return size_m * np.concatenate([edge, tips[:, None]], axis=1)


def ascii_stl(corners: np.ndarray) -> str:
    return "\n".join(f"vertex {x} {y} {z}" for x, y, z in corners.reshape(-1, 3))


def refused_plugin(folder: Path) -> None:
    library = MagicMock()
    library.pywet_version.return_value = b"3.7.0"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ctypes.CDLL", lambda *_, **__: library)
        Plugin(folder / "plugin.so", "3.8.0")


def evaluated(folder: Path, moist: bool = True) -> Path:
    """A synthetic run with results."""
    run = synthetic.make(folder / "run", moist=moist)
    stages.results(run)
    return run


def cut(run: Path, name: str, rows: int = 0) -> Path:
    """A run whose table is cut to some rows, or removed."""
    path = run / f"{name}.parquet"
    made = pd.read_parquet(path).iloc[:rows]
    path.unlink() if not rows else made.to_parquet(path)
    return run


def twice(run: Path) -> Path:
    """A run whose meshes have two rows of each step."""
    made = pd.read_parquet(run / "mesh_motion.parquet")
    pd.concat([made, made]).to_parquet(run / "mesh_motion.parquet")
    return run


def no_energy(folder: Path) -> None:
    scene = SimpleNamespace(output=SimpleNamespace(energy=True))
    summary._energy(SimpleNamespace(path=folder, moist=True, scene=scene, table=lambda _: pd.DataFrame({"step": []})))  # type: ignore[arg-type]


def failed(run: Path) -> Path:
    """A run that fails a check."""
    content = files.read_json(run / "summary.json")
    content["checks"][0]["ok"] = False
    files.write_json(run / "summary.json", content)
    return run


def noted(run: Path) -> Path:
    """A run whose stage results has its status."""
    Status("results", True, 0.0).write(run)
    return run


def without_results(folder: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        for name in ("screen", "retained", "liquid", "counts", "energies", "bed"):
            patch.setattr(quantities, f"_{name}", lambda _: [])
        quantities.read_run(synthetic.make(folder / "run", moist=False))


def late() -> None:
    run = SimpleNamespace(
        timeline=MagicMock(times=np.array([0.0, 1.0])), scene=MagicMock(insertion_s=(0.0, 1.0)), table=MagicMock()
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(streams, "uncollected", lambda _: None)
        patch.setattr(streams, "leaving", MagicMock())
        streams._of_outlets(run, 9.0, 1)  # type: ignore[arg-type]


def no_windows(folder: Path) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(windows, "read_dump", lambda *_: pd.DataFrame({"step": [1], "id": [1], "x": [0.0], "y": [0.0]}))
        list(
            windows.collect(
                synthetic.scene(),
                written(folder, "", "states.txt").parent,
                [(0, 2)],
                [],
                ToCome(synthetic.scene(), folder, None),
            )
        )


def half_written(folder: Path, spheres: int) -> None:
    """A checkpoint whose file by the engine holds so many of two spheres."""
    path = folder / worker.saved("engine", 100, whole=False)
    path.parent.mkdir(parents=True)
    path.write_bytes(b"restart")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(worker, "plugin_rank", lambda: 0)
        patch.setattr(worker.state_file, "count", lambda _: 2)
        patch.setattr(worker, "holds", lambda _, count: count == spheres)
        worker.name_checkpoint(100)


def ended(folder: Path) -> None:
    """A script whose engine a signal ended before its first table."""
    path = scripts.write(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(os, "fork", lambda: 1)
        patch.setattr(os, "waitpid", lambda *_: (1, 11))
        script_run.run(Path(path.name), [], print)


def without_yade() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "yade", None)
        patch.setattr(yade_worker, "sys", SimpleNamespace(path=[], version_info=(3, 13, 1)))
        yade_worker.reach_yade()


def mistakes() -> dict[str, Call]:
    """Code -> what raises it, in an empty folder."""
    surroundings, wall = Surroundings(), SimpleNamespace(stl="a.stl", name="floor", triangle_part=[0])
    scene = synthetic.scene()
    two = three_equal_spheres(St_n=5.0)
    no_spheres = tuple(c.model_copy(update={"count": 0}) for c in scene.classes)
    log_normal = LogNormal(median_mm=2.0, sigma=0.5)
    box = SimpleNamespace(part=np.zeros(3, int), part_half_width=(None,), triangles=np.zeros((4, 3), int), name="box")
    return {
        "bridge.law_kind": lambda folder: query(folder, f"{written(folder, OF_SHEDDING, 'law.py')}:law"),
        "bridge.no_number": lambda _: bridge_query._finite(float("inf"), "willett"),
        "bridge.short_life": lambda _: bridge_engine._at(None, pd.DataFrame(), "force"),  # type: ignore[arg-type]
        "bridge.table_nodes": lambda _: patched(
            exact_table, "fill", lambda *_: (np.nan, np.nan), lambda: exact_table.build(0.5, 0.5)
        ),
        "bridge.unknown_law": lambda folder: query(folder, "rabinovitch"),
        "cache.unwritable": lambda folder: patched(os, "access", lambda *_: False, lambda: caches._private(folder)),
        "calibration.not_keys": lambda folder: experiments._json(written(folder, "[1]")),
        "calibration.study_question": lambda folder: question.read(written(folder, "turned: {}\n", "search.yaml")),
        "case.no_spheres": lambda _: numbers.class_groups([], [], None, 1.0, surroundings),
        "checkpoint.changed": lambda folder: logs.read_signed(written(folder, "{}")),
        "compare.groups": lambda _: compare_command._groups([], [], []),
        "checkpoint.unwritten": lambda folder: half_written(folder, 0),
        "engine.left_box": lambda folder: half_written(folder, 1),
        "compare.across": lambda _: quantities.unlike(quantities.facts(scene), scene, ["moisture"]),
        "compare.no_results": without_results,
        "compare.no_run": lambda folder: compare_command._against([], folder / "digest.json"),
        "compare.no_run_folder": lambda folder: verdict.runs_in(folder),
        "compare.no_table": lambda folder: patched(
            verdict, "read_groups", lambda *_: [[SimpleNamespace(quantities={})]] * 2,
            lambda: verdict.compare([folder / "a"], [folder / "b"]),
        ),
        "compare.not_whole": lambda folder: quantities.read_run(cut(synthetic.make(folder / "run"), "trajectory")),
        "compare.one_table": lambda folder: verdict._same_tables(
            [[SimpleNamespace(path=folder / "a", held={"rows": {quantities.RESULTS[0]: 1}})],
             [SimpleNamespace(path=folder / "b", held={"rows": {}})]]  # type: ignore[list-item]
        ),
        "compare.rows": lambda folder: quantities.read_run(cut(evaluated(folder), quantities.RESULTS[0], 2)),
        "cost.accuracy": lambda _: choice.parse("150%"),
        "digest.failed_check": lambda folder: digest.of_runs("a", "pywet run 2", [failed(evaluated(folder))]),
        "digest.missing": lambda folder: digest.load(folder / "digest.json"),
        "digest.no_runs": lambda folder: digest.check(digest.Digest("pull", "pywet bridge", "", 1, 1e-6, {}, {}), folder),
        "digest.scenes": lambda _: digest._same_scene(
            digest.facts(scene), scene.model_copy(update={"gravity_m_per_s2": (0.0, 0.0, -1.0)}), "two runs"
        ),
        "effect.retire": lambda _: retirement.decide(
            True, scene.effects, scene.output.model_copy(update={"checkpoints": 0}), scene.gravity_m_per_s2, True, 1.0
        ),
        "engine.no_answer": lambda _: patched(process, "ANSWER_S", 0.05, lambda: process.output_of(["sleep", "9"])),
        "engine.not_launched": lambda folder: raised(
            engine_process.stopped(scene, written(folder, LAUNCH, engine_process.OUTPUT).parent, 137)
        ),
        "engine.not_started": lambda folder: process.output_of([str(written(folder, "no program"))]),
        "engine.path": lambda folder: deck.from_folder(folder / "a b", folder),
        "file.device": lambda folder: files.write_json(device(folder), 1),
        "file.irregular": lambda folder: files.read_json(pipe(folder)),
        "file.kind": lambda folder: files.check_numbers(pd.DataFrame({"a": ["x"]}), ["a"], folder / "a.csv"),
        "file.large": lambda folder: patched(files, "MOST_B", 3, lambda: files.read_json(written(folder, "[1, 2]"))),
        "file.no_row": lambda folder: files._check_table(
            pd.DataFrame(columns=[*TABLES["trajectory"]]), folder / "trajectory.parquet", "run it again", (), True
        ),
        "file.not_a_path": lambda folder: files.read_json(folder / "a\0b"),
        "file.not_json": lambda folder: files.read_json(written(folder, "{")),
        "file.not_text": lambda folder: files.read_json(written(folder, b"\xff\xff")),
        "file.shape": lambda folder: files.read_json(written(folder, '{"a": "b"}'), shape=dict[str, int]),
        "file.zero_byte": lambda folder: files.write_json(folder / "a\0b", 1),
        "folder.in_run": lambda folder: [claim(folder), refuse_within(folder / "new")],
        "folder.strangers": lambda folder: claim(written(folder, "mine").parent),
        "folder.unwritten": lambda folder: claim(written(folder, "") / "run"),
        "kinetics.fit": lambda _: patched(
            scipy.optimize, "curve_fit", no_fit, lambda: kinetics.fit(kinetics.LAWS[0], np.arange(3.0), np.ones(3))
        ),
        "law.not_plain": lambda _: force_law.force_law(3),  # type: ignore[call-overload]
        "law.unknown": lambda _: checks.kind_of("rabinovitch"),
        "liggghts.headers": lambda _: patched(process, "package_version", lambda _: None, build.engine_version),
        "lock.unsupported": lambda folder: patched(fcntl, "flock", without_locks, hold(folder).__enter__),
        "lock.unwritten": lambda folder: [(folder / LOCK).mkdir(), hold(folder).__enter__()],
        "option.case": lambda _: options._case("mill.yaml"),
        "option.range": lambda _: LIMITS["case"].read("CASE", "-1"),
        "plugin.compiler": lambda _: patched(shutil, "which", lambda _: None, build.compiler_version),
        "plugin.not_compiled": lambda folder: patched(
            subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=1, stderr="lammps.h: error: no such file"),
            lambda: build.compile_to(folder / "plugin.so", [], [], [], "LIGGGHTS 3.8.0"),
        ),
        "plugin.refused": lambda _: Plugin._check(None, b"the law has no value at its first node"),  # type: ignore[arg-type]
        "plugin.triangles": lambda _: Plugin._add_mesh(None, wall, np.zeros((18,)), {}),  # type: ignore[arg-type]
        "plugin.version": refused_plugin,
        "program.argument": lambda _: patched(sys, "argv", ["draw.py", "six"], lambda: arguments(STEP=int)),
        "program.arguments": lambda _: patched(sys, "argv", ["draw.py"], lambda: arguments(STEP=int)),
        "psd.empty": lambda folder: SizeDistribution(file=written(folder, "1,2,100\n"), smallest_mm=5.0).sizes(),
        "psd.many_sizes": lambda _: SizeDistribution(
            log_normal=log_normal, smallest_mm=0.5, classes=20, sizes_per_class=20
        ).sizes(),
        "psd.not_csv": lambda folder: sieve_analysis(written(folder, '1,"' + "9" * 200_000)),
        "psd.smallest": lambda _: SizeDistribution(log_normal=log_normal, smallest_mm=90.0).sizes(),
        "render.vtk": lambda _: patched(render, "WINDOWS", (), lambda: list(render.in_child("pywet.report.render"))),
        "report.dry_run": lambda folder: collect._collect_run(
            noted(evaluated(folder, moist=False)), config.load(ROOT / "config").case(2), True
        ),
        "report.no_summary": lambda folder: scene_page.of_run(folder),
        "run.dry": lambda folder: run_of(folder).events,
        "run.dump": lambda folder: list(windows.dump_parts(written(folder, "ITEM: TIMESTEP\nx\n" + "1\n" * 7), ["id"])),
        "run.motion_twice": lambda folder: RunDir(twice(synthetic.make(folder / "run"))).mesh_motion,
        "run.no_energy": no_energy,
        "run.no_log": lambda folder: list(tables.raw_parts(folder, "films")),
        "run.windows": no_windows,
        "shown.differs": lambda folder: stages._read_back([], lambda _: "sphere 1 is elsewhere at step 0", folder),
        "small.not_turning": lambda folder: scenes.bed_angles(synthetic.make(folder / "run", moist=False)),
        "spheres.count": lambda _: problem.check(replace(two, radius=two.radius[:1])),
        "spheres.not_finite": lambda _: problem.check(replace(two, velocity=two.velocity * np.nan)),
        "spheres.form": lambda folder: forms.parse({"form": "cubes"}, "cubes.json"),
        "scene.in_outlet": lambda _: outlets.refuse_begins(
            "bed", [outlets.Outlet(name="end", high_mm=(20, None, None)).region()], np.eye(3), (0.0, 0.0, 0.0)
        ),
        "step.no_spheres": lambda _: time_steps.advise(scene.model_copy(update={"classes": no_spheres})),
        "step.not_proportional": lambda _: time_steps.refuse_nonlinear_drag(
            scene.effects.model_copy(update={"viscous_normal": "buck_water"}), "semi_implicit",
            "time_step.viscous_integration", "config.yaml",
        ),
        "stl.far": lambda folder: cad.read_cad(written(folder, ascii_stl(triangles(4, 1e9)), "a.stl"), 1.0),
        "stl.shell": lambda folder: cad.read_cad(written(folder, ascii_stl(triangles(3)), "a.stl"), 1.0, shell_m=0.01),
        "surface.large": lambda _: surface.make_surface("floor", "wall", [(triangles(4, 1e3), None)]),
        "surface.parts": lambda _: surface.check_surface(box),  # type: ignore[arg-type]
        "screen.late": lambda _: late(),
        "screen.from_batch": lambda folder: streams.read(RunDir(synthetic.make(folder / "run", moist=False)), 0.1),
        "transfer.no_solution": lambda _: patched(
            transfer, "_first", lambda *_: None,
            lambda: transfer.transfer_table(2e-3, 1e-3, 0.5, 0.5, SPHERE),
        ),
        "vtkhdf.refused": lambda folder: patched(
            render, "in_child", lambda *_: (line for line in ["the array is not finite"]),
            lambda: vtkhdf.write(synthetic.make(folder / "run")),
        ),
        "wet.engine_ended": ended,
        "yade.python": lambda _: without_yade(),
        "vtk.unwritten": lambda folder: raised(vtk.unwritten(folder / "walls.vtu")),
    }  # fmt: skip
