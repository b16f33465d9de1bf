"""One run, stage by stage, to the first who objects to it; and what a run leaves.

Not here: with which fault it runs, and in which process (`trial.py`).
"""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.faults import server
from tests.faults.packages import AFTER, BUILT, ROOT

STEADY = ("history/*.parquet", "*.parquet", "results/*.parquet", "scene.json", "stl/*", "vtk/*.vt*", "summary.json",
          "results/checks.json", "engine/in.liggghts", "engine/setup.liggghts", "engine/particles.data")  # fmt: skip
"""Files that are the same in every run without a fault; of summary.json what does not tell times."""
TIMES = ("wall_s", "particle_steps_per_s", "versions")
MADE = ("results", "summary.json", "replay.json")
"""What is made of a finished run."""


@dataclass(frozen=True)
class Verdict:
    """`by`: replay, program (it stopped, with a sentence), crash (a traceback or a signal), not reached, no effect, survives."""

    by: str
    message: str = ""


@dataclass(frozen=True)
class Way:
    """Run in which a fault is tried: its folder, configuration and plugin, and the module with the fault."""

    run: Path
    config: Path
    sound: Path
    """The same without a fault, already there for the modules after the engine."""
    module: str
    library: Path
    keep_counts: bool = False


def follow(way: Way) -> Verdict:
    """The stages of a run, to the first that somebody objects to."""
    from pywet.errors import PywetError

    try:
        return _built(way, part) if (part := way.module) in BUILT else _stages(way)
    except PywetError as error:
        crash = way.run / "engine.partial" / server.CRASH
        return Verdict("crash", crash.read_text()) if crash.exists() else Verdict("program", str(error))


def _stages(way: Way) -> Verdict:
    from pywet import stages
    from pywet.engines.liggghts import build
    from pywet.util import caches

    run, module = way.run, way.module
    shutil.rmtree(run, ignore_errors=True)
    if module in AFTER:
        shutil.copytree(way.sound, run, ignore=shutil.ignore_patterns("vtk", *(MADE if module == "results" else ())))
    else:
        server.engine_in_copy(way.keep_counts)
        stages.build(stages.resolved(way.config), 2, "smoke", run)
        if module == "scene" and (found := _of_scene(run)):
            return found
        shutil.copy(way.library, build.cached())
        caches.seal(build.cached())
        stages.simulate(run, 1, progress=False)
    if module != "view":
        stages.results(run)
        found = _of_results(run) if module == "results" else _of_replay(stages.replay(run))
        if found:
            return found
    return (module in ("view", "") and _of_view(run)) or Verdict("survives")


def _built(way: Way, part: str) -> Verdict:
    """Inputs alone: of case 2, or of the example scenes."""
    import yaml

    from pywet import stages
    from pywet.cases.custom import building
    from pywet.cases.custom.description import Scene

    shutil.rmtree(way.run, ignore_errors=True)
    if part == "planning":
        stages.build(stages.resolved(way.config), 2, "smoke", way.run)
        return _of_scene(way.run) or Verdict("survives", "inputs of case 2")
    for path in sorted((ROOT / "examples/scenes").glob("*.yaml")) if part == "custom" else ():
        building.write(Scene(**yaml.safe_load(path.read_text()), folder=path.parent), way.run / path.stem)
        if found := _of_scene(way.run / path.stem):
            return found
    return Verdict("survives", "inputs of the examples" if part == "custom" else "no inputs are built")


def import_all() -> None:
    """Everything that a trial needs."""
    for name in (
        "engines.liggghts.worker",
        "report.vtk",
        "cases.screening.identity",
        "cases.screening.results",
    ):
        import_module(f"pywet.{name}")
    for name in ("replay.command", "shown.vtk"):
        import_module(f"reference_impl.{name}")


def _of_scene(run: Path) -> Verdict | None:
    from reference_impl.replay.io import ReplayError
    from reference_impl.scene import check

    try:
        section = check.check(run)
    except (ReplayError, OSError):
        return None  # the same message again, with the engine's files
    bad = [q.name for q in section.quantities if not q.ok]
    return Verdict("replay", _finding([f for f in section.findings], bad)) if bad else None


def _of_results(run: Path) -> Verdict | None:
    from reference_impl.tables import check

    section = check.check(run)
    bad = [q.name for q in section.quantities if not q.ok]
    return Verdict("replay", _finding([f for f in section.findings], bad)) if bad else None


def _of_view(run: Path) -> Verdict | None:
    from pywet.report import vtk as series
    from reference_impl.replay.io import ReplayError
    from reference_impl.shown import vtk

    series.write(run)
    try:
        wrong = vtk.disagreement(run)
    except ReplayError as error:  # the reference rejects the file
        wrong = str(error)
    return Verdict("replay", wrong) if wrong else None


def _of_replay(content: dict[str, Any] | None) -> Verdict | None:
    if content is None or content["ok"]:
        return None
    bad = [name for name, q in content["quantities"].items() if not q["ok"]]
    return Verdict("replay", _finding((content["diagnosis"] or {}).get("findings", []), bad))


def _finding(findings: list[Any], bad: list[str]) -> str:
    """What the diagnosis says first of the residuals, else the sentence of a section, else what is beyond its limit."""
    first = findings[0] if findings else None
    sentence = (
        (first.get("known") or first.get("sentence")) if isinstance(first, dict) else getattr(first, "sentence", None)
    )
    return str(sentence) if sentence else f"beyond: {', '.join(bad)}"


def marks(run: Path) -> dict[str, str]:
    """Hashes of all that a run without a fault always leaves alike."""
    paths = sorted({p for pattern in STEADY for p in run.glob(pattern)})
    return {str(p.relative_to(run)): hashlib.sha256(_steady(p)).hexdigest() for p in paths}


def _steady(path: Path) -> bytes:
    if path.name != "summary.json":
        return path.read_bytes()
    content = json.loads(path.read_text())
    return json.dumps({k: v for k, v in content.items() if k not in TIMES}, sort_keys=True).encode()
