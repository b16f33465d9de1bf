"""Report which requirements this machine meets and lacks: engine, compiler, MPI, Python packages, plugin, disk.

It installs nothing.
"""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import sys
import tempfile
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

from pywet.engines import process
from pywet.engines.lammps import build as lammps
from pywet.engines.liggghts import build
from pywet.errors import PywetError, border
from pywet.util import caches

FIX = "run `make setup`"
LIBRARY = "libliggghts.so.3"
FREE_GB = 2.0
CONSTRAINTS = Path(__file__).parents[2] / "constraints.txt"
MAIN_PACKAGES = (
    "numpy", "scipy", "pandas", "pyarrow", "numba", "pydantic", "meshio", "pyvista", "matplotlib", "jinja2", "snakemake",
    "typer", "rich",
)  # fmt: skip


@dataclass(frozen=True)
class Check:
    """A requirement: what was found, which version, what is needed, and how to fix it."""

    name: str
    found: str | None
    version: str | None
    needed: str
    ok: bool
    fix: str = FIX

    def sentence(self) -> str:
        what = self.version if self.found and self.version else self.found or "nothing"
        return f"{self.name}: {what} was found, {self.needed} is needed: {self.fix}"


def checks() -> list[Check]:
    """Return all checks, in the order in which they are needed."""
    version, current = sys.version.split()[0], sys.version_info >= (3, 11)
    return [
        _engine(),
        _library(),
        _headers(),
        *(Check(n, shutil.which(n), None, "any", shutil.which(n) is not None) for n in ("mpirun", "mpicxx", "g++")),
        Check("python", sys.executable, version, "3.11", current, "install Python 3.11 or newer"),
        *(_python_package(name, version) for name, version in pinned().items() if name in MAIN_PACKAGES),
        _plugin(),
        _lammps(),
        _disk(),
    ]


def pinned() -> dict[str, str]:
    """Versions in constraints.txt by lower-case name; empty where the package is installed without its repository."""
    if not CONSTRAINTS.exists():
        return {}
    lines = [line.strip() for line in CONSTRAINTS.read_text().splitlines()]
    return {name.lower(): version for name, _, version in (line.partition("==") for line in lines if "==" in line)}


def banner_version(program: str) -> str | None:
    """Return the version in the first line that the engine prints; None if there is none."""
    with tempfile.TemporaryDirectory() as folder:  # it writes log.liggghts into its working directory
        message = process.output_of([program, "-log", "none"], "\n", Path(folder))
    named = re.search(r"LIGGGHTS[^,]*?(\d+\.\d+\.\d+)", message)
    return named.group(1) if named else None


def _engine() -> Check:
    path = shutil.which("liggghts")
    if path is None:
        return Check("liggghts", None, None, build.ENGINE_VERSION, False)
    try:
        version, why = banner_version(path), "it does not start"
    except PywetError as error:
        version, why = None, str(error)
    if version is None:
        fix = f"{why}; run `liggghts -h` to see why, or apt-get install --reinstall liggghts"
        return Check("liggghts", path, None, build.ENGINE_VERSION, False, fix)
    return Check("liggghts", path, version, build.ENGINE_VERSION, version == build.ENGINE_VERSION, _other(path))


def _library() -> Check:
    try:
        ctypes.CDLL(LIBRARY)
    except OSError as error:
        return Check(LIBRARY, None, None, "any", False, f"it does not load ({error}); {FIX}")
    return Check(LIBRARY, "loads", process.package_version("libliggghts3"), "any", True)


def _headers() -> Check:
    version = process.package_version("libliggghts-dev")
    headers = str(build.INCLUDE) if build.INCLUDE.is_dir() else None
    ok = headers is not None and version is not None and version.startswith(build.ENGINE_VERSION)
    return Check(
        "engine headers", headers, version, build.ENGINE_VERSION, ok, _other("libliggghts-dev") if version else FIX
    )


def _other(what: str) -> str:
    return f"replace {what} by Debian 12's {build.ENGINE_VERSION}, the only version that the plugin is written for"


def _python_package(name: str, needed: str) -> Check:
    try:
        version = metadata.version(name)
    except metadata.PackageNotFoundError:
        return Check(name, None, None, needed, False)
    return Check(name, "installed", version, needed, version == needed)


def _plugin() -> Check:
    try:
        path = build.cached()
    except PywetError as error:
        return Check("plugin", None, None, "a built one", False, str(error))
    return Check("plugin", str(path) if path.exists() else None, None, "a built one", caches.whole(path))


def _lammps() -> Check:
    """Check LAMMPS, which is optional; if installed, it must be the version that the plugin is written for."""
    needed = f"{lammps.VERSION} or none (`make peers`)"
    try:
        return Check("lammps", str(lammps.packages()), lammps.engine_version(), needed, True)
    except PywetError as error:
        there = lammps.libraries()[0].exists()
        return Check("lammps", str(lammps.PREFIX) if there else None, None, needed, not there, str(error))


def _disk() -> Check:
    free = shutil.disk_usage(Path.cwd()).free / 1e9
    return Check("free disk", f"{free:.1f} GB", None, f"{FREE_GB:g} GB", free >= FREE_GB, "free some space")


def main(as_json: bool = False) -> int:
    """Print the checks; return 0 if nothing required is missing or of another version."""
    from rich.console import Console
    from rich.table import Table

    made = checks()
    bad = [c for c in made if not c.ok]
    if as_json:
        print(json.dumps([asdict(c) for c in made], indent=1))
        return 1 if bad else 0
    table = Table("", "what", "version", "needed", "found", box=None, header_style="bold")
    for c in made:
        state = "ok" if c.ok else "WRONG" if c.found else "MISSING"
        table.add_row(state, c.name, c.version or "", c.needed, c.found or "", style=None if c.ok else "red")
    console = Console(highlight=False, width=max(Console().width, 120))  # paths are not shortened in a pipe
    console.print(table)
    for c in bad:
        console.print(c.sentence(), soft_wrap=True, markup=False)
    return 1 if bad else 0


if __name__ == "__main__":
    with border():
        sys.exit(main())
