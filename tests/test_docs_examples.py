"""Every example of the documentation is executed as it is printed: here those that no page's own test executes.

Pages with tests of their own: laws (`tests/laws/test_force_law.py`), own law (`tests/laws/test_own_page.py`), own scene
(`tests/cases/custom/test_page.py`), own material (`tests/test_config.py`). Commands in console blocks: `tests/test_docs.py`.
First steps: executed as the site is built.
"""

from __future__ import annotations

import io
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

from pywet import Deck, Feed, Outlet, stages
from pywet.calibration.answer import calibrate
from pywet.cases.custom.spheres import Spheres
from pywet.cases.script.scan import scan
from pywet.cases.small import bridge_query
from pywet.cli.app import app
from pywet.collisions.wall.problem import Problem
from pywet.config.entries import AngleEntry, NonNegativeEntry
from pywet.config.loading import parse
from pywet.errors import StoppedRun
from pywet.products.until import Until
from tests.test_docs import check_shown

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)
EXECUTED = {
    "bridge.md": ["json"],
    "calibrate.md": ["yaml"],
    "cli.md": ["python"],
    "configuration.md": ["yaml"] * 4 + ["csv"],
    "howto-own-law.md": ["python", "json", "python", "yaml", "python", "yaml", "toml"],
    "laws.md": ["python"],
    "own-scene.md": ["python", "yaml", "yaml", "yaml"],
    "screens.md": ["yaml", "yaml", "yaml"],
    "sweep.md": ["yaml"],
    "wall_collision.md": ["json"],
    "wet_benchmarks.md": ["python"],
    "young_laplace.md": ["python", "python"],
    "your-script.md": ["yaml"],
}
"""Blocks of each page that a test executes, in order."""


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and text of the blocks of a page, commands left out."""
    text = (ROOT / "docs" / page).read_text()
    return [
        (language, block) for language, block in BLOCK.findall(text) if language not in ("console", "mermaid", "text")
    ]


def execute(page: str, number: int = 0) -> dict[str, Any]:
    """Run a Python block of a page; its names."""
    names: dict[str, Any] = {}
    texts = [block for language, block in blocks(page) if language == "python"]
    exec(compile(texts[number], page, "exec"), names)
    return names


def test_no_example_is_left_out() -> None:
    """A new one needs a test that executes it, and a place in this table."""
    pages = sorted(path.name for path in (ROOT / "docs").glob("*.md"))
    found = {page: [language for language, _ in blocks(page)] for page in pages}
    assert {page: languages for page, languages in found.items() if languages} == EXECUTED


def test_both_solvers_of_the_exact_bridge_print_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    """The page gives 0.0728 to one and 0.07275 to the other; forces over it, rupture and split agree."""
    execute("young_laplace.md", 0)
    force, rupture = capsys.readouterr().out.splitlines()
    execute("young_laplace.md", 1)
    second_force, second_rupture = capsys.readouterr().out.splitlines()
    assert float(force.split()[0]) / 0.0728 == pytest.approx(float(second_force) / 0.07275, rel=1e-9)
    one, two = ([float(word) for word in line.split()[:2]] for line in (rupture, second_rupture))
    assert one == pytest.approx(two, rel=1e-6)


def test_the_liquid_of_the_page_on_scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "wet.yaml").write_text(blocks("your-script.md")[0][1])
    page = (ROOT / "docs" / "your-script.md").read_text()
    walls = "fix walls all wall/gran model hertz mesh n_meshes 1 meshes drum\n"
    (tmp_path / "in.script").write_text(walls + re.findall(r"^fix +wet .*$", page, re.MULTILINE)[0])
    found = scan(tmp_path / "in.script")
    assert found.problems == () and found.line.every == 1000 and found.wet.angle_deg(2) == 40


def test_a_stopped_run_is_caught_as_the_page_says(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stops(run_dir: Path, ranks: int, progress: bool) -> None:
        raise StoppedRun("a sphere left", reason="it left", spheres=(7,), step=100)

    monkeypatch.setattr(stages, "simulate", stops)
    execute("cli.md")
    assert capsys.readouterr().out.split("\n")[0] == "100 (7,) it left"


def test_entries_are_read_as_the_page_says() -> None:
    entries = yaml.safe_load(next(block for language, block in blocks("configuration.md") if language == "yaml"))
    assert AngleEntry.model_validate(entries["contact_angle_deg"]).value == 40
    assert NonNegativeEntry.model_validate(entries["viscosity_Pa_s"]).value == 1e-3


def test_spheres_are_inserted_as_the_page_says() -> None:
    """200 beads over half a second from 0.02 s on."""
    text = [block for language, block in blocks("own-scene.md") if language == "yaml"][1]
    (beads,) = (Spheres.model_validate(entry) for entry in yaml.safe_load(text)["spheres"])
    assert (
        beads.count == 200
        and beads.insertion is not None
        and (beads.insertion.from_s, beads.insertion.for_s) == (0.02, 0.5)
    )


def test_spheres_leave_where_the_page_says() -> None:
    """Beyond x = 60 mm, and below z = -30 mm in two sections."""
    text = [block for language, block in blocks("own-scene.md") if language == "yaml"][2]
    overs, first, rest = (Outlet.model_validate(entry) for entry in yaml.safe_load(text)["outlets"])
    assert (overs.name, overs.low_mm, overs.high_mm) == ("overs", (60, None, None), (None, None, None))
    assert first.high_mm == (20, None, -30) and rest.high_mm == (None, None, -30)


def test_the_feed_and_the_deck_of_the_page_on_screens() -> None:
    """0.1 t/h with 2 % of water; a linear stroke of 2 mm on apertures of 5 mm, at 15 degrees."""
    first, second, third = (yaml.safe_load(block) for _, block in blocks("screens.md"))
    (ore,) = (Feed.model_validate(entry) for entry in first["feed"])
    deck = Deck.model_validate(second["deck"])
    assert (ore.rate_t_per_h, ore.moisture_percent) == (0.1, 2) and deck.sections == 2
    assert (deck.aperture_mm, deck.inclination_deg) == (5, 15)
    assert (deck.stroke.kind, deck.stroke.amplitude_mm, deck.stroke.frequency_Hz) == ("linear", 2, 20)
    until = Until.model_validate(third["until"])
    assert (until.partition_percent, until.block_s, until.least_blocks, until.least_spheres) == (2, 1, 8, 50)


def test_the_query_of_the_page_on_bridges(tmp_path: Path) -> None:
    """A sphere and a wall by the laws named; at touch the exact force is below its limit 2 pi sigma r (cos + cos)."""
    (tmp_path / "query.json").write_text(blocks("bridge.md")[0][1])
    answer = bridge_query.answer(bridge_query.read(tmp_path / "query.json"))
    assert set(answer["force_N"]) == {"rabinovich", "young_laplace"} and set(answer["viscous_normal_N"]) == {"pitois"}
    touch = 2.0 * math.pi * 0.0728 * 0.0025 * sum(math.cos(math.radians(a)) for a in (11.459, 28.648))
    assert 0.5 * touch < answer["force_N"]["young_laplace"][0] < touch


def test_the_calibration_of_the_page_gives_its_answer(tmp_path: Path) -> None:
    """The file is the example's; values and intervals are those printed, and hold what the targets were made with."""
    example = ROOT / "examples" / "calibrations" / "binder.yaml"
    assert example.read_text().partition("\n")[2] == blocks("calibrate.md")[0][1]
    answer = calibrate(example, tmp_path)
    page = (ROOT / "docs" / "calibrate.md").read_text()
    for (name, reported), made_with in zip(answer["parameters"].items(), (0.002, 0.05), strict=True):
        (found,) = reported["intervals"]
        printed = re.search(rf"^{name}: (\S+) \(95 %: (\S+) to (\S+)\)$", page, re.MULTILINE)
        assert printed is not None
        values = [reported["best"], found["low"], found["high"]]
        assert [float(x) for x in printed.groups()] == pytest.approx(values, rel=2e-3)
        assert found["low"] < made_with < found["high"]
    assert answer["reached"] and not answer["not_told_apart"]


def test_the_collision_of_the_page_is_a_problem() -> None:
    problem = parse(Problem, json.loads(blocks("wall_collision.md")[0][1]), "page")
    assert problem.normal_velocity_m_per_s == 1.0


def test_the_code_that_is_checked_on_the_page_solves_the_problem(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Template, code and score as the page prints them: lubrication is within 0.88 % of Brenner's series."""
    template = CliRunner().invoke(app, ["score", "viscous_pull", "--template"]).stdout
    monkeypatch.setattr("sys.stdin", io.StringIO(template))
    execute("wet_benchmarks.md")
    (tmp_path / "my_answers.csv").write_text(capsys.readouterr().out)
    done = CliRunner().invoke(app, ["score", "viscous_pull", str(tmp_path / "my_answers.csv")])
    assert done.exit_code == 0
    check_shown("pywet score viscous_pull my_answers.csv", done.stdout)
    check_shown("pywet score viscous_pull --template", template)


def test_the_entry_point_of_the_page_is_that_of_the_template() -> None:
    text = next(block for language, block in blocks("howto-own-law.md") if language == "toml")
    assert text in (ROOT / "examples" / "plugin_template" / "pyproject.toml").read_text()
