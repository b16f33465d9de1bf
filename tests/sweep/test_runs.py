"""Runs of a sweep: each point once in the store of all sweeps, killed or not; tried again where it failed; the table of all."""

from __future__ import annotations

import inspect
import json
import os
import re
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
import pytest
from pyarrow import parquet
from typer.testing import CliRunner

from pywet import run_folder
from pywet.cases.small import bridge_query
from pywet.cli.app import app
from pywet.collisions.wall import wall
from pywet.errors import PywetError
from pywet.sweep import bases, plan, run_numbers, running, script_base, sweep_command, table
from pywet.sweep.base_kind import Built, Kind
from pywet.sweep.costs import UNKNOWN, Cost
from pywet.sweep.description import Base
from pywet.sweep.plan import Plan, Run
from pywet.sweep.points import Numbered
from pywet.sweep.store import Store
from pywet.sweep.workflow_jobs import ALL, Jobs
from pywet.util import sources
from pywet.util.files import write_json
from tests.cases.script import scripts
from tests.error_codes import code_of, raises_code
from tests.sweep.files import BRIDGE, EXAMPLES, WALL, write

MANY = {
    **WALL,
    "axes": {"friction": {"linspace": [0.05, 0.4, 10]}, "normal_velocity_m_per_s": {"logspace": [0.5, 2.0, 20]}},
}
LAW = """from pywet.laws.force_law import force_law


@force_law("capillary")
def pull(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension):
    return {factor} * surface_tension * radius_i
"""
"""A capillary law in a file of a user."""


def asked(folder: Path, content: dict[str, Any], name: str = "sweep.yaml", trust: bool = False) -> Plan:
    """A sweep whose table is in a folder of its name, with the one store of the test."""
    return plan.read(write(folder, content, name), folder / Path(name).stem, folder / "store", trust)


