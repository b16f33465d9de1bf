"""Reading and writing of files: what is damaged is found and said, what was there stays."""

from __future__ import annotations

import errno
import re
from pathlib import Path

import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.errors import PywetError, one_line, shown
from pywet.util.files import atomic_write, make_folder, parse_json, read_table, write_table
from tests.cases.screening import synthetic
from tests.error_codes import raises_code


def test_no_flipped_bit_of_a_table_changes_a_value_unnoticed(tmp_path: Path) -> None:
    """Every 211th bit of a trajectory's file, one at a time: refused, or the table as it was (names of tools in its foot)."""
    path = synthetic.make(tmp_path / "run") / "trajectory.parquet"
    good, data = read_table(path), path.read_bytes()
    refused = 0
    for at in range(0, 8 * len(data), 211):
        path.write_bytes(data[: at // 8] + bytes([data[at // 8] ^ (1 << at % 8)]) + data[at // 8 + 1 :])
        try:
            pd.testing.assert_frame_equal(read_table(path), good)
        except PywetError as error:
            assert "trajectory.parquet" in str(error) and "run it again" in str(error)
            refused += 1
    assert refused > 50  # the pages alone are a third of the file


def test_what_is_written_is_whole_or_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "table.parquet"
    write_table(pd.DataFrame({"a": [1.0]}), path)
    with raises_code("file.unwritten", path=path), atomic_write(path) as temporary:
        temporary.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")
    assert read_table(path)["a"].tolist() == [1.0]
    assert [p.name for p in tmp_path.iterdir()] == ["table.parquet"]


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (OSError(errno.ENOSPC, "No space left on device", "history/films.parquet"), "films.parquet: No space left"),
        (PermissionError(errno.EACCES, "Permission denied", "vtk.partial"), "vtk.partial: Permission denied"),
        (OSError(errno.EROFS, "Read-only file system"), "a file: Read-only file system"),
    ],
)
def test_what_the_system_refuses_is_one_sentence(
    error: OSError, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk, a folder of somebody else's, a file system that cannot be written: exit code 1, no traceback."""
    from pywet.report import vtk

    def refuse(folder: Path, **how: object) -> None:
        raise error

    monkeypatch.setattr(vtk, "write", refuse)
    result = CliRunner().invoke(app, ["view", str(synthetic.make(tmp_path / "run"))])
    assert result.exit_code == 1 and words in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_a_fault_of_the_program_is_not_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from pywet.report import vtk

    def wrong(folder: Path, **how: object) -> None:
        raise KeyError("step")

    monkeypatch.setattr(vtk, "write", wrong)
    result = CliRunner().invoke(app, ["view", str(synthetic.make(tmp_path / "run"))])
    assert (
        result.exit_code == 70 and "step" in Path(re.findall(r"\S+pywet-fault\S+\.txt", result.stderr)[0]).read_text()
    )


def test_a_folder_is_made_before_the_work(tmp_path: Path) -> None:
    make_folder(tmp_path / "a" / "b")
    assert list((tmp_path / "a" / "b").iterdir()) == []
    (tmp_path / "file").touch()
    with raises_code("file.unwritten"):
        make_folder(tmp_path / "file")


def test_messages_hold_one_printable_line() -> None:
    assert one_line("a\nb\x1b[31m\ud800") == "a b\\x1b[31m\\ud800"
    assert shown(Path("a\nb")) == "a\\nb" and len(shown(Path("n" * 3000))) == 161


def test_a_byte_order_mark_is_no_fault() -> None:
    assert parse_json(b'\xef\xbb\xbf{"a": 1}', "x", "fix it") == {"a": 1}
