"""One fault tried: the smallest moist case that comes to its line is run with it, and the message of the run is the verdict.

Works in copies of one process that has all imported (`server.py`). The tests of the program are asked by `asked.py`.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.faults import reach, scenes, server
from tests.faults.follow import Verdict, Way, follow, import_all, marks
from tests.faults.mutants import Mutant
from tests.faults.native import Objects
from tests.faults.packages import BUILT, below, files, law_of, reached

LIMIT_S = 900.0


@dataclass
class Bench:
    """Workplace of trials: the copy of the program, its objects, and the outputs and executed lines of correct runs."""

    out: Path
    sound: dict[str, dict[str, str]] = field(default_factory=dict)
    lines: dict[str, reach.Lines] = field(default_factory=dict)

    @property
    def tree(self) -> Path:
        return self.out / "tree"

    @property
    def run(self) -> Path:
        return self.tree / "run"

    @property
    def library(self) -> Path:
        return self.out / "plugin.so"

    def files(self, module: str) -> list[Path]:
        """Return the files of a module in the copy; the program itself may change meanwhile."""
        return files(module, self.tree / "pywet")

    def open(self, modules: Sequence[str]) -> None:
        """Import everything from a new copy of the program; where these modules need it, compile and run each scene."""
        of, now = self.out / "sources.txt", scenes.sources()
        if not of.exists() or of.read_text() != now:
            for name in ("objects", "counting", "sound"):
                shutil.rmtree(self.out / name, ignore_errors=True)
        scenes.copy(self.tree)
        of.write_text(now)
        os.environ |= {
            "PYWET_CACHE": str(self.out / "cache"),
            "PYTHONPATH": str(self.tree),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        sys.path.insert(0, str(self.tree))
        sys.dont_write_bytecode = True
        os.chdir(self.tree)
        import_all()
        scenes.configure(self._way("paper").config, "paper")
        if set(modules) <= set(BUILT):
            return
        self.objects = Objects(self.tree, self.out / "objects")
        self.counting = Objects(self.tree, self.out / "counting", "-O0", "--coverage")
        self.objects.library(self.library)
        for scene in scenes.SCENES:
            self._know(scene)

    def _way(self, scene: str, module: str = "", library: Path | None = None, keep_counts: bool = False) -> Way:
        config = self.tree / f"config_{scene.replace('=', '_')}"
        return Way(self.run, config, self.out / "sound" / scene / "run", module, library or self.library, keep_counts)

    def _know(self, scene: str) -> None:
        """Marks of a sound run, and of a scene by name the lines it comes to."""
        stored = self.out / "sound" / scene
        scenes.configure(self._way(scene).config, scene)
        if not (stored / "known.json").exists():
            first = self._sound(scene)
            shutil.rmtree(stored, ignore_errors=True)
            shutil.copytree(self.run, stored / "run")
            lines = {} if "=" in scene else self._reached(scene)
            if self._sound(scene) != first:
                raise SystemExit(f"two sound runs of scene {scene} differ")
            (stored / "known.json").write_text(
                json.dumps({"marks": first, "lines": {k: sorted(v) for k, v in lines.items()}})
            )
        known = json.loads((stored / "known.json").read_text())
        self.sound[scene] = known["marks"]
        self.lines[scene] = {name: set(numbers) for name, numbers in known["lines"].items()}

    def _sound(self, scene: str) -> dict[str, str]:
        verdict = server.in_copy(lambda: self._trial(self._way(scene), None), LIMIT_S)
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
                if not name.startswith(("pywet.laws", "pywet.util.machine_code")):
                    del sys.modules[name]
            with reach.traced(self.tree / "pywet") as lines:
                verdict = follow(self._way(scene, library=library, keep_counts=True))
            return {"by": verdict.by, "lines": {name: sorted(numbers) for name, numbers in lines.items()}}

        answer = server.in_copy(work, LIMIT_S)
        if answer.get("by") != "survives":
            raise SystemExit(f"the counting run of scene {scene}: {answer}")
        lines = reach.recorded(self.run / "engine" / server.REACHED)
        for name, numbers in answer["lines"].items():
            lines.setdefault(name, set()).update(numbers)
        return lines | reach.counted(self.objects.sources, self.counting.folder)

    def scenes_for(self, mutant: Mutant) -> list[str]:
        """The scenes that come to the line, then those that come to one next to it; for a law that none uses one with it."""
        name = below(mutant.path)
        if name.startswith("laws/"):
            law = law_of(mutant)
            if law is None or law == ("dynamic_rupture", "pitois"):
                return ["paper"]
            scene = "=".join(law)
            used = json.loads((self.out / "sound/paper/run/scene.json").read_text())["effects"]
            if used.get(law[0]) == law[1]:
                return ["paper"]
            if scene not in self.sound:
                self._know(scene)
            return [scene]
        if mutant.path.suffix == ".j2":
            return ["paper"]
        found = [
            s for beside in (0, 1) for s in scenes.SCENES if reached(self.lines[s].get(name, set()), mutant, beside)
        ]
        return list(dict.fromkeys(found))

    @contextmanager
    def injected(self, mutant: Mutant) -> Iterator[None]:
        """The fault in the copy of the program, and the file as it was afterwards, its time included."""
        before = mutant.path.read_bytes(), mutant.path.stat()
        mutant.path.write_text(mutant.text)
        try:
            yield
        finally:
            mutant.path.write_bytes(before[0])
            os.utime(mutant.path, ns=(before[1].st_atime_ns, before[1].st_mtime_ns))

    def plugin(self, mutant: Mutant) -> Path | None:
        """The plugin with the injected fault; None where that does not compile."""
        if mutant.path.suffix not in (".cpp", ".h"):
            return self.library
        library = self.out / "mutant.so"
        return library if self.objects.library(library, mutant.path) else None

    def judge(self, mutant: Mutant, module: str) -> Verdict | None:
        """Return what detects a fault; None for a fault that does not compile."""
        if mutant.path.suffix == ".py":
            try:
                compile(mutant.text, str(mutant.path), "exec")
            except SyntaxError:
                return None
        named = ["paper"] if module in BUILT else self.scenes_for(mutant)
        with self.injected(mutant):
            library = self.plugin(mutant)
            if library is None:
                return None
            verdict = Verdict("not reached")
            for scene in named:
                now = self._in(scene, mutant, module, library)
                verdict = now if now.by != "no effect" or verdict.by == "not reached" else verdict
                if verdict.by not in ("no effect", "survives"):
                    break
        return verdict

    def _in(self, scene: str, mutant: Mutant, module: str, library: Path) -> Verdict:
        """Return what detects a fault in one scene."""
        answer = server.in_copy(lambda: self._trial(self._way(scene, module, library), mutant), LIMIT_S)
        if "crash" in answer:
            return Verdict("crash", answer["crash"])
        if answer["by"] == "survives" and module not in BUILT:
            return self._changed(scene, module)
        return Verdict(answer["by"], answer["message"])

    def _changed(self, scene: str, part: str) -> Verdict:
        """Return whether a run that nothing objects to left other files than the correct one."""
        now, then = ({n: m for n, m in made.items() if part in ("view", "") or not n.startswith("vtk/")}
                     for made in (marks(self.run), self.sound[scene]))  # fmt: skip
        changed = sorted(name for name in now.keys() | then.keys() if now.get(name) != then.get(name))
        output_text = f"{scene}: changes {', '.join(changed[:4])}"
        return Verdict("survives", output_text) if changed else Verdict("no effect", scene)

    def _trial(self, way: Way, mutant: Mutant | None) -> dict[str, Any]:
        """In a copy of the process."""
        if mutant is not None and mutant.path.suffix == ".py":
            if way.module == "laws":
                from numba import config  # type: ignore[import-untyped]

                fresh = self.out / "compiled"
                shutil.rmtree(fresh, ignore_errors=True)
                fresh.mkdir()
                config.CACHE_DIR = str(fresh)
            name = ".".join(mutant.path.relative_to(self.tree).with_suffix("").parts).removesuffix(".__init__")
            server.forget(name, self.tree)
        verdict = follow(way)
        return {"by": verdict.by, "message": verdict.message}
