"""The command line: what outsiders rely on, and how it speaks of mistakes."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer.main
from matplotlib.figure import Figure
from typer.testing import CliRunner

import pywet
from pywet import config, stages
from pywet.cases.screening import cases
from pywet.cli import groups
from pywet.cli.app import app
from pywet.laws import registry
from pywet.report import bridge
from tests.cases.screening import synthetic
from tests.error_codes import code_of, error_of

CONFIG = Path(__file__).parent.parent.parent / "config"


@pytest.fixture
def runner() -> CliRunner:
    return CliRunner(env={"COLUMNS": "200", "NO_COLOR": "1"})


def test_help_loads_no_library_of_numbers() -> None:
    """Else `pywet --help` would take a second and more: what computes is imported by the command that needs it."""
    text = "import sys, pywet.cli.app; print(*{'numpy', 'pandas', 'scipy', 'numba', 'pydantic', 'pyarrow'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_a_question_whose_machine_code_is_not_made_yet_says_that_it_takes_a_while(
    runner: CliRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line on standard error at the first question where the mark of `pywet.cli.warm` is missing, once: a wheel has none.

    A call that ends before its answer leaves the line to the next one; the answer is JSON alone.
    """
    from pywet.collisions.spheres import command as spheres
    from pywet.util import machine_code

    monkeypatch.setattr(spheres, "run", lambda problem: 1 / 0)
    monkeypatch.setattr(spheres, "describe", lambda problem: {"t_end": problem.t_end})
    monkeypatch.setattr(machine_code, "_mark", lambda asked: tmp_path / asked)
    question = ["collide", "spheres", str(CONFIG.parent / "examples" / "three_equal_spheres.json")]
    assert runner.invoke(app, question).stderr.startswith("compiling for this processor, once")
    monkeypatch.setattr(spheres, "run", lambda problem: problem)
    first, second = (runner.invoke(app, question) for _ in range(2))
    assert first.stderr.startswith("compiling for this processor, once") and second.stderr == ""
    machine_code.mark()
    (tmp_path / "spheres").unlink()
    assert runner.invoke(app, question).stderr == ""
    assert json.loads(first.stdout) == json.loads(second.stdout) == {"t_end": 400.0}


def test_version_is_that_of_the_package(runner: CliRunner) -> None:
    message = runner.invoke(app, ["--version"])
    assert (message.exit_code, message.output.split()) == (
        0,
        ["pywet", version("pywet")],
    ) and pywet.__version__ == version("pywet")


def test_every_command_of_the_architecture_exists(runner: CliRunner) -> None:
    text = runner.invoke(app, ["--help"]).output
    for name in ("doctor", "laws", "plan", "run", "bridge", "collide", "replay", "view"):
        assert f" {name} " in text
    below = runner.invoke(app, ["collide", "--help"]).output
    assert " wall " in below
    assert " spheres " in below


def test_a_folder_of_runs_names_them(runner: CliRunner, tmp_path: Path) -> None:
    for name in ("dry", "moist"):
        (tmp_path / "runs" / name).mkdir(parents=True)
        (tmp_path / "runs" / name / "scene.json").touch()
    for command in ("view", "screen"):
        result = runner.invoke(app, [command, str(tmp_path / "runs")])
        assert result.exit_code == 1 and "which contains runs (dry, moist)" in result.stderr, result.output


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["plan", "99", "--config", str(CONFIG)], "there is no case 99"),
        (["plan", "2", "--scale", "huge", "--config", str(CONFIG)], "there is no scale huge"),
        (["run", "2", "--scale", "huge", "--config", str(CONFIG)], "there is no scale huge"),
        (["plan", "2", "--config", "nowhere"], "could not be read"),
        (["view", "nowhere"], "nowhere does not exist; expected a run directory"),
        (["plot", "nowhere"], "`pywet run-scene FILE --out DIR` write: with scene.json, history/ and results/"),
        (["plan", "deck.yaml"], "for a scene use pywet run-scene deck.yaml, with --check to print its plan"),
        (["run", "deck.yaml"], "for a scene use pywet run-scene deck.yaml"),
    ],
)
def test_a_mistake_is_one_sentence_without_a_traceback(runner: CliRunner, command: list[str], message: str) -> None:
    result = runner.invoke(app, command)
    assert result.exit_code == 1
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert isinstance(result.exception, SystemExit)


