"""Inputs that are hard to take, collected from users, each with what is expected of it: a sentence, or that it runs.

Scenes are in tests/data/inputs; surfaces are made again as the CAD programs left them.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from typer.testing import CliRunner

from pywet import scene_stages as commands
from pywet.cases.custom.building import Building
from pywet.cases.custom.description import Scene
from pywet.cases.custom.walls import Wall
from pywet.cli.app import app
from pywet.engines.liggghts import driver
from pywet.geometry.solids import tube
from tests.cases.custom.conftest import beads
from tests.engines.liggghts import beds
from tests.error_codes import raises_code
from tests.geometry.test_cad import CUBE, CUP, LINE, POINT, TURNED, binary, jitter, text

TESTS = Path(__file__).parents[1]
SCENES = TESTS / "data" / "inputs"
RUNS = "runs"
EXPECTED = {
    "02_no_bridge_forms": RUNS, "race_a": RUNS, "race_b": RUNS, "s01_corner": RUNS,
    "s01b_stl_corner": RUNS, "s01c_vessel_corner": RUNS,
    "s02_psd12": "0.06 g of b01 are 0.05 of one sphere (1.212 g); expected at least half a sphere of every size",
    "s04f_tiny": RUNS, "s05_tilted_axis": RUNS, "s05b_upright_axis": RUNS,
    "s06_metres": "v_in_metres.stl in mm is 0.036 mm long, compared with spheres of 3 mm; expected a size that they meet",
    "s07_offset": RUNS,
    "s08_thin_plate": RUNS, "s08b_thin_plate_moist": RUNS, "s16_double_deck": RUNS, "s17_leaves": RUNS,
    "s19b_youngs": "expected contact: hertz for materials.meal.youngs_modulus_Pa",
}  # fmt: skip
"""Scene -> the sentence that refuses it, or that it runs."""
LEFT = r"LIGGGHTS stopped: sphere \d+ left the simulated box .* expected walls or a tray .* through the lower z face"
OVER = r"left the simulated box before step .*expected walls or a tray"  # over the upper edge of a wall
ENDS = {"s05_tilted_axis": LEFT, "s05b_upright_axis": LEFT, "s17_leaves": LEFT, "s16_double_deck": OVER}
"""Scene that is built, and whose spheres fall out of it -> what ends its run: where and through which face."""
LONG = np.concatenate([c for c, _ in tube(20.0, 3.0, 64, 0.0, 900.0)])
SURFACES: dict[str, tuple[str | bytes, str]] = {
    "a_ascii": (text(CUP), ""), "ae_long_tube": (binary(LONG), ""), "c_bin_trail": (binary(CUP) + b"\r\n", "passed over 2 bytes"),
    "ad_share_edge": (text(np.concatenate([CUBE, CUBE + np.array([20.0, 20.0, 0.0])])), "drew bodies 2 um apart"),
    "f_blank_end": (text(CUP) + "\n", ""), "i_umlaut_latin1": (text(CUP).replace("solid part", "solid Gefäß"), ""),
    "j_comma": (text(CUP).replace(".", ","), "read commas as decimal points"),
    "m_one_facet_turned": (text(TURNED), "turned 1 facets"),
    "o_degenerate_point": (text(POINT), "removed 1 facets without area"),
    "p_degenerate_line": (text(LINE), "removed 1 facets without area"),
    "r_jitter_0p1um": (text(jitter(1e-4)), "joined 68 vertices nearer than 1 um"),
    "s_jitter_5nm": (text(jitter(5e-6)), "joined 68 vertices nearer than 0.02 um"),
    "u_offset_1e6mm": (text(CUP + np.array([1e6, 2e6, 0.0])), ""), "v_in_metres": (text(1e-3 * CUP), ""),
    "x_hollow_closed": (text(np.concatenate([CUBE, 0.5 * CUBE[:, ::-1] + np.array([0.0, 0.0, 5.0])])), ""),
}  # fmt: skip
"""Surface -> its file, and what is reported to be repaired; none is refused by itself."""
ELSEWHERE = {
    "01_out_dot_deletes_results": "reliability/test_lost.py: test_a_folder_of_others_is_refused_as_it_is",
    "03_stiffness_1e16": "reliability/rows/scenes.yaml: scene: a stiffness of 1e16 N/m",
    "04_duration_below_a_step": "reliability/rows/scenes.yaml: scene: a duration below a step",
    "05_at_mm_empty": "reliability/rows/scenes.yaml: scene: no places",
    "06_box_1e300": "reliability/rows/scenes.yaml: scene: a box of 1e300 mm",
    "07_fed_region_narrower_than_sphere": "reliability/rows/scenes.yaml: scene: a region of insertion narrower than its sphere",
    "08_speed_1e308": "reliability/rows/scenes.yaml: scene: a speed of 1e308 m/s",
    "09_two_hundred_million": "reliability/rows/scenes.yaml: scene: two hundred million spheres",
    "10_dev_null_replaced": "reliability/test_lost.py: test_devices_pipes_and_links_are_written_to",
    "11_replay_false_alarm": "test_sound_runs.py: test_a_component_that_counts_as_none_is_in_doubt",
    "12_holds_this_very_run": "reliability/test_lost.py: test_what_a_run_promises",
    "13_heap_overflow_spheres": "engines/liggghts/test_border.py: test_spheres_that_are_not_the_scenes_are_refused",
    "14_lock_symlink_truncates": "reliability/test_lost.py: test_links_in_a_run_are_refused",
    "15_refused_call_spoils_run_at_work": "reliability/test_lost.py: test_the_lock_comes_first",
    "16_score_field": "reliability/rows/scenes.yaml: score: a field of 200,000 digits",
    "17_calibrate_value_1e308": "reliability/rows/scenes.yaml: calibrate: a target of 1e308",
    "18_yaml_bomb": "reliability/rows/scenes.yaml: scene: aliases of aliases, twelve levels",
}
"""Input -> the row or test that holds it."""


def surfaces(folder: Path) -> Path:
    folder.mkdir()
    for name, (content, _) in SURFACES.items():
        data = content if isinstance(content, bytes) else content.encode("latin-1")
        (folder / f"{name}.stl").write_bytes(data)
    return folder


def scene(name: str, folder: Path) -> Path:
    """A copy of a scene, with the surfaces where it looks for them."""
    surfaces(folder / "stl")
    (folder / "scenes").mkdir()
    path = folder / "scenes" / f"{name}.yaml"
    path.write_text((SCENES / f"{name}.yaml").read_text())
    return path


def test_every_scene_has_a_row() -> None:
    assert {path.stem for path in SCENES.glob("*.yaml")} == set(EXPECTED)


@pytest.mark.parametrize("name", EXPECTED)
def test_a_scene_is_built_or_refused_with_its_reason(name: str, tmp_path: Path) -> None:
    path = scene(name, tmp_path)
    if EXPECTED[name] == RUNS:
        made = Building(commands.read_scene(path)).scene()
        assert made.steps > 0 and sum(c.count for c in made.classes) > 0
        return
    done = CliRunner(env={"COLUMNS": "400"}).invoke(app, ["run-scene", str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 1 and EXPECTED[name] in " ".join(done.stderr.split()), done.stderr


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize("name", [name for name, says in EXPECTED.items() if says == RUNS])
def test_a_scene_runs_to_its_page_or_says_where_spheres_left(name: str, tmp_path: Path) -> None:
    done = CliRunner(env={"COLUMNS": "400"}).invoke(
        app, ["run-scene", str(scene(name, tmp_path)), "--out", str(tmp_path / "out")]
    )
    if name in ENDS:
        assert done.exit_code == 1 and re.search(ENDS[name], " ".join(done.stderr.split())), done.stderr[-2000:]
        return
    assert done.exit_code == 0 and (tmp_path / "out" / "report.html").exists(), done.stderr[-2000:]


@pytest.mark.parametrize("name", SURFACES)
def test_a_surface_is_taken_and_its_repair_reported(
    name: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    folder, says = surfaces(tmp_path / "stl"), SURFACES[name][1]
    with caplog.at_level("WARNING"):
        made = Wall(name="cup", stl=f"{name}.stl", stl_unit="m" if name == "v_in_metres" else "mm").surface(folder)
    assert len(made.triangles) >= 12
    assert (says in caplog.text) if says else not caplog.text


@pytest.mark.parametrize(("height_mm", "taken"), [(22.0, True), (10.0, True), (2.5, False)])
def test_a_sphere_may_begin_above_a_hollow_body_and_in_its_cavity(
    height_mm: float, taken: bool, tmp_path: Path
) -> None:
    """Not in the body itself."""
    entry = {"name": "bead", "material": "glass", "diameter_mm": 3, "at_mm": [(0.0, 0.0, height_mm)]}
    wall = [{"name": "box", "stl": "x_hollow_closed.stl"}]
    building = Building(Scene(**beads(spheres=[entry], walls=wall), folder=surfaces(tmp_path / "stl")))
    if taken:
        assert sum(c.count for c in building.scene().classes) == 1
        return
    with raises_code("scene.in_wall"):
        building.scene()


@pytest.mark.parametrize("name", ELSEWHERE)
def test_the_others_are_rows_elsewhere(name: str) -> None:
    file, _, what = ELSEWHERE[name].partition(": ")
    content = (TESTS / file).read_text()
    if file.endswith(".py"):
        assert what in {node.name for node in ast.parse(content).body if isinstance(node, ast.FunctionDef)}
    else:
        assert what in {row["name"] for row in yaml.safe_load(content)}


@pytest.mark.engine
def test_ids_below_one_end_before_the_plugin_takes_them_for_indices(tmp_path: Path) -> None:
    """Number 13 as it was found: a run directory of somebody else's, simulated."""
    beds.prepare(tmp_path, beds.bed((3, 3, 2)), steps=50, outputs=2)
    path = tmp_path / "history" / "spheres.parquet"
    table = pd.read_parquet(path)
    table.assign(id=-table["id"]).to_parquet(path)
    with raises_code("run.history", key="spheres"):
        driver.run(tmp_path, 1, progress=False)