def done(of: Plan, more: int = 0) -> pd.DataFrame:
    return sweep_command.carry_out(of, 1, 1, more, lambda line: None)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The collisions that are computed."""
    calls: list[Any] = []
    collide = wall.collide
    monkeypatch.setattr(wall, "collide", lambda problem: calls.append(problem) or collide(problem))
    return calls


def _killed(of: Plan, count: int) -> int:
    """Carry a sweep out in a process that is killed once so many points are in the store; how many are there then."""
    process = os.fork()
    if process == 0:
        try:
            done(of)
        finally:
            os._exit(0)
    end = time.monotonic() + 60.0
    while len(list(of.store.folder.glob("*/point.json"))) < count and time.monotonic() < end:
        time.sleep(0.001)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    return len(list(of.store.folder.glob("*/point.json")))


def test_two_hundred_points_killed_five_times_give_the_same_table(tmp_path: Path) -> None:
    """The very table of an unbroken sweep, and each kill left less than all points."""
    wall.collide(plan.read(write(tmp_path, MANY)).runs[0].built.given)  # compile before processes are forked
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    whole = done(asked(tmp_path / "one", MANY))
    broken = asked(tmp_path / "two", MANY)
    assert len(broken.runs) == 200
    left = [_killed(broken, count) for count in (10, 50, 90, 130, 170)]
    assert left == sorted(left) and left[0] >= 10 and left[-1] < 200, left
    pd.testing.assert_frame_equal(done(broken), whole, check_exact=True)
    one, two = (table.read(folder / "sweep") for folder in (tmp_path / "one", tmp_path / "two"))
    pd.testing.assert_frame_equal(one, two, check_exact=True)
    assert one["e_n"].between(0, 1).all() and one["e_n"].nunique() > 15


def test_a_point_is_run_once_in_all_sweeps_and_an_axis_can_be_extended(tmp_path: Path, counted: list[Any]) -> None:
    first = done(asked(tmp_path, WALL))
    assert len(counted) == 6
    longer = {**WALL, "axes": {**WALL["axes"], "friction": [0.1, 0.15, 0.2]}}
    second = done(asked(tmp_path, longer))
    assert len(counted) == 9  # three new ones
    same = second[second["friction"] != 0.15]
    assert same["e_n"].tolist() == first["e_n"].tolist()
    other = {**WALL, "name": "another", "axes": {"normal_velocity_m_per_s": [1.0, 3.0], "friction": [0.2]}}
    done(asked(tmp_path, other, "other.yaml"))
    assert len(counted) == 10  # the other of its two points is in the store


@pytest.mark.parametrize("cut_size", ["e_n", "screen_d50_mm"])
def test_what_limits_the_numbers_of_a_screen_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cut_size: str
) -> None:
    """A cut size that is not enclosed, if it is gathered, and a deck that is not steady: in the row, on the page, at the end.

    Here results of a collision take the places of those of a screen.
    """
    monkeypatch.setattr(table, "CUT_SIZE", cut_size)
    monkeypatch.setattr(table, "SCREEN", {"e_n": None})
    of = asked(tmp_path, WALL)
    assert set(done(of)["reason"]) == {""}
    there = {0: "above the largest size", 1: "above the largest size", 2: "within the sizes"}
    for k, where in there.items():
        screen = of.store.place(of.runs[k].built.name) / "results" / "screen.json"
        write_json(screen, {"d50_mm": None, "d50_position": where, "steady": k < 2, "from_s": 1.0, "to_s": 3.0})
    made = table.frame(of)
    outside, moving = "e_n: above the largest size", "screen not steady: means over the last 2 s of the feed"
    named = {outside: 2 * (cut_size == "e_n"), moving: 1}
    assert made["reason"].tolist() == [outside * (named[outside] > 0)] * 2 + [moving] + [""] * 3
    assert set(made["status"]) == {table.DONE}
    lines, text = sweep_command.finish(of, made), (of.folder / "report.html").read_text()
    for note, count in named.items():
        assert (f"{note} in {count} of 6 runs" in lines) == (count > 0) and text.count(note) == count


def test_a_failed_point_is_tried_again_and_stops_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    collide = wall.collide

    def refuse(problem: Any) -> Any:
        if problem.friction == 0.2:
            raise PywetError("no collision today")
        return collide(problem)

    monkeypatch.setattr(wall, "collide", refuse)
    made = done(asked(tmp_path, WALL))
    assert made["status"].tolist() == [table.DONE] * 3 + [table.FAILED] * 3
    assert set(made["reason"]) == {"", "no collision today"}
    sentence = sweep_command.failures(made)
    assert sentence is not None and sentence.startswith(
        "3 of 6 runs have no results, first point 4, seed 0: no collision today"
    )
    assert "3 of 6 runs have results" in (tmp_path / "sweep" / "report.html").read_text()
    monkeypatch.setattr(wall, "collide", collide)
    again = done(asked(tmp_path, WALL))
    assert sweep_command.failures(again) is None and again["e_n"].notna().all()


def test_a_damaged_point_is_run_again(tmp_path: Path, counted: list[Any]) -> None:
    of = asked(tmp_path, WALL)
    before = done(of)
    (of.store.place(of.runs[2].built.name) / "point.json").write_text('{"numbers": ')
    pd.testing.assert_frame_equal(done(asked(tmp_path, WALL)), before)
    assert len(counted) == 7


def test_a_changed_law_redoes_its_points_only(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(LAW.format(factor=2.0))
    axes = {"laws.0": ["willett", "mine.py:pull"], "surface_tension_N_per_m": [0.03, 0.07]}
    one_law = {**json.loads(Path(BRIDGE["base"]["bridge"]).read_text()), "laws": ["willett"]}
    (tmp_path / "bridge.json").write_text(json.dumps(one_law))
    content = {**BRIDGE, "base": {"bridge": "bridge.json"}, "axes": axes}
    first = asked(tmp_path, content)
    before = done(first)
    names = [run.built.name for run in first.runs]
    assert before["pull_off_force_N"].iloc[2] == pytest.approx(2.0 * 0.03 * 0.002)
    (tmp_path / "mine.py").write_text(LAW.format(factor=3.0))
    second = asked(tmp_path, content)
    assert [run.built.name == name for run, name in zip(second.runs, names, strict=True)] == [True, True, False, False]
    assert [run.point.number for run in second.missing] == [3, 4]


def test_the_name_of_a_point_depends_on_the_code_that_computes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each base without an engine names the package of the function that its runs call; a fingerprint of no file is constant.

    With an engine: the code that evaluates runs, and the module that gathers their numbers.
    """
    for kind, function in ((bases.Wall, wall.collide), (bases.Bridge, bridge_query.pull_off)):
        assert Path(inspect.getfile(function)) in sources.of([kind.code])
    scripts.write(tmp_path)
    based = {"case": {"case": 2, "config": str(EXAMPLES.parent / "config")}, "script": {"script": "in.script"},
             "scene": {"scene": str(EXAMPLES / "sweeps" / "small_drum_scene.yaml")}}  # fmt: skip
    whole, gathered = sources.digest_of_evaluation(), {"case": run_numbers, "scene": run_numbers, "script": script_base}
    for name, base in based.items():
        found, module = [], gathered[name]
        for digest, file in ((whole, module.__file__), ("other", module.__file__), (whole, __file__)):
            with monkeypatch.context() as patch:
                patch.setattr(sources, "digest_of_evaluation", lambda digest=digest: digest)
                patch.setattr(module, "__file__", file)
                found.append(bases.kind(Base(**base), tmp_path).built({}, 0).name)
        assert len({*found}) == len(found), name


