"""Every command that takes runs, on each kind of run: it works, or one sentence names what kind it needs."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import yaml
from PIL import Image
from typer.testing import CliRunner

import pywet
from pywet import stages
from pywet.cases.small import scenes
from pywet.cli import ending
from pywet.cli.app import app
from pywet.runs.rundir import RunDir
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic
from tests.compare.test_compare import made

pytestmark = pytest.mark.engine
COMMANDS = {
    "replay": ["replay", "RUN"],
    "timestep": ["timestep", "RUN"],
    "compare": ["compare", "RUN", "RUN2"],
    "plot": ["plot", "RUN", "--out", "OUT.svg"],
    "report": ["report", "RUN"],
    "app": ["app", "RUN", "--to", "OUT.html"],
    "vtkhdf": ["view", "RUN", "--vtkhdf"],
    "ovito": ["view", "RUN", "--ovito"],
    "digest": ["digest", "RUN", "--out", "OUT.json"],
}
REFUSED = {
    ("replay", "case"): (2, "holds no meta.json; expected the history of a moist run"),
    ("replay", "dry"): (0, "the run recorded no motion in windows"),
    ("report", "bed"): (1, "no summary.json in"),
    ("report", "collision"): (1, "no summary.json in"),
    ("digest", "case"): (2, "was not replayed; expected replay.json"),
}
"""What a kind of run does not have: exit code and the sentence that says so. The cases are made by hand: no force is logged."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A run of each kind, and the JSON answer of `pywet collide`, which is no run directory."""
    folder = tmp_path_factory.mktemp("kinds")
    made(folder / "case")
    stages.results(synthetic.make(folder / "dry", moist=False))
    pair = {"name": "beads", "material": "glass", "diameter_mm": 3, "at_mm": [[5, 5, 5], [8.001, 5, 5]]}
    (folder / "two.yaml").write_text(yaml.safe_dump(beads(liquid={"percent": 1.0}, spheres=[pair])))
    words = ["run-scene", str(folder / "two.yaml"), "--out", str(folder / "custom")]
    done = CliRunner(env={"COLUMNS": "300"}).invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "off, though not negligible (effects.NAME: on): liquid_weight" in done.stderr
    (folder / "two.yaml").unlink()
    (folder / "custom" / "printed.txt").write_text(done.stdout)
    choice = scenes.Choice(spheres=20, seconds=0.02)
    for name in ("bed", "collision"):
        scenes.run(name, folder / name, choice)
        assert CliRunner().invoke(app, ["replay", str(folder / name)]).exit_code == 0
    for kind in ("case", "dry"):
        Image.new("RGB", (8, 8)).save(folder / kind / "picture.png")
    (folder / "answer").write_text(json.dumps({"restitution": 0.5}))
    return {path.name: path for path in sorted(folder.iterdir())}


def test_run_scene_ends_in_ten_lines(runs: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    """On the screen ten lines, in details.txt all of them, with --verbose both; its page is named and exists."""
    run = runs["custom"]
    output_text = (run / "printed.txt").read_text().strip().splitlines()
    assert len(output_text) <= 10 and "100 % spheres beads" in output_text[1]
    assert f"report: {run / 'report.html'}" in output_text and (run / "report.html").exists()
    details = (run / "details.txt").read_text().splitlines()
    assert len(details) > 60
    ending.show([run], verbose=True)
    printed = capsys.readouterr().out.strip().splitlines()
    assert len(printed) >= len(details) + len(output_text) and printed[-1] == output_text[-1]


def outcome(command: str, run: Path, second: Path) -> tuple[int, str]:
    """Exit code and everything printed, of a command that never ends in a traceback."""
    names = {"RUN": str(run), "RUN2": str(second)}
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, [names.get(word, word) for word in COMMANDS[command]])
    assert isinstance(done.exception, SystemExit | None), (run, done.exception)
    return done.exit_code, " ".join(done.output.split())


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_on_each_kind(
    command: str, runs: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Exit code 0 on every kind of run, but where it lacks what the command shows; what is no run is refused by name."""
    monkeypatch.chdir(tmp_path)
    wrong = []
    for kind, run in runs.items():
        second = tmp_path / f"{kind}_2"
        (shutil.copytree if run.is_dir() else shutil.copy)(run, second)
        code, output_text = outcome(command, run, second)
        if kind == "answer":
            good = code in (1, 2) and str(run) in output_text and "expected" in output_text and "run" in output_text
        else:
            status, sentence = REFUSED.get((command, kind), (0, ""))
            good = code == status and sentence in output_text
        if not good:
            wrong.append((kind, code, output_text[-600:]))
    assert wrong == []


def test_custom_scene_without_walls(runs: dict[str, Path]) -> None:
    """Two beads in mid-air have contacts and liquid, and no triangle; the walls' column is zero."""
    run = pywet.load(runs["custom"])
    assert len(RunDir(runs["custom"]).triangles) == 0
    assert run.contact_statistics["walls_per_sphere"].eq(0.0).all()
    assert run.summary["liquid_end_m3"]["total"] == pytest.approx(run.summary["initial_liquid_m3"], rel=1e-12)
