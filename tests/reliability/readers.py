"""Whatever reads a file, each with sound files of its kind: what `test_fuzzed_files` damages and reads."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pyarrow import parquet

from benchmarks.wet import score
from pywet import scene_stages as commands
from pywet import stages
from pywet.calibration import question
from pywet.cases.custom import walls
from pywet.cases.custom.building import Building
from pywet.cases.custom.placing import ask_unit
from pywet.cases.screening import results, verdict
from pywet.cases.small import bridge_query
from pywet.collisions.spheres import command as spheres
from pywet.collisions.wall import sweep
from pywet.compare import quantities
from pywet.config import loading
from pywet.engines.liggghts import windows
from pywet.errors import PywetError
from pywet.geometry.stl import read_stl
from pywet.laws.exact_bridge import table as exact_table
from pywet.runs import record, tables
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.util import files
from reference_impl.replay import command, io, stream
from reference_impl.replay.io import ReplayError
from reference_impl.scene import stl as reference_stl
from tests.cases.screening import synthetic
from tests.report.test_report import REPLAY

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"


@dataclass(frozen=True)
class Reader:
    """`make` writes sound files into a folder and returns those that are to be damaged, one at a time; `read` gets one."""

    make: Callable[[Path], list[Path]]
    read: Callable[[Path], Any]
    refusals: tuple[type[Exception], ...] = (PywetError,)


def copied(*paths: Path, also: tuple[Path, ...] = ()) -> Callable[[Path], list[Path]]:
    """Copies of files of the project, and of others that they name."""

    def make(folder: Path) -> list[Path]:
        for path in also:
            shutil.copy(path, folder)
        return [Path(shutil.copy(path, folder)) for path in sorted(paths)]

    return make


def calibrations(folder: Path) -> list[Path]:
    (folder / "calibrations").mkdir()
    shutil.copy(EXAMPLES / "wall_wet.json", folder)
    return copied(EXAMPLES / "calibrations" / "binder.yaml")(folder / "calibrations")


def surfaces(folder: Path) -> list[Path]:
    """A surface in bytes, and as text."""
    path = Path(shutil.copy(EXAMPLES / "scenes" / "hopper.stl", folder))
    rows = ["\n".join(f"      vertex {x:.9g} {y:.9g} {z:.9g}" for x, y, z in three) for three in read_stl(path).corners]
    facets = "".join(f"  facet normal 0 0 0\n    outer loop\n{r}\n    endloop\n  endfacet\n" for r in rows)
    (folder / "text.stl").write_text(f"solid cup\n{facets}endsolid cup\n")
    return [path, folder / "text.stl"]


def run(folder: Path) -> Path:
    made = synthetic.make(folder / "case02")
    stages.results(made)
    return made


def run_tables(folder: Path) -> list[Path]:
    """All but that of the parts, which the made run does not have whole."""
    return sorted(path for path in run(folder).rglob("*.parquet") if path.stem != "parts")


def run_json(folder: Path) -> list[Path]:
    made = run(folder)
    record.leave_identity(made, "five")
    for name, value in (("replay", {"ok": True, **REPLAY}), ("status/results", {"ok": True})):
        files.write_json(made / f"{name}.json", value)
    return sorted(path for path in made.rglob("*.json") if path.name != ".pywet-run")


def raw_logs(folder: Path) -> list[Path]:
    """Two frames of an engine's dump, and the plugin's records of two ranks."""
    made = []
    for rank in range(2):
        records = np.zeros(20, tables.RAW["events"])
        records["step"] = np.arange(20)
        made.append(folder / f"events.{rank}.bin")
        records.tofile(made[-1])
    head = "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x\n"
    (folder / "dump.txt").write_text("".join(head.format(step) + "1 0.5 \n2 1e-3 \n3 -7 \n" for step in (0, 100)))
    return [*made, folder / "dump.txt"]


def exact_tables(folder: Path) -> list[Path]:
    shapes = ((exact_table.X_NODES,), (exact_table.Y_NODES, exact_table.X_NODES))
    shapes += (shapes[1], (*shapes[1], exact_table.U_NODES))
    values = {
        name: np.linspace(0.0, 1.0, int(np.prod(s))).reshape(s)
        for name, s in zip(exact_table.NAMES, shapes, strict=True)
    }
    np.savez(folder / "table.npz", **values)
    return [folder / "table.npz"]


def answers(folder: Path) -> list[Path]:
    lines = score.template("pair_at_rest").splitlines()[:40]
    (folder / "answers.csv").write_text("\n".join([lines[0], *(f"{line}1e-4" for line in lines[1:])]) + "\n")
    return [folder / "answers.csv"]


def scene(path: Path) -> None:
    building = Building(commands.read_scene(path))
    building.scene()
    _ = building.warnings


def surface(path: Path) -> None:
    wall = walls.Wall(name="cup", stl=path.name)
    ask_unit(wall, wall.surface(path.parent), [0.003])


def wall(path: Path) -> None:
    content = sweep.read(path)
    if len(list(sweep.combinations(content))) <= 4:
        sweep.table(content, str(path), threads=1)


def of_run(path: Path) -> Path:
    return next(folder for folder in path.parents if folder.name == "case02")


def table(path: Path) -> None:
    """A table by itself, whole and in parts, and the run that it belongs to."""
    files.read_table(path)
    for _ in files.read_parts(path, [parquet.read_schema(path).names[0]]):
        pass
    found = RunDir(of_run(path))
    results.summarise(found, results.Results.of(found))
    quantities.read_run(of_run(path))


def json_of_run(path: Path) -> None:
    folder = of_run(path)
    files.read_json(path)
    found = Run(folder)
    _ = found.summary, found.replay
    record.left_identity(folder)
    verdict.objections(RunDir(folder))
    record.missing(folder)
    quantities.read_run(folder)


def table_by_the_reference(path: Path) -> None:
    """A table whole, column by column, and as the stream of its rows."""
    name = path.stem
    if name in io.NEEDED:
        found = io.table(path, name)
        if name in io.LOGS:
            stream.Rows(path, name, batch=7).until(int(found["step"].max()) if len(found) else 0)
    io.columns(path, io.names(path)[:2])
    command.outcome(of_run(path))


def raw(path: Path) -> None:
    if path.suffix == ".bin":
        tables.read_raw(path.parent, "events")
    else:
        windows.read_dump(path, ["id", "x"])


def config(path: Path) -> None:
    """The file by itself first: what is refused there would be refused in the folder."""
    loading._read_model(path, loading.FILES[path.name])
    loading.load(path.parent)


def cases(path: Path) -> None:
    loading._read_cases(path)


def scored(path: Path) -> None:
    score.scored("pair_at_rest", score.read(path))


CONFIG = sorted((ROOT / "config").glob("*.yaml"))
READERS: dict[str, Reader] = {
    "YAML of a scene": Reader(
        copied(*(EXAMPLES / "scenes").glob("*.yaml"), also=(EXAMPLES / "scenes" / "hopper.stl",)), scene
    ),
    "YAML of a calibration": Reader(calibrations, question.read),
    "YAML of the configuration": Reader(copied(*CONFIG, also=(ROOT / "config" / "cases.csv",)), config),
    "CSV of the cases": Reader(copied(ROOT / "config" / "cases.csv"), cases),
    "CSV of answers": Reader(answers, scored, (score.Refused,)),
    "STL of a scene": Reader(surfaces, surface),
    "STL of a run": Reader(lambda folder: surfaces(folder)[:1], read_stl),
    "STL, by the reference": Reader(lambda folder: surfaces(folder)[:1], reference_stl.read, (ReplayError,)),
    "JSON of a bridge": Reader(
        copied(*EXAMPLES.glob("bridge*.json")), lambda path: bridge_query.answer(bridge_query.read(path))
    ),
    "JSON of a collision with a wall": Reader(copied(*EXAMPLES.glob("wall*.json")), wall),
    "JSON of colliding spheres": Reader(copied(*EXAMPLES.glob("*spheres.json")), spheres.read),
    "JSON of a run": Reader(run_json, json_of_run),
    "tables of a run": Reader(run_tables, table),
    "tables of a run, by the reference": Reader(run_tables, table_by_the_reference, (ReplayError,)),
    "raw logs of the engine": Reader(raw_logs, raw),
    "tables of the exact bridge": Reader(exact_tables, exact_table._read, ()),
}
