"""The plugin with a fault, quickly: objects of the sources that do not depend on the changed file are stored."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path


class Objects:
    """The plugin's sources in a copy of the program at `root`, compiled once in `folder`: little optimised, or with `flags`."""

    def __init__(self, root: Path, folder: Path, *flags: str) -> None:
        from pywet.engines import process
        from pywet.engines.liggghts import build

        self.sources = root / "pywet/engines/liggghts/plugin"
        self.folder = folder
        mpi = [process.output_of(["mpicxx", f"--showme:{what}"]).split() for what in ("compile", "link")]
        stored = [flag for flag in (*build.FLAGS, *build.LOOPS, *build.VISIBILITY) if flag not in ("-O3", "-shared")]
        version = f'-DPYWET_ENGINE_VERSION="{build.engine_version()}"'
        self._compile = [
            "g++",
            *stored,
            *(flags or ("-O1",)),
            version,
            f"-I{self.sources}",
            f"-I{build.INCLUDE}",
            *mpi[0],
        ]
        self._libraries = [*flags, "-l:libliggghts.so.3", *mpi[1]]
        folder.mkdir(parents=True, exist_ok=True)
        for path in self._all():
            if not (folder / f"{path.stem}.o").exists() and not self._object(path, folder):
                raise SystemExit(f"{path.name} does not compile")

    def _all(self) -> list[Path]:
        return sorted(self.sources.glob("*.cpp"))

    def _object(self, source: Path, folder: Path) -> bool:
        words = [*self._compile, "-MMD", "-c", str(source), "-o", str(folder / f"{source.stem}.o")]
        return subprocess.run(words, capture_output=True, check=False, cwd=folder).returncode == 0

    def _uses(self, source: Path, changed: Path) -> bool:
        text = (self.folder / f"{source.stem}.d").read_text()
        return changed.name in {Path(word).name for word in re.split(r"[\s\\]+", text)}

    def library(self, target: Path, changed: Path | None = None) -> bool:
        """Link the plugin, with what depends on `changed` compiled again; whether it compiles."""
        fresh = self.folder / "fresh"
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir()
        anew = [source for source in self._all() if changed and self._uses(source, changed)]
        if not all(self._object(source, fresh) for source in anew):
            return False
        objects = [str((fresh if source in anew else self.folder) / f"{source.stem}.o") for source in self._all()]
        words = ["g++", "-shared", *objects, "-o", str(target), *self._libraries]
        return subprocess.run(words, capture_output=True, check=False).returncode == 0