@pytest.mark.parametrize(
    ("engine", "ranks", "seconds", "cores", "together", "says"),
    [
        (False, 4, [0.1] * 600, 16, 1, "1 min on 1 core,"),
        (True, 1, [3600.0], 16, 1, "60 min on 1 core,"),
        (True, 1, [60.0] * 24, 2, 2, "12 min on 2 cores,"),
        (True, 1, [60.0, 7200.0], 16, 2, "2 h on 2 cores,"),
        (True, 1, [3600.0] * 3, 2, 2, "2 h on 2 cores,"),
        (True, 1, [60.0] * 4 + [7200.0], 4, 4, "2 h on 4 cores,"),
        (True, 2, [3600.0, 1800.0, 5400.0], 4, 2, "60 min on 4 cores,"),
        (True, 4, [3600.0] * 4, 4, 1, "60 min on 4 cores,"),
        (True, 4, [3600.0] * 4, 9, 2, "30 min on 8 cores,"),
        (True, 4, [3600.0], 2, 1, "30 min on 2 cores,"),
    ],
)
def test_runs_at_a_time_and_their_predicted_time_agree(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, engine: bool, ranks: int, seconds: list[float], cores: int,
    together: int, says: str,
) -> None:  # fmt: skip
    """Without an engine one run; otherwise as many as there are, and as have cores for their ranks; the longest run counts."""
    of, pools = asked(tmp_path, WALL), list[int]()

    def pool(count: int, *_: Any) -> Any:
        pools.append(count)
        raise InterruptedError

    runs = of.runs[:1] * len(seconds)
    monkeypatch.setattr(bases.Wall, "engine", engine)
    monkeypatch.setattr(running, "ProcessPoolExecutor", pool)
    monkeypatch.setattr(running, "do", lambda *_: True)
    with suppress(InterruptedError):
        running.carry_out(of, runs, cores, ranks)
    assert (pools or [1]) == [together]
    assert says in plan.lines(of, [(run, Cost(s, 0.0)) for run, s in zip(runs, seconds, strict=True)], cores, ranks)[1]


def test_a_function_of_a_file_runs_below_the_sweep_or_with_trust_and_again_when_it_changes(tmp_path: Path) -> None:
    twice = "def twice(answer):\n    return 2.0 * answer['e_n']\n"
    (tmp_path / "mine.py").write_text(twice)
    made = done(asked(tmp_path, {**WALL, "gather": ["e_n", {"function": "mine.py:twice", "unit": "1"}]}))
    assert made["twice"].tolist() == [2.0 * e for e in made["e_n"]]
    (tmp_path / "inner").mkdir()
    content = {**WALL, "gather": ["e_n", {"function": "../other.py:twice", "unit": "1"}]}
    (tmp_path / "other.py").write_text(twice)
    with raises_code("sweep.untrusted"):
        asked(tmp_path / "inner", content)
    made = done(asked(tmp_path / "inner", content, trust=True))
    assert made["twice"].tolist() == [2.0 * e for e in made["e_n"]]
    (tmp_path / "other.py").write_text("def twice(answer):\n    return 1 / 0\n")
    with raises_code("sweep.untrusted"):
        asked(tmp_path / "inner", content)
    made = done(asked(tmp_path / "inner", content, trust=True))
    assert set(made["reason"]) == {
        "../other.py:twice raises ZeroDivisionError: division by zero; expected a number of every run"
    }


