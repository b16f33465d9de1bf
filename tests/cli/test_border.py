"""How a command ends in an exception that is none of ours: one sentence, the traceback in a file, an exit code of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.errors import FAULT
from pywet.laws import registry
from reference_impl import faults


def one_of_a_kind(said: str) -> Path:
    """The file that the only line names; it holds the traceback."""
    assert len(said.strip().splitlines()) == 1, said
    file = Path(re.search(r"the traceback is in (\S+):", said)[1])
    text = file.read_text()
    file.unlink()
    assert "Traceback (most recent call last)" in text
    assert file.name.encode().isascii()
    return file


def test_a_fault_is_one_sentence_that_names_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(kind: str) -> list[str]:
        return [kind][1:2] or [str(1 // 0)]

    monkeypatch.setattr(registry, "names", broken)
    result = CliRunner().invoke(app, ["laws", "--json"])
    assert result.exit_code == FAULT == 70
    assert result.stderr.startswith("pywet laws --json: a fault in pywet, not in what was given (ZeroDivisionError: ")
    one_of_a_kind(result.stderr)


def test_memory_that_ran_out_is_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    def greedy(kind: str) -> list[str]:
        raise MemoryError(f"Unable to allocate 4 EiB for {kind}")

    monkeypatch.setattr(registry, "names", greedy)
    result = CliRunner().invoke(app, ["laws"])
    assert result.exit_code == 1
    assert "pywet laws: this needs more memory than there is (Unable to allocate 4 EiB" in result.stderr


@pytest.mark.parametrize("module", ["pywet.engines.liggghts.worker", "pywet.report.render"])
def test_programs_beside_the_command_end_the_same_way(module: str) -> None:
    """Called without what they need."""
    ended = subprocess.run([sys.executable, "-m", module], capture_output=True, text=True, check=False)
    assert ended.returncode == FAULT, ended.stderr
    assert "a fault in pywet" in ended.stderr
    one_of_a_kind(ended.stderr)


def test_every_program_of_the_package_has_the_border() -> None:
    """`if __name__ == "__main__"` of a module without it would print a traceback."""
    root = Path(__file__).parents[2]
    programs = [p for room in ("pywet", "reference_impl") for p in (root / room).rglob("*.py")]
    programs = [p for p in programs if '__name__ == "__main__"' in p.read_text()]
    bare = [str(p.relative_to(root)) for p in programs if "border(" not in p.read_text()]
    assert bare == ["pywet/laws/trial.py"]  # whose end, whatever it is, its parent puts into words
    assert len(programs) >= 18


def test_the_reference_ends_the_same_way(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended, faults.border(2):
        _ = 1 // 0
    assert ended.value.code == faults.STATUS
    said = capsys.readouterr().err
    assert "a fault in the reference, not in what was given (ZeroDivisionError: " in said
    one_of_a_kind(said)


def test_a_terminal_without_utf_8_gets_escapes() -> None:
    """`pywet laws` has Greek letters."""
    command = [sys.executable, "-m", "pywet.cli.app", "laws"]
    ended = subprocess.run(
        command, capture_output=True, env=os.environ | {"PYTHONIOENCODING": "ascii"}, check=False, text=True
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "\\x" in ended.stdout or "\\u" in ended.stdout