@pytest.mark.parametrize("columns", ["40", "80"])
def test_names_of_laws_are_whole_in_a_narrow_terminal(columns: str) -> None:
    words = CliRunner(env={"COLUMNS": columns}).invoke(app, ["laws"]).output.split()
    assert {name for laws in registry.BUILT_IN.values() for name in laws} <= set(words) and "…" not in "".join(words)


def test_the_page_of_the_interface_has_signatures(runner: CliRunner) -> None:
    """Names with parameters and the first line of their docstrings in place of the directives of Sphinx."""
    text = runner.invoke(app, ["docs", "api"]).output
    assert "eval-rst" not in text and ".. auto" not in text
    assert "pywet.run(scene, folder, ranks=1, progress=False)\n    Build, simulate, evaluate and replay a scene" in text


def test_the_plan_explains_its_errors(runner: CliRunner) -> None:
    text = " ".join(runner.invoke(app, ["plan", "2", "--why", "--config", str(CONFIG)]).output.split())
    assert "errors of defaults: largest differences from finer settings, summed over the settings" in text
    assert "force: mostly from capillary; pywet plan 2 --accuracy 5% chooses settings with less" in text


@pytest.mark.parametrize(
    ("words", "used"),
    [((), 2), (("--ranks", "1"), 1), (("--engine", "yade", "--ranks", "1"), 1), (("--engine", "yade"), 0)],
)
def test_a_case_runs_on_the_configured_ranks(
    runner: CliRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], used: int
) -> None:
    """Those of config.yaml unless --ranks is given; refused before anything is run by an engine without ranks."""
    shutil.copytree(CONFIG, tmp_path / "config")
    path, ranks = tmp_path / "config" / "config.yaml", []
    path.write_text(path.read_text().replace("ranks: 1", "ranks: 2"))
    monkeypatch.setattr(
        stages, "carry_out", lambda *given: ranks.append(given[5]) or SimpleNamespace(failed_at="", reason="")
    )
    done = runner.invoke(app, ["run", "1", "--config", str(path.parent), "--out", str(tmp_path / "run"), *words])
    assert (ranks, code_of(done)) == (([used], "cli.stage_failed") if used else ([], "engine.one_process"))


@pytest.mark.parametrize(
    ("words", "code", "key"),
    [
        *((words, "cli.no_case", words[0]) for words in (["--of", "force"], ["--write", "x"], ["--why"], ["--json"])),
        (["2", "--write", "x"], "cli.plan_options", "--write"),
        (["2", "--of", "force"], "cli.plan_options", "--of"),
        (["2", "--accuracy", "2%", "--json"], "cli.plan_options", "--json"),
        (["2", "--accuracy", "2%", "--why"], "cli.plan_options", "--why"),
        (["2", "--why", "--json"], "cli.plan_options", "--json"),
    ],
)
def test_options_of_plan_without_effect_are_refused(runner: CliRunner, words: list[str], code: str, key: str) -> None:
    error = error_of(runner.invoke(app, ["plan", *words, "--config", str(CONFIG)]))
    assert error is not None and (error.code, error.key) == (code, key)


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["kinetics", "run", "--from", "2"], "--from"),
        *(
            (["view", "run", "--step", "500", word], "--step")
            for word in ("--movie", "--paraview", "--vtkhdf", "--ovito")
        ),
    ],
)
def test_options_without_effect_are_refused(runner: CliRunner, words: list[str], key: str) -> None:
    """Before the run is read: there is none in this folder."""
    error = error_of(runner.invoke(app, words))
    assert error is not None and (error.code, error.key) == ("cli.unused_option", key)
    used = [*words, "--close-up", "1"] if words[0] == "view" else words[:2]
    assert code_of(runner.invoke(app, used)) not in ("", "cli.unused_option")


def test_a_plot_of_a_bridge_has_the_format_of_its_name(runner: CliRunner, tmp_path: Path) -> None:
    """Another suffix is refused before the question is read; .PNG is a PNG."""
    error = error_of(runner.invoke(app, ["bridge", "none.json", "--plot", "force.pdf"]))
    assert error is not None and (error.code, error.given, error.expected) == ("plot.suffix", ".pdf", (".svg", ".png"))
    for name, start in (("a.PNG", b"\x89PNG"), ("a.svg", b"<?xml")):
        bridge.draw(tmp_path / name, Figure())
        assert (tmp_path / name).read_bytes().startswith(start)