def test_a_result_that_cannot_be_measured_loses_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is absent from its row, which says why; a run without any result has failed, and no call tries it again."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("def depth(answer):\n    return 1.0 if answer['e_n'] > 0.5 else float('nan')\n")
    wall = {**WALL, "gather": ["e_n", {"function": "mine.py:depth", "unit": "1"}]}
    made = done(asked(tmp_path, wall))
    lost = made["e_n"] <= 0.5
    assert 0 < lost.sum() < 6 and (made["depth"].isna() == lost).all() and (made["status"] == table.DONE).all()
    assert (made["reason"].where(lost, "") == made["reason"]).all()
    assert set(made["reason"][lost]) == {"depth is nan; expected a number of every run"}
    assert sweep_command.failures(made) is None
    jobs = Jobs(tmp_path / "sweep.yaml")
    jobs.run(f"{ALL}0", tmp_path / "done.json")
    jobs.verdict(tmp_path / "verdict.txt")
    alone = done(asked(tmp_path, {**wall, "gather": wall["gather"][1:]}))
    assert ((alone["status"] == table.FAILED) == lost).all()
    assert str(sweep_command.failures(alone)).endswith(": depth is nan; expected a number of every run")


def test_the_table_is_tidy_and_has_units(tmp_path: Path) -> None:
    """One row a run; the unit of each column in the metadata of its field and in attrs."""
    of = asked(tmp_path, WALL)
    done(of)
    schema = parquet.read_schema(tmp_path / "sweep" / "sweep.parquet")
    assert schema.names == ["point", *WALL["axes"], "seed", "e_n", "duration_s", "status", "reason", "run"]
    found = {name: (schema.field(name).metadata or {}).get(b"unit") for name in schema.names}
    assert found["normal_velocity_m_per_s"] == b"m/s" and found["duration_s"] == b"s" and found["e_n"] == b"1"
    read = table.read(tmp_path / "sweep")
    assert read.attrs["units"]["normal_velocity_m_per_s"] == "m/s" and len(read) == 6
    assert all((tmp_path / "sweep" / run / "point.json").exists() for run in read["run"])


def test_a_sweep_beyond_its_limits_is_refused_before_it_starts(tmp_path: Path) -> None:
    of = asked(tmp_path, {**WALL, "most_core_hours": 1e-7})
    with raises_code("sweep.too_much"):
        done(of)
    assert not (tmp_path / "store").exists()


def test_the_command_checks_runs_and_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = str(
        write(tmp_path, {**WALL, "axes": {"friction": [0.1, 0.2, 0.3], "normal_velocity_m_per_s": [0.5, 1.0, 2.0]}})
    )
    call = CliRunner(env={"COLUMNS": "300"})
    checked = call.invoke(app, ["sweep", file, "--check"])
    assert checked.exit_code == 0 and not Path("results").exists()
    assert "rebound: 9 points, 9 runs" in checked.output and "0 are in the store, 9 to run" in checked.output
    run = call.invoke(app, ["sweep", file])
    assert run.exit_code == 0 and "9 of 9 runs have results" in run.output, run.output
    assert "e_n: share of the variation normal_velocity_m_per_s" in run.output
    page = Path("results/sweeps/sweep/report.html").read_text()
    offered = [json.loads(found) for found in re.findall(r'<script type="application/json">(.*?)</script>', page)]
    made = pd.read_parquet("results/sweeps/sweep/sweep.parquet")
    means = made.groupby("friction")["e_n"].mean().tolist()
    assert offered[0][0] == {"label": "mean", "x": [0.1, 0.2, 0.3], "y": pytest.approx(means)}
    assert [len(lines) for lines in offered] == [3, 3, 3, 3, 0, 0]  # curves as CSV and SVG, maps as SVG
    assert '<a href="sweep.csv">' in page and Path("results/sweeps/sweep/sweep.csv").exists()
    for names in (["normal_velocity_m_per_s", "e_n", "friction"], ["friction", "normal_velocity_m_per_s", "e_n"]):
        drawn = call.invoke(app, ["sweep", "plot", file, *names])
        assert drawn.exit_code == 0, drawn.output
        assert "<svg" in Path(drawn.stdout.strip()).read_text()
    for words, code in (
        (["plot", file, "friction"], "cli.plot_words"),
        (["plot", file, "frict", "e_n"], "sweep.no_column"),
        (["plot", file, "e_n", "friction"], "sweep.axis_as_y"),
        (["plot", file, "friction", "e_n", "--out", "a.bmp"], "sweep.plot_suffix"),
        ([file, "more.yaml"], "cli.sweep_words"),
        (["none.yaml"], "file.unread"),
    ):
        wrong = call.invoke(app, ["sweep", *words])
        assert (wrong.exit_code, code_of(wrong)) == (1, code), wrong.output


