"""The plugin built with address and undefined-behaviour sanitizers runs the small moist scenes: neither says anything."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pywet import machine_code
from pywet.engines import process
from pywet.engines.liggghts import build

pytestmark = [pytest.mark.slow, pytest.mark.engine]
SCENES = {
    "pull": (),
    "collision": (),
    "bed": ("--spheres", "30", "--seconds", "0.1"),
    "drum": ("--spheres", "30", "--seconds", "0.1"),
}
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-fno-omit-frame-pointer", "-g"]


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """A cache that holds the plugin with sanitizers under the name of the plain one; the laws' machine code stays where it is."""
    cache = tmp_path_factory.mktemp("cache", numbered=True)
    cache.chmod(0o700)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYWET_CACHE", str(cache))
        target = build.kept()
        patch.setattr(build, "FLAGS", [*build.FLAGS, *SANITIZED])
        build._compile(target)
    libraries = [process.said(["g++", f"-print-file-name={name}"]).strip() for name in ("libasan.so", "libubsan.so")]
    code = Path(machine_code.numba.config.CACHE_DIR)
    return {
        **os.environ,
        "PYWET_CACHE": str(cache),
        "NUMBA_CACHE_DIR": str(code.parent),
        "LD_PRELOAD": " ".join(libraries),
        "ASAN_OPTIONS": "detect_leaks=0",  # Python and MPI keep what they have until the end
        "UBSAN_OPTIONS": "print_stacktrace=1",
    }


@pytest.mark.parametrize("scene", SCENES)
def test_sanitizers_are_silent(environment: dict[str, str], tmp_path: Path, scene: str) -> None:
    """A fault would end the engine's process, with its report in the log that the sentence names."""
    command = [sys.executable, "-m", "pywet.cli.app", "scene", scene, *SCENES[scene], "--out", str(tmp_path / "run")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    log = tmp_path / "run" / "engine.partial" / "output.log"
    assert done.returncode == 0, f"{done.stderr}\n{log.read_text()[-6000:] if log.exists() else ''}"
    said = (tmp_path / "run" / "engine" / "output.log").read_text()
    assert "runtime error" not in said and "AddressSanitizer" not in said
