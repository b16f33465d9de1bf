"""Find YADE's modules and build the plugin for it from the engine-independent sources of engines/liggghts."""

from __future__ import annotations

from pathlib import Path

from pywet.engines import process
from pywet.engines.lammps.build import SOURCES as OTHER
from pywet.engines.liggghts import build
from pywet.util import caches

PROGRAM = ("YADE", "2023.02a", "make peers")
"""Name and version of the program, and the command that installs it."""
SOURCES = Path(__file__).parent / "plugin"
PACKAGES = ["/usr/lib/x86_64-linux-gnu/yade-double/py", "/usr/lib/python3/dist-packages"]
"""Folders of YADE's modules, and of those that they import."""


def engine_version() -> str:
    """Return the version of Debian's package; `EngineError` if it is missing or unsupported."""
    return process.installed(*PROGRAM)


def plugin_path() -> Path:
    """Return the path of the plugin, built if it is not in the cache (half a minute)."""
    of_both = [OTHER / f"{name}.cpp" for name in ("contacts", "meshes", "movers")]
    version, host = engine_version(), [*sorted(SOURCES.glob("*")), *of_both]
    not_here = {build.SOURCES / name for name in ("script.cpp", *(path.name for path in host))}
    shared = sorted(set(build.SOURCES.glob("*")) - not_here)
    target = caches.folder() / f"libpywet-yade-{build.hash_of([*shared, *host], version)}.so"
    if not caches.whole(target):
        mpi = [process.output_of(["mpicxx", f"--showme:{what}"]).split() for what in ("compile", "link")]
        before = [f'-DPYWET_ENGINE_VERSION="{version}"', f"-I{build.SOURCES}", f"-I{SOURCES}", *mpi[0]]
        sources = [path for path in (*shared, *host) if path.suffix == ".cpp"]
        build.compile_to(target, before, sources, mpi[1], f"YADE {version}")
    return target