class Fake(Kind):
    """A base with run directories and no engine."""

    def built(self, values: Any, seed: int) -> Built:
        return Built(f"fake-{values['a']}-{seed}", values)

    def run(self, built: Built, folder: Path, ranks: int) -> dict[str, float | None]:
        write_json(folder / "summary.json", {})
        return {"b": 1.0}

    def cost(self, built: Built) -> Cost:
        return Cost(0.0, 0.0)

    def known(self, built: Built) -> list[str]:
        return ["b"]


def test_what_runs_took_is_printed_next_to_the_prediction_and_predicts_others(tmp_path: Path) -> None:
    """A known result of 3600 s and 2 MB a run; where a base has no prediction, the mean of its runs in the store is it."""
    store = Store(tmp_path / "store")
    runs = [Run(Numbered(k, {"a": k}), 0, Built(f"fake-{k}", None)) for k in (1, 2, 3)]
    of = Plan(
        tmp_path / "f.yaml", plan.description.read(write(tmp_path, WALL)), Fake(Base(case=1), tmp_path), store, tmp_path
    )
    assert plan.spent(of, [(run, Cost(1800.0, 1e6)) for run in runs]) is None
    for run in runs[:2]:
        (store.place(run.built.name)).mkdir(parents=True)
        (store.place(run.built.name) / "table").write_bytes(bytes(2_000_000))
        store.note(run.built.name, 3600.0 * run.point.number)
    printed = plan.spent(of, [(run, Cost(1800.0, 1e6)) for run in runs])
    assert printed == "2 runs took 3 core-hours, 0.004 GB (predicted 1 core-hours, 0.002 GB)"
    assert plan.spent(of, [(run, UNKNOWN) for run in runs]) == "2 runs took 3 core-hours, 0.004 GB"
    assert store.typical("fake-3") == Cost(5400.0, 2e6) and store.typical("other-3") is None


def test_the_time_of_a_resumed_run_is_not_known(tmp_path: Path) -> None:
    """Its wall time counts from the checkpoint, the processor time from this call: the row says so, no cost is stored."""
    for step, time_s in ((None, 2.0), (500, None)):
        summary = {
            "wall_s": 2.0,
            "resumed_at_step": step,
            "events": None,
            "initial_liquid_m3": 0.0,
            "liquid_end_m3": {},
        }
        loaded: Any = SimpleNamespace(summary=summary, path=tmp_path, has=lambda _: False)
        assert run_numbers.numbers(loaded)["wall_time_s"] == time_s
    of = asked(tmp_path, {**WALL, "gather": ["e_n"]})
    notes = [table._notes(of, tmp_path, {"wall_time_s": time_s}) for time_s in (2.0, None)]
    assert notes == [[], ["wall_time_s: unknown, as the run was resumed from a checkpoint"]]
    store, kind = Store(tmp_path / "store"), Fake(Base(wall=Path("none")), tmp_path)
    for number, begun in ((1, False), (2, True)):
        run = Run(Numbered(number, {"a": number}), 0, kind.built({"a": number}, 0))
        if begun:
            with run_folder.hold(store.place(run.built.name)):
                write_json(store.place(run.built.name) / "scene.json", {})
        assert running.do(kind, run, store) and (store.took(run.built.name) is None) == begun