def test_plan_prints_one_line_per_effect(runner: CliRunner) -> None:
    lines = runner.invoke(app, ["plan", "1", "--config", str(CONFIG)]).output.strip().splitlines()
    assert lines[0].split() == ["effect", "number", "tolerance", "share", "cost", "law"]
    assert lines[1].split()[:2] == ["bridges", "off"] and max(map(len, lines)) <= 80
    retire = next(k for k, line in enumerate(lines) if line.startswith("retire "))
    assert (
        " ".join(" ".join(lines[retire:]).split())
        == "retire off a dry run without analytic wires runs on the stock program"
    )
    sizes = next(k for k, line in enumerate(lines) if line.startswith("size "))
    assert lines[sizes].split() == ["size", "spheres", "asked", "made"] and lines[sizes + 4].split()[0] == "all"
    switched = {line.split()[0]: line.split()[1] for line in lines[1:sizes]}
    assert {effect for effect, state in switched.items() if state == "on"} == {
        "rolling",
        "tangential_history",
        "gravity",
    }
    assert set(switched.values()) == {"on", "off"} and len(switched) == 13


def test_plan_fits_a_terminal_says_why_and_gives_json(runner: CliRunner) -> None:
    short = runner.invoke(app, ["plan", "2", "--config", str(CONFIG)]).output
    assert max(map(len, short.splitlines())) <= 80 and "Bond number" not in short
    assert len(short.splitlines()) <= 24  # one screen: effects, time and accuracy, stability
    answers = {line.split()[0]: line.split() for line in short.splitlines()}
    assert 0.0 < float(answers["time"][3]) < 0.1 and "force 73 %" in " ".join(answers["accuracy"])
    assert 0.0 < float(answers["stability"][5]) < 1.0 and answers["stability"][4] == "s,"
    assert "1/Bond number" in runner.invoke(app, ["plan", "2", "--why", "--config", str(CONFIG)]).output
    plan = json.loads(runner.invoke(app, ["plan", "2", "--json", "--config", str(CONFIG)]).output)
    rows = short.partition("\nsize ")[0].splitlines()[1:]
    assert [row["effect"] for row in plan["rows"]] == [line.split()[0] for line in rows]


def test_plan_says_whether_spheres_are_retired_and_what_that_saves(runner: CliRunner) -> None:
    """0.93 of what comes 3.3 s after the opening of the slide: (20.1 - 3.3)/20.1 of a run at full scale."""
    message = " ".join(runner.invoke(app, ["plan", "2", "--scale", "full", "--config", str(CONFIG)]).output.split())
    assert "retire on saves about 78 % of the processor time: what passes and where the liquid goes is asked" in message
    message = " ".join(runner.invoke(app, ["plan", "2", "--config", str(CONFIG)]).output.split())
    assert "retire off the run ends 1.4 s after the opening" in message
    plan = json.loads(runner.invoke(app, ["plan", "2", "--scale", "full", "--json", "--config", str(CONFIG)]).output)[
        "retirement"
    ]
    assert plan["on"] is True and plan["saves"] == pytest.approx(0.93 * (1.0 - 3.3 / 20.1), rel=1e-9)


def test_lists_are_given_as_json(runner: CliRunner) -> None:
    laws = json.loads(runner.invoke(app, ["laws", "--json"]).output)
    assert {"capillary", "viscous_normal", "rupture", "formation", "transfer"} <= {row["kind"] for row in laws}
    checks = json.loads(runner.invoke(app, ["doctor", "--json"]).output)
    assert all(check["ok"] for check in checks if check["name"] == "liggghts")


def test_a_step_that_the_viscous_force_makes_short_is_reported_before_the_run() -> None:
    """With water the collision governs; ten times a collision's fraction of glycerol's damping time does not."""
    loaded = config.load(CONFIG)
    assert cases.shorter_step(loaded, 2, "smoke") is None
    liquid = loaded.materials.liquid
    thick = liquid.model_copy(update={"viscosity_Pa_s": liquid.viscosity_Pa_s.model_copy(update={"value": 1.0})})
    glycerol = replace(loaded, materials=loaded.materials.model_copy(update={"liquid": thick}))
    message = cases.shorter_step(glycerol, 2, "smoke")
    ratio = cases.ingredients(loaded, 2, "smoke").time_step_s / cases.ingredients(glycerol, 2, "smoke").time_step_s
    assert message is not None and "semi_implicit" in message and f" {ratio:.1f} times" in message


