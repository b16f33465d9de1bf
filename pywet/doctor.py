"""What this machine has and what is missing: engine, compiler, MPI, Python packages, plugin, disk."""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from pywet.engines.liggghts import build
from pywet.errors import PywetError

MEND = "run `make setup`"
FREE_GB = 2.0
CONSTRAINTS = Path(__file__).parents[1] / "constraints.txt"
MAIN_PACKAGES = ("numpy", "scipy", "pandas", "pyarrow", "numba", "pydantic", "meshio", "pyvista", "matplotlib", "snakemake")


@dataclass(frozen=True)
class Check:
    """One thing that is needed: what was found, which version, what is needed, and how to mend it."""

    name: str
    found: str | None
    version: str | None
    needed: str
    ok: bool
    mend: str = ""


def checks() -> list[Check]:
    """All checks, in the order in which they are needed."""
    return [
        _program("liggghts", "liggghts", build.ENGINE_VERSION),
        _package("engine headers", "libliggghts-dev", build.ENGINE_VERSION),
        _program("mpirun", "openmpi-bin", ""),
        _program("mpicxx", "libopenmpi-dev", ""),
        _program("g++", "g++", ""),
        _python(),
        *(_python_package(name, version) for name, version in pinned().items() if name in MAIN_PACKAGES),
        _plugin(),
        _disk(),
    ]


def pinned() -> dict[str, str]:
    """Versions in constraints.txt."""
    if not CONSTRAINTS.exists():
        return {}
    lines = [line.strip() for line in CONSTRAINTS.read_text().splitlines()]
    return {name.lower(): version for name, _, version in (line.partition("==") for line in lines if "==" in line)}


def _program(program: str, package: str, needed: str) -> Check:
    path, version = shutil.which(program), build.package_version(package)
    return Check(program, path, version, needed or "any", path is not None and _fits(version, needed), MEND)


def _package(name: str, package: str, needed: str) -> Check:
    version = build.package_version(package)
    return Check(name, package if version else None, version, needed, version is not None and _fits(version, needed), MEND)


def _fits(version: str | None, needed: str) -> bool:
    return version is None or version.startswith(needed)


def _python() -> Check:
    version = sys.version.split()[0]
    return Check("python", sys.executable, version, "3.11", sys.version_info >= (3, 11), "install Python 3.11 or newer")


def _python_package(name: str, needed: str) -> Check:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return Check(name, None, None, needed, False, MEND)
    return Check(name, "installed", version, needed, version == needed, MEND)


def _plugin() -> Check:
    try:
        path = build.cache_folder() / f"libpywet-{build.source_hash()}.so"
    except PywetError as error:
        return Check("plugin", None, None, "built", False, str(error))
    return Check("plugin", str(path) if path.exists() else None, None, "built", path.exists(), MEND)


def _disk() -> Check:
    free = shutil.disk_usage(Path.cwd()).free / 1e9
    return Check("free disk", f"{free:.1f} GB", None, f"{FREE_GB:g} GB", free >= FREE_GB, "free some space")


def main() -> int:
    """Print the checks; 0 when nothing that is needed is missing."""
    from rich.console import Console
    from rich.table import Table

    table = Table("", "what", "version", "needed", "found or how to mend it")
    found = checks()
    for c in found:
        table.add_row("ok" if c.ok else "MISSING", c.name, c.version or "", c.needed, (c.found or "") if c.ok else c.mend)
    Console(width=140).print(table)
    bad = [c for c in found if not c.ok]
    for c in bad:
        print(f"{c.name}: {c.version or c.found or 'nothing'} was found, {c.needed} is needed; {c.mend}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