def test_a_run_of_another_call_is_left_to_it(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The folder of one point is locked by another thread: the other points are run, nothing is written there."""
    store, kind = Store(tmp_path), Fake(Base(wall=Path("none")), tmp_path)
    runs = [Run(Numbered(k, {"a": k}), 0, kind.built({"a": k}, 0)) for k in (1, 2)]
    held, done = threading.Event(), threading.Event()

    def hold() -> None:
        with run_folder.hold(store.place(runs[0].built.name)):
            held.set()
            done.wait(60)

    thread = threading.Thread(target=hold)
    thread.start()
    held.wait(60)
    try:
        assert [running.do(kind, run, store) for run in runs] == [False, True]
    finally:
        done.set()
        thread.join()
    assert "another run is active" in caplog.text and store.reason(runs[0].built.name) == "it was not run to the end"
    assert running.do(kind, runs[0], store) and store.numbers(runs[0].built.name, engine=True) == {"b": 1.0}


def test_added_points_of_other_axes_are_refused(tmp_path: Path) -> None:
    (tmp_path / "sweep").mkdir()
    write_json(tmp_path / "sweep" / "added.json", [{"friction": 0.3}])
    with raises_code("sweep.added_axes"):
        asked(tmp_path, WALL)


def test_files_of_one_name_have_separate_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By command and by workflow; the numbered folder is found again, a file that has gone gives its folder up."""
    monkeypatch.chdir(tmp_path)
    for folder in ("one", "two", "three"):
        Path(folder).mkdir()
    root, call = Path("results/sweeps"), CliRunner(env={"COLUMNS": "300"})
    one = write(Path("one"), {**WALL, "name": "first"})
    two = write(Path("two"), {**WALL, "name": "second", "gather": ["duration_s"]})
    assert call.invoke(app, ["sweep", str(one)]).exit_code == 0
    jobs = Jobs(two)
    assert jobs.folder == root / "sweep-2"
    jobs.run(f"{ALL}0", jobs.folder / "jobs" / f"{ALL}0.json")
    jobs.show()
    assert call.invoke(app, ["sweep", str(two)]).exit_code == 0
    assert call.invoke(app, ["sweep", str(one.absolute())]).exit_code == 0
    assert {folder.name for folder in root.iterdir()} == {"sweep", "sweep-2", "store"}
    assert "e_n" in table.read(root / "sweep").columns and "duration_s" in table.read(root / "sweep-2").columns
    drawn = call.invoke(app, ["sweep", "plot", str(two), "friction", "duration_s"])
    assert drawn.exit_code == 0 and "sweep-2" in drawn.stdout
    point = {"friction": 0.3, "normal_velocity_m_per_s": 0.7}
    write_json(root / "sweep" / "added.json", [point])
    assert Jobs(one).plan.added == [point]
    one.unlink()
    third = write(Path("three"), WALL)
    assert Jobs(third).folder == root / "sweep" and Jobs(third).plan.added == []
    assert call.invoke(app, ["sweep", str(third)]).exit_code == 0  # the points of the file that has gone are set aside
    assert Jobs(third).plan.added == [] and len(table.read(root / "sweep")) == 6
    assert {path.name for path in (root / "sweep").glob("added*")} == {"added.1.json"}
    assert Jobs(write(Path("three"), WALL, "store.yaml")).folder == root / "store-2"


def test_the_folder_of_another_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Given by --out; `plot` takes such a folder in place of the file."""
    monkeypatch.chdir(tmp_path)
    call = CliRunner(env={"COLUMNS": "300"})
    one, two = write(Path(), WALL, "one.yaml"), write(Path(), {**WALL, "gather": ["e_t"]}, "two.yaml")
    assert call.invoke(app, ["sweep", str(one), "--out", "mine"]).exit_code == 0
    with pytest.raises(PywetError) as refused:
        done(plan.read(two, Path("mine")))
    assert refused.value.code == "sweep.folder_of_another"
    assert "e_n" in table.read(Path("mine")).columns
    drawn = call.invoke(app, ["sweep", "plot", "mine", "friction", "e_n"])
    assert drawn.exit_code == 0 and Path("mine/friction-e_n.svg").exists()


def test_a_result_that_no_run_has_is_named_and_stops_nothing(tmp_path: Path) -> None:
    """A head-on collision has no tangential restitution: table and page are made, `plot` refuses to draw nothing."""
    of = asked(tmp_path, {**WALL, "gather": ["e_t", "e_n"]})
    output_text: list[str] = []
    made = sweep_command.carry_out(of, 1, 1, 0, output_text.append)
    assert made["e_t"].isna().all() and made["e_n"].notna().all()
    assert "e_t: no run has it" in output_text and "e_t: no run has it" in (of.folder / "report.html").read_text()
    with raises_code("sweep.no_values", given="e_t"):
        sweep_command.plot(of.folder, ["friction", "e_t"], None)
