"""Static analysis of the C++ sources, with the exceptions of tools/cppcheck.txt and .clang-tidy; injected faults are found."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
pytestmark = pytest.mark.slow
CPPCHECK, TIDY = (
    pytest.mark.skipif(shutil.which(name) is None, reason=f"apt-get install {name}")
    for name in ("cppcheck", "clang-tidy")
)


@TIDY
def test_no_finding_of_clang_tidy() -> None:
    done = subprocess.run([ROOT / "tools" / "clang-tidy"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@TIDY
def test_an_injected_fault_is_found_by_clang_tidy(tmp_path: Path) -> None:
    (tmp_path / "wrong.cpp").write_text("int f(int *p) { if (!p) return *p; return 0; }\n")
    given = [ROOT / "tools" / "clang-tidy", tmp_path / "wrong.cpp"]
    done = subprocess.run(given, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "clang-analyzer-core.NullDereference" in done.stdout


@CPPCHECK
def test_no_finding() -> None:
    done = subprocess.run([ROOT / "tools" / "cppcheck"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@CPPCHECK
def test_an_injected_fault_is_found(tmp_path: Path) -> None:
    """A read of a member that no constructor sets ends with exit code 1."""
    (tmp_path / "wrong.cpp").write_text("struct A { int a; A() {} };\nint f() { int x; return x; }\n")
    done = subprocess.run([ROOT / "tools" / "cppcheck", tmp_path], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "uninitvar" in done.stderr and "uninitMemberVar" in done.stderr
