"""Static analysis of the C++ sources: no finding but the exceptions of tools/cppcheck.txt, and a planted one is found."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("cppcheck") is None, reason="apt-get install cppcheck"),
]


def test_no_finding() -> None:
    done = subprocess.run([ROOT / "tools" / "cppcheck"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_an_injected_fault_is_found(tmp_path: Path) -> None:
    """A read of a member that no constructor sets ends with exit code 1."""
    (tmp_path / "wrong.cpp").write_text("struct A { int a; A() {} };\nint f() { int x; return x; }\n")
    done = subprocess.run([ROOT / "tools" / "cppcheck", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "uninitvar" in done.stderr and "uninitMemberVar" in done.stderr
