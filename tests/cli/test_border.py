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
from pywet.engines import process
from pywet.errors import FAULT, PywetError, border
from pywet.laws import custom_laws, registry
from reference_impl import faults
from tests.error_codes import raises_code
from tests.reliability.test_bad_calls import in_process


def one_of_a_kind(message: str) -> Path:
    """The file that the only line names; it holds the traceback."""
    assert len(message.strip().splitlines()) == 1, message
    file = Path(re.search(r"the traceback is in (\S+):", message)[1])
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


PROGRAMS = [
    (["pywet.engines.liggghts.worker"], "expected RUN_DIR ENGINE_FOLDER STEP RANKS"),
    (["pywet.engines.lammps.worker", "."], "expected RUN_DIR ENGINE_FOLDER"),
    (["pywet.report.render", ".", "p.png", "ten"], "STEP is ten; expected a whole number"),
    (["pywet.report.movie", ".", "."], "expected RUN_DIR OUT FRAMES"),
    (["pywet.report.closeup", ".", "p.png", "0", ""], "SPHERE is empty; expected a whole number"),
    (["reference_impl.spheres.spheres"], "expected FILE.json"),
    (["reference_impl.shown.report", "one"], "expected REPORT CASES.csv"),
]


@pytest.mark.parametrize(("words", "says"), PROGRAMS, ids=lambda p: p[0] if isinstance(p, list) else "")
def test_programs_beside_the_command_say_what_they_need(
    words: list[str], says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(process, "die_with_parent", lambda: None)  # would apply to the test's own process
    code, message = in_process(words[0], words[1:])
    assert code == 1 and len(message.splitlines()) == 1 and says in message, message


def test_a_fault_of_a_program_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["render.py", "run", "p.png", "1"])
    with pytest.raises(SystemExit) as ended, border():
        raise IndexError("list index out of range")
    assert ended.value.code == FAULT
    message = capsys.readouterr().err
    assert message.startswith("render.py run p.png 1: a fault in pywet, not in what was given (IndexError: list index")
    one_of_a_kind(message)


def test_a_word_without_end_is_shown_by_its_ends(capsys: pytest.CaptureFixture[str]) -> None:
    """Expect the expected values in the message, however long the given value is."""
    with pytest.raises(SystemExit), border():
        raise PywetError(f"there is no engine {'a' * 4000}z; expected liggghts or lammps")
    assert capsys.readouterr().err == f"there is no engine {'a' * 80}…{'a' * 78}z; expected liggghts or lammps\n"


def test_links_in_a_circle_are_no_fault(tmp_path: Path) -> None:
    """Expect a message for a law's file that is a link to itself."""
    (tmp_path / "law.py").symlink_to("law.py")
    custom_laws.trust([f"{tmp_path}/law.py:force"], tmp_path)
    with raises_code("law.no_file"):
        registry.get("capillary", f"{tmp_path}/law.py:force")


def test_every_program_of_the_package_has_the_border() -> None:
    """`if __name__ == "__main__"` of a module without it would print a traceback."""
    root = Path(__file__).parents[2]
    programs = [p for package in ("pywet", "studies", "reference_impl") for p in (root / package).rglob("*.py")]
    programs = [p for p in programs if '__name__ == "__main__"' in p.read_text()]
    bare = [str(p.relative_to(root)) for p in programs if "border(" not in p.read_text()]
    assert bare == ["pywet/laws/trial.py"]  # its parent process reports how it ended
    assert len(programs) >= 18


def test_the_reference_ends_the_same_way(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended, faults.border(2):
        _ = 1 // 0
    assert ended.value.code == faults.STATUS
    message = capsys.readouterr().err
    assert "a fault in the reference, not in what was given (ZeroDivisionError: " in message
    one_of_a_kind(message)


def test_a_terminal_without_utf_8_gets_escapes() -> None:
    """`pywet laws` has Greek letters."""
    command = [sys.executable, "-m", "pywet.cli.app", "laws"]
    ended = subprocess.run(
        command, capture_output=True, env=os.environ | {"PYTHONIOENCODING": "ascii"}, check=False, text=True
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "\\x" in ended.stdout or "\\u" in ended.stdout
