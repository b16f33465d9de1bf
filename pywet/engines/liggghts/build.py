"""Build the plugin (a shared library against libliggghts-dev) and cache it by a hash of sources and versions.

Not here: loading it into an engine (worker.py) or what it computes (plugin/).
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from pywet.engines import process
from pywet.errors import EngineError, border
from pywet.util import caches

ENGINE_VERSION = "3.8.0"
SOURCES = Path(__file__).parent / "plugin"
FLAGS = ["-std=c++17", "-O3", "-fPIC", "-shared", "-w", "-DOMPI_SKIP_MPICXX"]
LOOPS = ["-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
"""Compiler options that vectorised loops require and that change no bit of a result."""
EXTRA = shlex.split(os.environ.get("PYWET_CXXFLAGS", ""))
"""Additional compiler options, such as those of a sanitizer; a plugin built with them is cached separately."""
VISIBILITY = ["-fvisibility=hidden", "-fvisibility-inlines-hidden"]
INCLUDE = Path("/usr/include/liggghts")


def engine_version() -> str:
    """Return the version of the installed engine library, checked against the supported one."""
    version = process.package_version("libliggghts-dev")
    if version is None:
        raise EngineError(
            "the LIGGGHTS headers were not found; expected Debian's package libliggghts-dev: run `make setup`",
            code="liggghts.headers",
        )
    if not version.startswith(ENGINE_VERSION):
        raise EngineError(
            f"LIGGGHTS {version} is installed, the plugin is written for {ENGINE_VERSION}; "
            f"install libliggghts-dev {ENGINE_VERSION} (Debian 12)",
            code="liggghts.version", given=version, expected=ENGINE_VERSION,
        )  # fmt: skip
    return version


def source_hash() -> str:
    """Hash the sources, the flags and the versions of engine and compiler: the name of the cached library."""
    return hash_of(sorted(SOURCES.glob("*")), engine_version(), process.package_version("libopenmpi-dev") or "")


def hash_of(sources: list[Path], *versions: str) -> str:
    """Hash source files and versions, with flags and compiler."""
    digest = hashlib.sha256()
    for path in sources:
        digest.update(path.name.encode() + path.read_bytes())
    for text in (*FLAGS, *LOOPS, *EXTRA, *VISIBILITY, *versions, compiler_version()):
        digest.update(text.encode())
    return digest.hexdigest()[:16]


def compiler_version() -> str:
    """Return the first line of `g++ --version`."""
    if shutil.which("g++") is None or shutil.which("mpicxx") is None:
        raise EngineError(
            "no C++ compiler for the plugin was found; expected g++ and mpicxx (libopenmpi-dev): run `make setup`",
            code="plugin.compiler",
        )
    return process.output_of(["g++", "--version"]).partition("\n")[0]


def cached() -> Path:
    """Return the path at which the plugin of these sources is stored once it is built."""
    return caches.folder() / f"libpywet-{source_hash()}.so"


def plugin_path() -> Path:
    """Return the path of the plugin, built if it is not in the cache (about five seconds)."""
    target = cached()
    if not caches.whole(target):
        _compile(target)
    return target


def _compile(target: Path) -> None:
    mpi = [process.output_of(["mpicxx", f"--showme:{what}"]).split() for what in ("compile", "link")]
    before = [f'-DPYWET_ENGINE_VERSION="{engine_version()}"', f"-I{SOURCES}", f"-I{INCLUDE}", *mpi[0]]
    after = ["-l:libliggghts.so.3", *mpi[1]]
    compile_to(target, before, sorted(SOURCES.glob("*.cpp")), after, f"LIGGGHTS {ENGINE_VERSION}")


def compile_to(target: Path, before: list[str], sources: list[Path], after: list[str], of: str) -> None:
    """Compile sources into a sealed library of the cache; compiler arguments before and after them, `of` an engine's headers."""
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        built = Path(folder) / target.name
        command = ["g++", *FLAGS, *LOOPS, *EXTRA, *VISIBILITY, *before, *map(str, sources), "-o", str(built), *after]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            first = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip()[:300])
            raise EngineError(
                f"the plugin does not compile: {first}; expected headers of {of}",
                code="plugin.not_compiled", expected=of,
            )  # fmt: skip
        built.rename(target)
        caches.seal(target)


def main() -> None:
    """Build the plugin and print its path; used by `make setup`."""
    print(f"plugin: {plugin_path()}")


if __name__ == "__main__":
    with border():
        main()
