"""The plugin under GCC's address and undefined-behaviour sanitizers: small moist scenes end as they do without, and none speaks.

Leaks are not looked for (the engine and Python keep memory to their end), nor is the engine itself instrumented.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

FLAGS = "-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -O1 -g"
SPEAKS = ("AddressSanitizer", "runtime error")


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """In which the instrumented plugin is built once for all scenes, and without the sanitizer in the compiler itself."""
    library = subprocess.run(
        ["g++", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True
    ).stdout.strip()
    if not Path(library).is_file():
        pytest.skip("this compiler has no address sanitizer")
    given = {**os.environ, "PYWET_CXXFLAGS": FLAGS, "XDG_CACHE_HOME": str(tmp_path_factory.mktemp("cache"))}
    subprocess.run([sys.executable, "-m", "pywet.engines.liggghts.build"], env=given, check=True)
    return {**given, "LD_PRELOAD": library, "ASAN_OPTIONS": "detect_leaks=0"}


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    "words", ["pull", "collision", "bed --spheres 200 --seconds 0.05", "drum --spheres 200 --seconds 0.05"]
)
def test_small_moist_scenes(environment: dict[str, str], tmp_path: Path, words: str) -> None:
    command = [sys.executable, "-m", "pywet.cli.app", "scene", *words.split(), "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    output_text = done.stdout + done.stderr
    output_text += "".join(path.read_text(errors="replace") for path in tmp_path.rglob("*.log") if path.is_file())
    assert done.returncode == 0, output_text[-3000:]
    assert not any(word in output_text for word in SPEAKS), output_text[-3000:]
    built = list(Path(environment["XDG_CACHE_HOME"]).rglob("libpywet-*.so"))
    symbols = subprocess.run(["nm", "-D", str(built[0])], capture_output=True, text=True, check=True).stdout
    assert "__asan_" in symbols and "__ubsan_" in symbols
