"""One fault tried: the smallest moist case that comes to its line is run with it, and what is said of the run is the verdict.

Works in copies of one process that has all imported (`server.py`). The tests of the program are asked by `asked.py`.
"""

from __future__ import annotations

import ast
import hashlib
import json
import os
import shutil
import sys
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.faults import reach, server
from tests.faults.mutants import Mutant
from tests.faults.native import Objects

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pywet"
ROOMS: dict[str, tuple[str, ...]] = {
    "plugin": ("engines/liggghts/plugin/*.cpp", "engines/liggghts/plugin/*.h"),
    "laws": tuple(
        f"laws/{name}.py"
        for name in ("capillary", "capillary_fits", "contact", "formation", "rupture", "transfer", "viscous")
    ),
    "driver": ("engines/schedule.py", "engines/liggghts/*.py", "engines/liggghts/*.j2", "runs/*.py"),
    "scene": (
        "screening/cases.py",
        "screening/amounts.py",
        "apparatus/*.py",
        "config/materials.py",
        "config/scales.py",
    ),
    "results": ("screening/results.py", "screening/summary.py"),
    "view": ("report/vtk.py",),
}
"""Room -> its files, below pywet/."""
LEFT_OUT = ("build.py",)
"""Trials have the plugin compiled in a way of their own."""
NEEDED = ("reference_impl", "liggghts_inputs", "workflow", "tests", "docs", "examples", "pyproject.toml", "README.md",
          "constraints.txt", "Makefile", "Snakefile", "setup.py", "MANIFEST.in", "tools", "benchmarks",
          "CHANGELOG.md")  # fmt: skip
SMALL = {
    "width_mm: {value: 50": "width_mm: {value: 40", "duration_s: {value: 1.6": "duration_s: {value: 0.2",
    "slide_opens_at_s: {value: 0.2": "slide_opens_at_s: {value: 0.08",
}  # fmt: skip
"""What makes the smoke scale's case 2 a matter of seconds."""
SETTINGS = {"energy: false": "energy: true", "checkpoints: 20": "checkpoints: 3"}
OTHER = {"viscous_integration: explicit": "viscous_integration: semi_implicit", "liquid_weight: auto": "liquid_weight: on",
         "shedding: auto": "shedding: on"}  # fmt: skip
"""Settings of a second scene, for lines that the first does not come to; its wires are prisms."""
RARE = {"bridges_every: 1": "bridges_every: 2"}
SCENES: dict[str, dict[str, str]] = {"paper": {}, "other": OTHER, "rare": RARE}
STEADY = ("history/*.parquet", "*.parquet", "results/*.parquet", "scene.json", "stl/*", "vtk/*.vt*", "summary.json",
          "results/checks.json", "engine/in.liggghts", "engine/setup.liggghts", "engine/particles.data")  # fmt: skip
"""Files that are the same in every run without a fault; of summary.json what does not tell times."""
TIMES = ("wall_s", "particle_steps_per_s", "versions")
MADE = ("results", "summary.json", "replay.json")
"""What is made of a finished run."""
AFTER = ("results", "view")
"""Rooms that work on a finished run."""
LIMIT_S = 900.0


@dataclass(frozen=True)
class Verdict:
    """`by`: replay, program (it stopped, with a sentence), crash (a traceback or a signal), not reached, no effect, survives."""

    by: str
    said: str = ""


def files(room: str) -> list[Path]:
    """Files of a room that there are."""
    return sorted(p for pattern in ROOMS[room] for p in PACKAGE.glob(pattern) if p.name not in LEFT_OUT)


