"""Builds the plugin (a shared library against libliggghts-dev) and caches it by a hash of sources and versions.

Not here: loading it into an engine (worker.py) or what it computes (plugin/).
"""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from pywet import caches
from pywet.errors import PywetError

ENGINE_VERSION = "3.8.0"
SOURCES = Path(__file__).parent / "plugin"
FLAGS = ["-std=c++17", "-O3", "-fPIC", "-shared", "-w", "-DOMPI_SKIP_MPICXX"]
LOOPS = ["-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"]
"""Liberties that loops need to become vector instructions, and none that changes a bit of a result."""
VISIBILITY = ["-fvisibility=hidden", "-fvisibility-inlines-hidden"]
INCLUDE = Path("/usr/include/liggghts")
ANSWER_S = 30.0
"""Longest that a program may take to say its version [s]."""
MEND = "run it in a terminal to see why, or reinstall its package"


def said(command: list[str], given: str = "", folder: Path | None = None) -> str:
    """What a program that has no work to do prints; `PywetError` where it does not start or does not end in time.

    It has a process group of its own, so that all it started ends with it.
    """
    try:
        child = subprocess.Popen(
            command,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
            start_new_session=True,
        )
    except OSError as error:
        raise PywetError(f"{command[0]} does not start ({error.strerror}); expected its version: {MEND}") from error
    try:
        return child.communicate(given, timeout=ANSWER_S)[0]
    except subprocess.TimeoutExpired as error:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
        raise PywetError(
            f"{command[0]} did not answer within {ANSWER_S:g} s; expected its version at once: {MEND}"
        ) from error


def package_version(package: str) -> str | None:
    """Installed version of a Debian package, None where it is not installed."""
    if shutil.which("dpkg-query") is None:
        return None
    status, _, version = said(["dpkg-query", "-W", "-f=${Status}|${Version}", package]).partition("|")
    return version if status.endswith("installed") and "not-installed" not in status else None


def engine_version() -> str:
    """Version of the installed engine library, checked against the one this plugin is written for."""
    version = package_version("libliggghts-dev")
    if version is None:
        raise PywetError(
            "the LIGGGHTS headers were not found; expected Debian's package libliggghts-dev: run `make setup`"
        )
    if not version.startswith(ENGINE_VERSION):
        raise PywetError(
            f"LIGGGHTS {version} is installed, the plugin is written for {ENGINE_VERSION}; "
            f"install libliggghts-dev {ENGINE_VERSION} (Debian 12)"
        )
    return version


def source_hash() -> str:
    """Hash over the sources, the flags and the versions of engine and compiler: the name of the cached library."""
    digest = hashlib.sha256()
    for path in sorted(SOURCES.glob("*")):
        digest.update(path.name.encode() + path.read_bytes())
    for text in (
        *FLAGS,
        *LOOPS,
        *VISIBILITY,
        engine_version(),
        package_version("libopenmpi-dev") or "",
        compiler_version(),
    ):
        digest.update(text.encode())
    return digest.hexdigest()[:16]


def compiler_version() -> str:
    """First line of `g++ --version`."""
    if shutil.which("g++") is None or shutil.which("mpicxx") is None:
        raise PywetError(
            "no C++ compiler for the plugin was found; expected g++ and mpicxx (libopenmpi-dev): run `make setup`"
        )
    return said(["g++", "--version"]).partition("\n")[0]


def kept() -> Path:
    """Where the plugin of these sources is kept once it is built."""
    return caches.folder() / f"libpywet-{source_hash()}.so"


def plugin_path() -> Path:
    """The plugin, built where it is not yet whole in the cache (about five seconds)."""
    target = kept()
    if not caches.whole(target):
        _compile(target)
    return target


def _compile(target: Path) -> None:
    mpi = [said(["mpicxx", f"--showme:{what}"]).split() for what in ("compile", "link")]
    with tempfile.TemporaryDirectory(dir=target.parent) as folder:
        built = Path(folder) / target.name
        command = ["g++", *FLAGS, *LOOPS, *VISIBILITY, f'-DPYWET_ENGINE_VERSION="{engine_version()}"', f"-I{SOURCES}"]
        command += [f"-I{INCLUDE}", *mpi[0], *map(str, sorted(SOURCES.glob("*.cpp"))), "-o", str(built)]
        command += ["-l:libliggghts.so.3", *mpi[1]]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            first = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip()[:300])
            raise PywetError(f"the plugin does not compile: {first}; expected headers of LIGGGHTS {ENGINE_VERSION}")
        built.rename(target)
        caches.seal(target)


def main() -> int:
    """Build and say where; used by `make setup`."""
    try:
        print(f"plugin: {plugin_path()}")
    except PywetError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
