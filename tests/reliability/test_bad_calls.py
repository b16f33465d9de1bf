"""Generated calls that cannot be right end in one sentence, a non-zero exit code, in time; the working folder stays as it is.

Every command of `pywet`, the programs `python -m …` and benchmarks/wet/score.py; every kind of file that they read.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import shutil
import sys
import warnings
from collections import Counter
from pathlib import Path
from typing import Annotated, get_args, get_origin, get_type_hints

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import given as generated
from typer.testing import CliRunner

from pywet import shipped
from pywet.cli.app import app
from pywet.cli.groups import GROUPS
from pywet.engines import process
from pywet.report import app as viewer
from tests.cases.screening import synthetic
from tests.reliability import bad_calls
from tests.reliability.test_bad_inputs import NEVER
from tests.reliability.test_fuzzed_files import limited

ROOT = Path(__file__).parents[2]
FEW, MANY = 60, 400
LIMIT_S = 300
HINTS = re.compile(
    r"expected|fix|Usage|usage:|run the case|make it again|see |is missing|no scene\.json|is not|cannot|could not|No such",
    re.IGNORECASE,
)


def in_process(program: str, words: list[str]) -> tuple[int, str]:
    """Exit status and all that is said by a program in this process."""
    output_text, before = io.StringIO(), sys.argv
    sys.argv = [program, *words]
    try:
        with (
            contextlib.redirect_stderr(output_text),
            contextlib.redirect_stdout(output_text),
            warnings.catch_warnings(),
        ):
            warnings.simplefilter("ignore")  # a module that is already imported is executed again
            (runpy.run_path if program.endswith(".py") else runpy.run_module)(program, run_name="__main__")
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        sys.argv = before
    return code, output_text.getvalue()


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.slow)])
def test_a_call_that_cannot_be_right_is_refused_in_a_sentence(
    count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = synthetic.make(tmp_path / "made" / "case02")
    work, ends, programs = tmp_path / "work", Counter[int](), Counter[str]()
    shipped.begin(work)
    (work / "results" / "smoke" / "case05").mkdir(parents=True)
    (work / "results" / "smoke" / "case05" / "trajectory.parquet").write_text("days of work")
    before = content(work)
    monkeypatch.chdir(work)
    monkeypatch.setattr(process, "die_with_parent", lambda: None)  # would apply to the test's own process

    def served(*_: object) -> None:
        raise AssertionError("a server was started")

    monkeypatch.setattr(viewer, "Server", served)

    def tried(call: bad_calls.Call) -> None:
        here, config, run = (tmp_path / name for name in ("here", "config", "run"))
        for folder in (here, config, run):
            shutil.rmtree(folder, ignore_errors=True)
        here.mkdir()
        shutil.copytree(ROOT / "config", config)
        shutil.copytree(made, run)
        for name, text in bad_calls.OTHER_FILES.items():
            (here / name).write_text(text.replace("HERE", str(here)))
        folder = run if call.name == "scene.json" else config if "{config}" in call.words else here
        (folder / call.name).unlink(missing_ok=True) if call.name else None
        bad_calls.write(folder / call.name, call.content)
        words = list(bad_calls.given(call, here=here, config=config, run=run, made=made, file=here / call.name))
        with limited(LIMIT_S):
            if call.program:
                path = str(ROOT / call.program) if call.program.endswith(".py") else call.program
                code, output_text = in_process(path, words)
            else:
                result = CliRunner(env={"COLUMNS": "400", "NO_COLOR": "1"}).invoke(app, words)
                code, output_text = result.exit_code, result.stderr + result.stdout
                assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
        os.chdir(work)
        assert code in (1, 2) and not any(never in output_text for never in NEVER), (code, output_text[-2000:])
        assert len(output_text.strip()) > 20 and HINTS.search(output_text), output_text
        assert {name: content(work).get(name) for name in before} == before
        ends[code] += 1
        programs[call.program or f"pywet {call.words[0]}"] += 1

    quiet = settings(
        max_examples=count, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck)
    )
    quiet(generated(bad_calls.CALLS)(tried))()
    print(
        f"{sum(ends.values())} calls that cannot be right, {ends[1]} with exit code 1, {ends[2]} with 2:",
        dict(programs),
    )
    assert sum(ends.values()) >= count * 0.75  # hypothesis repeats no example


def test_every_command_is_among_them() -> None:
    assert bad_calls.commands() == {name for members in GROUPS.values() for name in members}


def test_every_number_of_a_command_has_a_range() -> None:
    """Else -1, nan and inf are taken for one."""
    bare = set()
    for command in (
        c for group in (app, *(g.typer_instance for g in app.registered_groups)) for c in group.registered_commands
    ):
        for name, kind in get_type_hints(command.callback, include_extras=True).items():
            plain = (
                {int, float} & {*get_args(get_args(kind)[0]), get_args(kind)[0]}
                if get_origin(kind) is Annotated
                else ()
            )
            if plain and kind.__metadata__[0].parser is None:
                bare.add(f"{command.callback.__name__} {name}")
    assert bare == {"score within"}  # its range is checked in benchmarks/wet/score.py
