"""docs/own-scene.md: its snippets run as they are printed, its tables are those of the source."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import get_args

import numpy as np
import pandas as pd
import pytest
import yaml

import pywet
from pywet.cases.custom.building import Building
from pywet.cases.custom.walls import MOTIONS, SHAPES
from pywet.laws.kinds import PRESETS
from pywet.runs.loaded import Run
from pywet.scene import Reservoir, Vibration
from pywet.scene_stages import read_scene
from pywet.schema import RESERVOIRS, TABLES, meanings
from tests.cases.custom.conftest import EXAMPLES, beads

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "own-scene.md").read_text()


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found
    return found.group(1)


@pytest.mark.engine
def test_the_python_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It runs in an empty folder; what it prints are units and meanings, and the liquid that was put in: 1 % of 30 beads."""
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(block("python"), "page", "exec"), names)
    assert "m/s S at the event" in capsys.readouterr().out
    mass = 30 * 2500 * 3.14159265 / 6 * 0.003**3
    liquid: pd.DataFrame = names["run"].liquid
    assert liquid["total_m3"].to_numpy() == pytest.approx(0.01 * mass / 1000, rel=1e-6)
    assert (tmp_path / "cup" / "picture.png").exists() and (tmp_path / "cup" / "vtk" / "walls.pvd").exists()
    report_says_what_the_run_does((tmp_path / "cup" / "report.html").read_text(), names["run"])


def report_says_what_the_run_does(page: str, run: Run) -> None:
    """Walls by name with their liquid at the end, every quantity of the replay, what it did not check, links to files."""
    last = run.liquid.iloc[-1]
    for column in ("spheres_beads_m3", "wall_cup_m3"):
        assert f">{column.removesuffix('_m3').replace('_', ' ')}</td><td>{1e9 * last[column]:.4g}</td>" in page
    assert [q for q in run.replay["quantities"] if f">{q}</td>" not in page] == []
    assert [what for what in run.replay["not_checked"] if html.escape(what) not in page] == []
    links = re.findall(r'<a href="([^#"]+)"', page)
    assert len(links) >= 8 and [link for link in links if not (run.path / link).exists()] == []


def test_the_yaml_of_the_page(tmp_path: Path) -> None:
    """One gram of 5 mm POM is 11 spheres; the fine have their own film."""
    (tmp_path / "scene.yaml").write_text(block("yaml"))
    made = Building(read_scene(tmp_path / "scene.yaml"))
    assert [c.count for c in made.classes] == [11, 10]
    assert made.thickness[1] == pytest.approx(20e-6)
    assert isinstance(made.scene().walls[0].motion_parameters, Vibration)


def test_the_feed_of_the_page() -> None:
    """200 beads enter in half a second, the first after 20 ms and a fourhundredth of it."""
    given = yaml.safe_load(re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)[1])
    made = Building(pywet.Scene(**beads(**given, duration_s=0.6)))
    enters = np.array(made.scene().enters(made.spheres["type"])) * made.time_step
    assert len(enters) == 200 and enters[[0, -1]] == pytest.approx(
        [0.02 + 0.5 / 400, 0.52 - 0.5 / 400], abs=made.time_step
    )


def test_every_scene_of_the_gallery_is_there() -> None:
    """A picture of at most 150 kB and a command for each file of examples/scenes."""
    page = (DOCS / "gallery.md").read_text()
    names = sorted(path.stem for path in EXAMPLES.glob("*.yaml"))
    assert sorted(re.findall(r"pictures/scene_(\w+)\.png", page)) == names
    for name in names:
        assert f"run-scene examples/scenes/{name}.yaml" in page
        assert (DOCS / "pictures" / f"scene_{name}.png").stat().st_size <= 150_000


def test_the_page_states_how_strong_the_default_law_is() -> None:
    """Median errors at touch are those of the law comparison, the time of the exact bridge that of the page on the engine."""
    assert pywet.Scene.model_fields["laws"].default.preset == "paper"
    row = re.search(r"^\| `rabinovich` \|(.*)\|$", (DOCS / "atlas.md").read_text(), re.MULTILINE)
    assert row and PRESETS["paper"]["capillary"] == "rabinovich"
    medians = [float(cell.split(" / ")[0]) for cell in row[1].split("|")[:6:2]]
    message = f"{min(medians):g} to {max(medians):g} %"
    readme = (DOCS.parent / "README.md").read_text()
    assert f"at touch by a median of {message}" in PAGE and f"by {message} in the median" in readme
    assert "`exact` takes 1.03 to 1.2 times as long" in (DOCS / "engine.md").read_text()
    assert "`exact` takes [3 to 20 %](engine.md) longer" in PAGE


def test_every_reservoir_is_explained() -> None:
    assert set(RESERVOIRS) == set(get_args(Reservoir))


def test_shapes_and_motions_are_those_of_the_source() -> None:
    assert all(f"`{key}`" in PAGE for key in (*SHAPES, *MOTIONS))


@pytest.mark.parametrize("table", ["trajectory", *(t for t in TABLES if meanings(t) and t != "trajectory")])
def test_every_column_of_a_log_has_a_unit_and_a_meaning(table: str) -> None:
    assert set(meanings(table)) == set(TABLES[table])
    assert all(unit and text for unit, text in meanings(table).values())