def copy(folder: Path) -> Path:
    """The program in a folder of its own."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(PACKAGE, folder / "pywet", ignore=shutil.ignore_patterns("__pycache__"))
    for name in NEEDED:
        (folder / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "config", folder / "config")
    return folder


def configure(config: Path, scene: str) -> None:
    """The configuration of a scene: small, and with its settings; `KIND=LAW` is the first scene with another law."""
    shutil.rmtree(config, ignore_errors=True)
    shutil.copytree(ROOT / "config", config)
    scales, settings = config / "scales.yaml", config / "config.yaml"
    head, smoke, tail = scales.read_text().partition("  smoke:\n")
    for old, new in SMALL.items():
        tail = tail.replace(old, new, 1)
    scales.write_text(head + smoke + ("    wires: prism\n" if scene == "other" else "") + tail)
    kind, _, law = scene.partition("=")
    text = settings.read_text()
    for old, new in (
        SETTINGS | (SCENES[scene] if not law else {"preset: paper ": f"{kind}: {law}\n  preset: paper "})
    ).items():
        if old not in text:
            raise SystemExit(f"config.yaml has no {old!r} any more: mend tests/faults/trial.py")
        text = text.replace(old, new, 1)
    settings.write_text(text)


@dataclass
class Bench:
    """Where trials are made: the copy of the program, its objects, and what sound runs leave and come to."""

    out: Path
    sound: dict[str, dict[str, str]] = field(default_factory=dict)
    lines: dict[str, reach.Lines] = field(default_factory=dict)

    @property
    def tree(self) -> Path:
        return self.out / "tree"

    @property
    def run(self) -> Path:
        return self.tree / "run"

    def open(self) -> None:
        """Import everything from a new copy of the program, compile it, and run each scene without a fault."""
        copy(self.tree)
        os.environ |= {
            "PYWET_CACHE": str(self.out / "cache"),
            "PYTHONPATH": str(self.tree),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        sys.path.insert(0, str(self.tree))
        sys.dont_write_bytecode = True
        os.chdir(self.tree)
        self.objects = Objects(self.tree, self.out / "objects")
        self.counting = Objects(self.tree, self.out / "counting", "-O0", "--coverage")
        self.library = self.out / "plugin.so"
        self.objects.library(self.library)
        _import_all()
        for scene in SCENES:
            self._know(scene)

    def _know(self, scene: str) -> None:
        """Marks of a sound run, and of a scene by name the lines it comes to."""
        kept, config = self.out / "sound" / scene, self.tree / f"config_{scene.replace('=', '_')}"
        configure(config, scene)
        if not (kept / "known.json").exists():
            first = self._sound(scene)
            shutil.rmtree(kept, ignore_errors=True)
            shutil.copytree(self.run, kept / "run")
            lines = {} if "=" in scene else self._reached(scene)
            if self._sound(scene) != first:
                raise SystemExit(f"two sound runs of scene {scene} differ")
            (kept / "known.json").write_text(
                json.dumps({"marks": first, "lines": {k: sorted(v) for k, v in lines.items()}})
            )
        known = json.loads((kept / "known.json").read_text())
        self.sound[scene] = known["marks"]
        self.lines[scene] = {name: set(numbers) for name, numbers in known["lines"].items()}

    def _sound(self, scene: str) -> dict[str, str]:
        verdict = server.in_copy(lambda: self._trial(scene, None, ""), LIMIT_S)
        if verdict.get("by") != "survives":
            raise SystemExit(f"the program without a fault, scene {scene}: {verdict}")
        return marks(self.run)

    def _reached(self, scene: str) -> reach.Lines:
        library = self.out / "counting.so"
        self.counting.library(library)
        for path in self.counting.folder.glob("*.gcda"):
            path.unlink()

        def work() -> dict[str, Any]:
            for name in [m for m in sys.modules if m.startswith("pywet.")]:
                if not name.startswith(("pywet.laws", "pywet.machine_code")):
                    del sys.modules[name]
            with reach.traced(self.tree / "pywet") as lines:
                verdict = self._follow(scene, "", library, keep_counts=True)
            return {"by": verdict.by, "lines": {name: sorted(numbers) for name, numbers in lines.items()}}

        answer = server.in_copy(work, LIMIT_S)
        if answer.get("by") != "survives":
            raise SystemExit(f"the counting run of scene {scene}: {answer}")
        python = {name: set(numbers) for name, numbers in answer["lines"].items()}
        return python | reach.counted(self.objects.sources, self.counting.folder)

    def scene_for(self, mutant: Mutant) -> str | None:
        """The first scene that comes to the line; for a law that none uses one with it; None where there is none."""
        name = str(mutant.path.relative_to(PACKAGE))
        if name.startswith("laws/"):
            law = law_of(mutant)
            if law is None or law == ("dynamic_rupture", "pitois"):
                return "paper"
            scene = "=".join(law)
            used = json.loads((self.out / "sound/paper/run/scene.json").read_text())["effects"]
            if used.get(law[0]) == law[1]:
                return "paper"
            if scene not in self.sound:
                self._know(scene)
            return scene
        if mutant.path.suffix == ".j2":
            return "paper"
        return next((s for s in SCENES if reached(self.lines[s].get(name, set()), mutant)), None)

    def judge(self, mutant: Mutant, room: str) -> Verdict | None:
        """Who notices; None for a fault that does not compile."""
        place = self.tree / mutant.path.relative_to(ROOT)
        before = place.read_text(), place.stat()
        place.write_text(mutant.text)
        try:
            library = self.library
            if mutant.path.suffix == ".py":
                try:
                    compile(mutant.text, str(place), "exec")
                except SyntaxError:
                    return None
            scene = self.scene_for(mutant)
            if mutant.path.suffix in (".cpp", ".h"):
                library = self.out / "mutant.so"
                if not self.objects.library(library, place):
                    return None
            if scene is None:
                return Verdict("not reached")
            answer = server.in_copy(lambda: self._trial(scene, mutant, room, library), LIMIT_S)
        finally:
            place.write_text(before[0])
            os.utime(place, ns=(before[1].st_atime_ns, before[1].st_mtime_ns))
        if "crash" in answer:
            return Verdict("crash", answer["crash"][:200])
        if answer["by"] == "survives":
            now, then = ({n: m for n, m in made.items() if room in ("view", "") or not n.startswith("vtk/")}
                         for made in (marks(self.run), self.sound[scene]))  # fmt: skip
            changed = sorted(name for name in now.keys() | then.keys() if now.get(name) != then.get(name))
            return (
                Verdict("survives", f"{scene}: changes {', '.join(changed[:4])}")
                if changed
                else Verdict("no effect", scene)
            )
        return Verdict(answer["by"], answer["said"])

    def _trial(self, scene: str, mutant: Mutant | None, room: str, library: Path | None = None) -> dict[str, Any]:
        """In a copy of the process."""
        if mutant is not None and mutant.path.suffix == ".py":
            from numba import config  # type: ignore[import-untyped]

            name = ".".join(mutant.path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
            if room == "laws":
                fresh = self.out / "compiled"
                shutil.rmtree(fresh, ignore_errors=True)
                fresh.mkdir()
                config.CACHE_DIR = str(fresh)
            server.forget(name, self.tree)
        verdict = self._follow(scene, room, library or self.library)
        return {"by": verdict.by, "said": verdict.said}

    def _follow(self, scene: str, room: str, library: Path, keep_counts: bool = False) -> Verdict:
        """The stages of a run, to the first that somebody objects to."""
        from pywet.errors import PywetError

        try:
            return self._stages(scene, room, library, keep_counts)
        except PywetError as error:
            crash = self.run / "engine.partial" / server.CRASH
            return Verdict("crash", crash.read_text()) if crash.exists() else Verdict("program", str(error)[:200])

    def _stages(self, scene: str, room: str, library: Path, keep_counts: bool) -> Verdict:
        from pywet import caches, stages
        from pywet.engines.liggghts import build

        run, kept = self.run, self.out / "sound" / scene / "run"
        shutil.rmtree(run, ignore_errors=True)
        if room in AFTER:
            shutil.copytree(kept, run, ignore=shutil.ignore_patterns("vtk", *(MADE if room == "results" else ())))
        else:
            server.engine_in_copy(keep_counts)
            config = stages.resolved(self.tree / f"config_{scene.replace('=', '_')}")
            stages.build(config, 2, "smoke", run)
            if room == "scene" and (found := _of_scene(run)):
                return found
            shutil.copy(library, build.kept())
            caches.seal(build.kept())
            stages.simulate(run, 1, progress=False)
        if room != "view":
            stages.results(run)
            found = _of_results(run) if room == "results" else _of_replay(stages.replay(run))
            if found:
                return found
        if room in ("view", ""):
            return _of_view(run) or Verdict("survives")
        return Verdict("survives")


def _import_all() -> None:
    """Everything that a trial needs."""
    for name in (
        "engines.liggghts.worker",
        "report.vtk",
        "screening.identity",
        "screening.results",
        "screening.summary",
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
        return None  # said again, with the engine's files
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
    except ReplayError as error:  # the reference cannot read it, and says so
        wrong = str(error)
    return Verdict("replay", wrong[:200]) if wrong else None


def _of_replay(content: dict[str, Any] | None) -> Verdict | None:
    if content is None or content["ok"]:
        return None
    bad = [name for name, q in content["quantities"].items() if not q["ok"]]
    return Verdict("replay", _finding((content["diagnosis"] or {}).get("findings", []), bad))


def _finding(findings: list[Any], bad: list[str]) -> str:
    """The first sentence of the diagnosis, else what is beyond its limit."""
    first = findings[0] if findings else None
    sentence = first.get("sentence") if isinstance(first, dict) else getattr(first, "sentence", None)
    return str(sentence)[:200] if sentence else f"beyond: {', '.join(bad)}"[:200]


def marks(run: Path) -> dict[str, str]:
    """Hashes of all that a run without a fault always leaves alike."""
    paths = sorted({p for pattern in STEADY for p in run.glob(pattern)})
    return {str(p.relative_to(run)): hashlib.sha256(_steady(p)).hexdigest() for p in paths}


def _steady(path: Path) -> bytes:
    if path.name != "summary.json":
        return path.read_bytes()
    content = json.loads(path.read_text())
    return json.dumps({k: v for k, v in content.items() if k not in TIMES}, sort_keys=True).encode()


def reached(lines: set[int], mutant: Mutant) -> bool:
    """Whether a run comes to the statement of the fault, or, where lines do not tell, to its file."""
    if mutant.path.suffix != ".py":
        return bool(lines & {mutant.line, mutant.line - 1, mutant.line + 1})
    inner = [n for n in ast.walk(ast.parse(mutant.path.read_text())) if isinstance(n, ast.stmt)
             and n.lineno <= mutant.line <= (n.end_lineno or n.lineno)]  # fmt: skip
    if not inner:
        return bool(lines)
    smallest = min(inner, key=lambda n: (n.end_lineno or n.lineno) - n.lineno)
    return any(smallest.lineno <= line <= (smallest.end_lineno or smallest.lineno) for line in lines)


def law_of(mutant: Mutant) -> tuple[str, str] | None:
    """Kind and name of the law whose function holds the fault."""
    for node in ast.parse(mutant.path.read_text()).body:
        if isinstance(node, ast.FunctionDef) and node.lineno <= mutant.line <= (node.end_lineno or 0):
            for mark in node.decorator_list:
                if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "force_law" and mark.args:
                    words = [str(ast.literal_eval(a)) for a in mark.args]
                    return words[0], words[1] if len(words) > 1 else node.name
    return None
