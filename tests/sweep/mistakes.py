"""Calls that make each mistake of a sweep; see tests/mistakes.py."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pandas as pd
import pytest

from pywet import stages
from pywet.cases.screening import verdict
from pywet.cases.script import folder as script_folder
from pywet.cases.script.wet import Line
from pywet.config import dotted_keys
from pywet.engines import process
from pywet.sweep import (
    adaptive,
    bases,
    case_base,
    constraints,
    figures,
    gathering,
    plan,
    running,
    script_base,
    sweep_command,
    sweep_folder,
    table,
)
from pywet.sweep.plan import Plan
from pywet.util import files
from tests.cases.script import scripts
from tests.mistakes import Call, patched, written
from tests.sweep.files import BRIDGE, EXAMPLES, WALL, write

OF_SCRIPT = SimpleNamespace(base=SimpleNamespace(kind="script"))


def plotted(rows: int, *names: str) -> None:
    axes = {"a": SimpleNamespace(), "b": SimpleNamespace()}
    made = pd.DataFrame({"a": range(rows), "b": range(rows), "e": np.zeros(rows), "status": table.DONE})
    figures.drawn(SimpleNamespace(axes=axes), made, ["e"], *names)  # type: ignore[arg-type]


def asked(folder: Path, content: dict[str, Any], runs: bool = True) -> Plan:
    """A sweep, read with all its points."""
    read = plan.read(write(folder, content), folder / "out", folder / "store", trust=True)
    _ = read.runs if runs else None
    return read


def two_laws(folder: Path) -> dict[str, str]:
    given = files.read_json(EXAMPLES / "bridge.json")
    return {"bridge": str(written(folder, json.dumps({**given, "laws": ["willett", "rabinovich"]}), "bridge.json"))}


def measured(folder: Path, text: str) -> None:
    written(folder, text, "mine.py")
    read = asked(folder, {**WALL, "gather": ["e_n", "mine.py:depth"]}, runs=False)
    gathering._function(read, read.gather[1])[1]({})  # type: ignore[arg-type]


def killed() -> None:
    pool, asked_for = MagicMock(), SimpleNamespace(kind=SimpleNamespace(engine=True, ranks=1), store=None)
    pool.return_value.__exit__.return_value = False
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "ProcessPoolExecutor", pool)
        patch.setattr(running, "as_completed", MagicMock(side_effect=running.BrokenProcessPool))
        running.carry_out(asked_for, [None, None], cores=2)  # type: ignore[arg-type, list-item]


def script(folder: Path, status: int) -> None:
    """Run a script whose engine ends with this status, at a step that is no output."""
    kind, wet = SimpleNamespace(file=Path("in.script")), SimpleNamespace(model_dump=lambda **_: {})
    given = script_base.Given(Line("wet", Path("wet.yaml")), wet, files={}, folders=set())  # type: ignore[arg-type]

    def attend(_: object, work: Path, *__: object) -> tuple[int, None]:
        (work / process.OUTPUT).write_text("ERROR: Illegal fix command\n")
        return status, None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(process, "attend", attend)
        patch.setattr(script_folder, "ledger", lambda _: pd.DataFrame({"step": [1, 1001]}))
        patch.setattr(script_folder, "ended_at_step", lambda _: 1901)
        script_base.OfScript.run(kind, SimpleNamespace(given=given), folder, 1)  # type: ignore[arg-type]


def of_a_script(folder: Path, more: str) -> None:
    written(folder, "")
    (folder / "mine").mkdir()
    scripts.write(folder / "mine", line=f"{scripts.LINE}{more}")
    axes = {"liquid.percent": [1.0]}
    asked(folder, {**WALL, "base": {"script": "mine/in.script"}, "axes": axes, "gather": ["ruptures"]})


def case(folder: Path, same: bool) -> None:
    """Run a case that fails in its first stage, or, run before, in a check."""
    with pytest.MonkeyPatch.context() as patch:
        failed = None if same else stages.Status("scene", False, 0.0, "scene", "the bed does not fit")
        patch.setattr(stages, "carry_out", lambda *_, **__: failed)
        patch.setattr(verdict, "objections", lambda _: ["the ledger is open by 1e-3"])
        case_base.OfCase.run(SimpleNamespace(scale="smoke"), SimpleNamespace(given=(None, 2)), folder, 1)  # type: ignore[arg-type]


def mistakes() -> dict[str, Call]:
    """Code -> what raises it, in an empty folder."""
    return {
        "sweep.axis_in_value": lambda _: dotted_keys.filled({"a": 1}, {"a.b": 2}),
        "sweep.capillary_laws": lambda folder: asked(
            folder, {**BRIDGE, "axes": {"volume_m3": [1e-10]}, "base": two_laws(folder)}
        ),
        "sweep.constraint_long": lambda _: constraints.read("a" * 2000, ["a"]),
        "sweep.few_points": lambda folder: adaptive._next(
            asked(folder, WALL, False), pd.DataFrame(columns=["status", "point", "e_n", *WALL["axes"]]), 1
        ),
        "sweep.function_raises": lambda folder: measured(folder, "def depth(answer):\n    return 1 / 0\n"),
        "sweep.goal": lambda folder: asked(folder, {**BRIDGE, "goal": {"maximise": "e_n"}}),
        "sweep.killed": lambda _: killed(),
        "sweep.many_lines": lambda _: plotted(99, "e", "e", "a"),
        "sweep.map_axis": lambda _: figures.response_map(None, pd.DataFrame({"a": ["x"]}), "e", "a", "b"),  # type: ignore[arg-type]
        "sweep.map_points": lambda _: patched(
            figures.surface, "through", lambda *_: None,
            lambda: figures.response_map(None, pd.DataFrame({"a": [1], "b": [2]}), "e", "a", "b"),  # type: ignore[arg-type]
        ),
        "sweep.no_candidate": lambda _: adaptive.least_known(
            np.zeros((1, 1)), np.zeros(1), 1, {"a": adaptive.Axis(low=0.0, high=1.0)}, [constraints.read("a > 2", ["a"])]
        ),
        "sweep.no_column": lambda _: plotted(0, "c", "e"),
        "sweep.no_gather": lambda folder: plan._check_gather(
            SimpleNamespace(gather=(), file=folder / "s.yaml", sweep=OF_SCRIPT), False  # type: ignore[arg-type]
        ),
        "sweep.no_results": lambda _: plotted(0, "a", "e"),
        "sweep.no_table": lambda folder: table.read(folder),
        "sweep.not_keys": lambda folder: bases._json(written(folder, "[1]")),
        "sweep.none": lambda folder: sweep_command.plot(folder, ["a", "b"], None),
        "sweep.not_finite": lambda _: gathering._finite(float("nan"), "depth"),
        "sweep.folder_of_others": lambda folder: sweep_folder.claim(
            written(folder, "", table.NAME).parent, folder / "sweep.yaml"
        ),
        "sweep.objections": lambda folder: case(folder, True),
        "sweep.script_ended": lambda folder: script(folder, 1),
        "sweep.script_file": lambda folder: of_a_script(folder, "\nread_data ../file"),
        "sweep.script_liquid": lambda folder: script(folder, 0),
        "sweep.script_ranks": lambda folder: script_base.OfScript.run(
            SimpleNamespace(file=Path("in.script")), None, folder, 2  # type: ignore[arg-type]
        ),
        "sweep.script_shared": lambda folder: of_a_script(folder, " log ../wet"),
        "sweep.stage_failed": lambda folder: case(folder, False),
    }  # fmt: skip
