"""Bad inputs, as data: each row of rows/*.yaml names a command, its exit code and the words that its sentence must hold.

A row:  name: what is wrong
        run: [plan, "2"]                      arguments of `pywet`; {here} is an empty folder, {config} a copy of config/,
                                              {run} a made run directory (where `made` asks for one)
        config: {materials.yaml: [old, new]}  optional: one replacement in a file of the copy (must be found)
        write: {query.json: text}             optional: files in {here}; `hex: …` for bytes, `repeat: [text, n]` for long ones
                                              (or `repeat: [[text, n], …]`)
        made: moist                           optional: moist or dry, a synthetic finished run in {run}; {comparison} is another
        damage: {scene.json: cut}             optional, in {run}: cut (half), empty, gone, folder, {write: …} as above, or of a
                                              table: {without: column}, {only: rows}, {set: {column: value}}
        exit: 1
        says: [words]                         all must be in standard error or output, of a rule without a code; or
        error: {code: config.value, key: ranks}   attributes of the error (its file is the one that `config` changes); where: name
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from pywet import stages
from pywet.cli.app import app
from pywet.errors import PywetError
from tests.cases.screening import synthetic

ROOT = Path(__file__).parents[2]
NEVER = ("Traceback", "a fault in pywet", "a fault in the reference", "fault in the program")
ROWS = [
    pytest.param(row, id=f"{file.stem}: {row['name']}")
    for file in sorted((Path(__file__).parent / "rows").glob("*.yaml"))
    for row in yaml.safe_load(file.read_text())
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("made")
    found = {
        "moist": synthetic.make(folder / "case02", moist=True),
        "dry": synthetic.make(folder / "case01", moist=False),
    }
    for run in found.values():
        stages.results(run)
    return found


def content(value: Any) -> bytes:
    if isinstance(value, dict) and "hex" in value:
        return bytes.fromhex(value["hex"])
    if isinstance(value, dict) and "repeat" in value:
        given = value["repeat"]
        return "".join(text * times for text, times in (given if isinstance(given[0], list) else [given])).encode()
    return str(value).encode()


def damage(path: Path, how: Any) -> None:
    if how == "cut":
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2])
    elif how == "empty":
        path.write_bytes(b"")
    elif how in ("gone", "folder"):
        path.unlink()
        if how == "folder":
            path.mkdir()
    elif "write" in how:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content(how["write"]))
    else:
        table = pd.read_parquet(path).iloc[: how.get("only")].drop(columns=how.get("without", []))
        table.assign(**how.get("set", {})).to_parquet(path)


@pytest.mark.parametrize("row", ROWS)
def test_a_bad_input_ends_in_one_sentence(row: dict[str, Any], tmp_path: Path, made: dict[str, Path]) -> None:
    """Exit code and words as the row says; a line for each mistake of a file, no traceback, no word of a fault of pywet's."""
    here, config, run = tmp_path / "here", tmp_path / "config", tmp_path / "run"
    here.mkdir()
    shutil.copytree(ROOT / "config", config)
    for name, (old, new) in row.get("config", {}).items():
        text = (config / name).read_text()
        assert old in text, f"{name} no longer holds {old!r}"
        (config / name).write_text(text.replace(old, new, 1))
    for name, value in row.get("write", {}).items():
        (here / name).write_bytes(content(value))
    if "made" in row:
        shutil.copytree(made[row["made"]], run)
    for name, how in row.get("damage", {}).items():
        damage(run / name, how)
    comparison = made.get(row.get("made", ""))
    arguments = [str(a).format(here=here, config=config, run=run, comparison=comparison) for a in row["run"]]
    result = CliRunner(env={"COLUMNS": "400", "NO_COLOR": "1"}).invoke(app, arguments)
    output_text = result.stderr + result.stdout
    assert result.exit_code == row["exit"], output_text
    assert not any(words in output_text for words in NEVER), output_text
    for words in row.get("says", ()):
        assert words in re.sub(r"\s+", " ", output_text), output_text
    if "error" in row:
        error = result.exception.__context__ if result.exception else None
        assert isinstance(error, PywetError), output_text
        where = Path(error.where).name.partition(" line ")[0]
        assert {n: where if n == "where" else getattr(error, n) for n in row["error"]} == row["error"], output_text
        if "config" in row and error.code.startswith("config."):
            assert where in (*row["config"], "config.yaml", "cases.csv", "")
        assert str(error).splitlines()[0] in output_text
    if row["exit"] == 1:
        lines = [  # without `make setup` a notice is printed first
            line for line in result.stderr.strip().splitlines() if not line.startswith("compiling for this processor")
        ]
        # several messages about one file
        assert len({line.partition(": ")[0] for line in lines}) == len(lines[:1]), result.stderr


def test_the_table_is_as_long_as_promised() -> None:
    assert len(ROWS) >= 300