def helps(command: Any, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command with the words that call it."""
    for name, sub in getattr(command, "commands", {}).items():
        yield from helps(sub, (*words, name))
    if words:
        yield words, command


def test_no_help_loses_a_word_in_brackets(runner: CliRunner) -> None:
    """Print every word of a help, also in brackets such as [m/s], which the printer would take for markup."""
    for words, command in helps(typer.main.get_command(app)):
        shown = re.sub(r"[\W_]+", "", runner.invoke(app, [*words, "--help"]).output)
        for text in (command.help, *(getattr(p, "help", None) for p in command.params)):
            assert re.sub(r"[\W_]+", "", text or "") in shown, (words, text)


def test_laws_lists_the_registry(runner: CliRunner) -> None:
    text = runner.invoke(app, ["laws"]).output
    for name in ("rabinovich", "pitois", "goldman", "willett_unequal", "shi_mccarthy", "parabola"):
        assert name in text


def test_replay_of_a_dry_run_has_nothing_to_do(runner: CliRunner, tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case01", moist=False)
    result = runner.invoke(app, ["replay", str(run)])
    assert (result.exit_code, "is dry" in result.output) == (0, True)


def test_replay_says_by_its_status_what_it_found(runner: CliRunner, tmp_path: Path) -> None:
    """2 and one sentence for a history that cannot be read; of several runs a line each and the worst status; JSON on request."""
    dry = synthetic.make(tmp_path / "case01", moist=False)
    (tmp_path / "case02" / "history").mkdir(parents=True)
    (tmp_path / "case02" / "history" / "meta.json").write_text("{")
    result = runner.invoke(app, ["replay", str(tmp_path / "case02")])
    assert (result.exit_code, result.stdout) == (2, "")
    assert len(result.stderr.strip().splitlines()) == 1 and "scene.json is missing" in result.stderr
    result = runner.invoke(app, ["replay", str(dry), str(tmp_path / "case02"), str(tmp_path / "none")])
    assert result.exit_code == 2
    assert [line.split()[1] for line in result.stdout.strip().splitlines()] == ["dry", "unreadable", "unreadable"]
    result = runner.invoke(app, ["replay", "--json", str(dry)])
    assert result.exit_code == 0 and json.loads(result.stdout)["status"] == "dry"


def test_view_writes_series_and_picture(runner: CliRunner, tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02")
    result = runner.invoke(app, ["view", str(run), "--step", "200"])
    assert result.exit_code == 0, result.output
    made = [word for word in result.output.split() if word.endswith((".pvd", ".png"))]
    assert [Path(made[k]).exists() for k in range(4)] == [True] * 4
    # not the picture of the report, which says what is seen in it
    assert made[3].endswith("picture_200.png") and not (run / "picture.png").exists()


def test_a_failed_stage_of_run_is_the_sentence(
    runner: CliRunner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pywet import stages
    from pywet.errors import PywetError

    def refuse(*_: object, **__: object) -> None:
        raise PywetError("the engine was given nonsense")

    monkeypatch.setattr(stages, "simulate", refuse)
    result = runner.invoke(app, ["run", "1", "--config", str(CONFIG), "--out", str(tmp_path / "case01")])
    assert (result.exit_code, code_of(result)) == (1, "cli.stage_failed")
    assert "stage simulate failed: the engine was given nonsense" in result.stderr
    status = json.loads((tmp_path / "case01" / "status" / "simulate.json").read_text())
    assert status["reason"] == "the engine was given nonsense"


def test_each_command_is_in_a_group_and_has_an_example_that_can_be_parsed() -> None:
    """No command is left in a group without a name; an example's command is known, its options are among those of its help."""
    shown = CliRunner().invoke(app, ["--help"], env={"COLUMNS": "200"}).output
    assert all(group in shown for group in groups.GROUPS) and "─ Commands ─" not in shown
    for name, words in ((name, words) for group in groups.GROUPS.values() for name, words in group.items()):
        reported = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "200"}).output
        assert f"Example: pywet {name}" in reported, name
        given = words.split()
        path = given[:2] if name in ("collide", "study") else given[:1]
        options = CliRunner().invoke(app, [*path, "--help"], env={"COLUMNS": "200"}).output
        assert given[0] == name and all(word in options for word in given if word.startswith("--")), words
