"""The 3-D scene of a page: its numbers against the logs, and what a real browser shows of them."""

from __future__ import annotations

import base64
import html
import io
import json
import re
import zlib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from pywet import config as settings
from pywet.cases.screening.verdict import Agreement
from pywet.report import browser, page, pictures, report
from pywet.report.collect import CaseResult
from pywet.report.report_numbers import collected
from pywet.runs.rundir import RunDir
from pywet.runs.walls import wall_corners
from pywet.scene import SCRIPTED
from pywet.util.files import read_table
from tests.cases.screening import synthetic

ROOT = Path(__file__).parents[2]


def unpacked(run: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The header, and the arrays as a page has them."""
    head = json.loads(browser.packed(RunDir(run)))
    blob = zlib.decompress(base64.b64decode(head["data"]))
    kinds = {"Int32Array": "<i4", "Int16Array": "<i2", "Uint16Array": "<u2", "Uint8Array": "u1", "Float32Array": "<f4"}
    return head, {n: np.frombuffer(blob, kinds[k], count, start) for n, (k, start, count) in head["arrays"].items()}


def test_places_and_films_are_those_of_the_logs(run: Path) -> None:
    """To a part in 65534 of the scene's size and of the thickest film; h from (3L/4π + r³)^(1/3) - r with L in 1e-9 m³."""
    head, arrays = unpacked(run)
    table = read_table(run / "trajectory.parquet").sort_values(["step", "id"])
    places = head["origin"] + head["quantum"] * arrays["place"].reshape(-1, 3)
    assert np.abs(places - table[["x", "y", "z"]].to_numpy()).max() <= head["quantum"]
    assert head["quantum"] == pytest.approx(0.08 / 65534, rel=1e-6)  # from the bin at -0.06 m to a sphere at 0.02 m
    films = arrays["film"].reshape(3, 3) * head["film_most"] / 65535
    liquid, radius = np.array([7.5e-9, 5e-9, 4e-9]), np.array([4e-3, 2e-3, 2e-3])
    assert films[2] == pytest.approx(np.cbrt(0.75 * liquid / np.pi + radius**3) - radius, abs=head["film_most"] / 65535)
    assert head["times"] == pytest.approx([0.0, 0.01, 0.02])


def test_bridges_join_the_surfaces_of_their_bodies(run: Path) -> None:
    """None at the first two times; then one between spheres 1 and 3, and one between sphere 1 and the wire."""
    head, arrays = unpacked(run)
    assert head["starts"] == [0, 0, 0, 2]
    assert list(zip(arrays["i"], arrays["j"], strict=True)) == [(0, 2), (0, -2)]
    ends = [head["origin"] + head["quantum"] * arrays[name].reshape(-1, 3) for name in ("from", "to")]
    centres = np.array([[-0.006, 0.0, 0.006], [0.006, 0.0, -0.05]])
    # a cuboid begins where its edges meet the sphere: at sqrt(r² - s²/2) from the centre
    depth = np.sqrt(np.array([4e-3, 2e-3]) ** 2 - arrays["side"][0] ** 2 / 2.0)
    assert np.linalg.norm(ends[0][0] - centres[0]) == pytest.approx(depth[0], abs=2 * head["quantum"])
    assert (arrays["side"] > 0).all()


def test_walls_are_where_their_motion_says(run: Path) -> None:
    """Three rows of four numbers a time: the wires rise by a millimetre from output to output, the bin stays."""
    head, _ = unpacked(run)
    wires, _, collecting_bin = [np.array(mesh["moved"]).reshape(3, 3, 4) for mesh in head["meshes"]]
    assert (wires[..., :3] == np.eye(3)).all() and (collecting_bin[..., 3] == 0).all()
    assert wires[:, :, 3] == pytest.approx(np.outer([0, 1e-3, 2e-3], [0, 0, 1]))


def test_meshes_of_a_script_are_where_the_engine_turned_them(run: Path) -> None:
    """The side wall turns by 45° from output to output about a vertical axis through x = 10 mm, the wires rise by 1 mm."""
    scene = json.loads((run / "scene.json").read_text())
    walls = [{**wall, "motion": "fixed"} for wall in scene["walls"]]
    (run / "scene.json").write_text(json.dumps({**scene, "name": SCRIPTED, "slide": None, "walls": walls}))
    spheres = pd.read_parquet(run / "history" / "spheres.parquet")
    spheres.assign(enters=0).to_parquet(run / "history" / "spheres.parquet")
    axis, rows = np.array([0.01, 0.0, 0.0]), []
    for k, step in enumerate(synthetic.STEPS):
        cosine, sine = np.cos(np.pi / 4 * k), np.sin(np.pi / 4 * k)
        turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        for mesh, (r, shift) in enumerate(
            [(np.eye(3), [0, 0, 1e-3 * k]), (turn, axis - turn @ axis), (np.eye(3), np.zeros(3))]
        ):
            rows.append([step, mesh, *shift, *r.ravel()])
    names = [f"{of}_{a}" for of in ("shift", "turn_0", "turn_1", "turn_2") for a in "xyz"]
    poses = pd.DataFrame(rows, columns=["step", "mesh", *names])
    poses.assign(**{f"{of}_{a}": 0.0 for of in ("velocity", "spin") for a in "xyz"}).to_parquet(
        run / "history" / "poses.parquet"
    )
    head, arrays = unpacked(run)
    rest = head["origin"] + head["quantum"] * arrays["corners"].reshape(-1, 3)
    wires, side, _ = (np.reshape(mesh["moved"][2], (3, 4)) for mesh in head["meshes"])
    x, y, z = (rest - axis).T  # by 90°: x becomes y, y becomes -x
    assert rest @ side[:, :3].T + side[:, 3] == pytest.approx(axis + np.column_stack([-y, x, z]), abs=1e-9)
    assert rest @ wires[:, :3].T + wires[:, 3] == pytest.approx(rest + np.array([0.0, 0.0, 2e-3]), abs=1e-9)
    assert wall_corners(RunDir(run), 200)[2:4].reshape(-1, 3) == pytest.approx(
        (axis + np.column_stack([-y, x, z]))[6:12], abs=2 * head["quantum"]
    )


def test_a_class_has_one_colour_in_all_runs_of_a_page(run: Path, tmp_path: Path) -> None:
    """Eight classes in one run, other ones in the next: all names have a colour of their own."""
    runs = [RunDir(run), RunDir(synthetic.make(tmp_path / "other"))]
    of = runs[0].scene.classes[0]
    runs[0].scene.__dict__["classes"] = (
        *runs[0].scene.classes,
        *(of.model_copy(update={"name": f"{k}"}) for k in range(6)),
    )
    runs[1].scene.__dict__["classes"] = tuple(
        c.model_copy(update={"name": f"<{c.name}"}) for c in runs[1].scene.classes
    )
    text = browser.element([(str(k), one) for k, one in enumerate(runs)])
    (found,) = re.findall(r'data-classes="(.*?)"', text)
    colours = json.loads(html.unescape(found))
    assert set(colours) == {c.name for one in runs for c in one.scene.classes}
    assert len(set(colours.values())) == len(colours) == 10


def test_a_run_that_is_too_large_is_shown_at_fewer_times(run: Path) -> None:
    whole = browser.packed(RunDir(run))
    fewer = json.loads(browser.packed(RunDir(run), len(whole) - 1))
    assert fewer["times"] == pytest.approx([0.0, 0.02])


def test_what_a_run_is_called_cannot_end_its_script(run: Path) -> None:
    scene = json.loads((run / "scene.json").read_text())
    scene["classes"][0]["name"] = "</script><script>alert(1)"
    (run / "scene.json").write_text(json.dumps(scene))
    text = browser.element([('"><b>', RunDir(run))])
    assert text.count("</script>") == 3 and "<b>" not in text


@pytest.fixture
def shown(run: Path, tab: Any) -> Any:
    """The run in a tab."""
    scene = browser.element([("moist", RunDir(run)), ("again", RunDir(run))])
    file = page.write(run / "scene.html", "Scene", "", [page.Section("Scene", scene)])
    tab.goto(file.as_uri())
    tab.wait_for_selector(".viewer[data-ready]")
    return tab


def at(tab: Any, index: int) -> None:
    """Move the slider as a person's keys do."""
    tab.focus(".time")
    tab.keyboard.press("Home")
    for _ in range(index):
        tab.keyboard.press("ArrowRight")


def picture(tab: Any) -> Any:
    """Pixels of the canvas after the next picture is drawn."""
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return np.asarray(Image.open(io.BytesIO(tab.locator("canvas").first.screenshot())).convert("RGB"), dtype=int)


def test_a_browser_shows_the_scene_and_the_slider_moves_it(shown: Any) -> None:
    """Sphere 3 leaves the place above the screen after the second output: there is ground where it was seen."""
    at(shown, 1)
    assert shown.inner_text(".clock") == "t = 0.010 s"
    x, y = (round(v) for v in shown.evaluate("document.querySelector('.viewer').panels[0].where(2)"))
    before = picture(shown)
    at(shown, 2)
    assert shown.inner_text(".clock") == "t = 0.020 s"
    after = picture(shown)
    blue, ground = before[y, x], after[y, x]
    assert blue[2] - blue[0] > 40 > abs(ground[2] - ground[0])
    shown.select_option(".by", "class")
    assert "POM 8 mm" in shown.inner_text(".legend")
    assert shown.messages == []


def seen_at(camera: dict[str, Any], size: list[float], places: np.ndarray) -> np.ndarray:
    """Pixels of points, by an upright pinhole camera: x to the right, y down."""
    away = np.array(camera["target"]) - camera["position"]
    away /= np.linalg.norm(away)
    right = np.cross(away, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    d = places - camera["position"]
    focus = 0.5 * size[1] / np.tan(np.radians(camera["fov"]) / 2.0)
    across, up, depth = d @ right, d @ np.cross(right, away), d @ away
    return np.array([0.5 * size[0] + focus * across / depth, 0.5 * size[1] - focus * up / depth]).T


def test_spheres_are_drawn_where_the_logs_say(run: Path, tab: Any) -> None:
    """Of a scene that no mirror leaves as it is: matrices of all spheres at all outputs, their pixels and their colours."""
    path = run / "trajectory.parquet"
    table = pd.read_parquet(path).sort_values(["step", "id"])
    table.assign(y=2e-3 * table["id"] ** 2 - 7e-3).to_parquet(path)
    table = pd.read_parquet(path)
    file = page.write(run / "s.html", "S", "", [page.Section("S", browser.element([("moist", RunDir(run))]))])
    tab.goto(file.as_uri())
    tab.wait_for_selector(".viewer[data-ready]")
    tab.select_option(".by", "class")
    tab.uncheck(".walls")
    for k, step in enumerate(sorted(table["step"].unique())):
        at(tab, k)
        matrices = np.array(tab.evaluate(f"[...{PANEL}.spheres.instanceMatrix.array]")).reshape(-1, 4, 4)
        places = table.loc[table["step"] == step, ["x", "y", "z"]].to_numpy()
        assert np.abs(matrices[: len(places), 3, :3] - places).max() < 3e-6
        camera = tab.evaluate(
            f"(({{camera, controls}}) => ({{position: camera.position.toArray(),"
            f" target: controls.target.toArray(), fov: camera.fov}}))({PANEL})"
        )
        size = tab.evaluate(f"[{PANEL}.canvas.clientWidth, {PANEL}.canvas.clientHeight]")
        pixels, shown = seen_at(camera, size, places), picture(tab)
        assert [tab.evaluate(f"{PANEL}.where({n})") for n in range(3)] == [pytest.approx(p, abs=0.6) for p in pixels]
        inside = [(y, x) for x, y in pixels.round().astype(int)]
        warm = [
            int(shown[p][0] - shown[p][2]) for p in inside if 0 <= p[0] < shown.shape[0] and 0 <= p[1] < shown.shape[1]
        ]
        assert warm[0] > 40 and all(
            w < -40 for w in warm[1:]
        )  # the class of sphere 1 is ochre, that of the others blue


def test_pointing_at_a_sphere_says_what_it_is(shown: Any) -> None:
    """h of 7.5e-9 m³ on 4 mm is 37.0 µm; the bridges of the last output are two, to sphere 3 and to a wire."""
    at(shown, 2)
    x, y = shown.evaluate("document.querySelector('.viewer').panels[0].where(0)")
    shown.locator("canvas").first.hover(position={"x": x, "y": y})
    output_text = shown.inner_text(".tip")
    assert output_text == "sphere 1: POM 8 mm, 8.00 mm; film 37.0 µm; 0.10 m/s; 2 bridges to 3, wire"
    shown.locator("canvas").first.hover(position={"x": 3, "y": 3})
    assert not shown.is_visible(".tip")


def test_bridges_can_be_left_out_and_the_scene_turned(shown: Any) -> None:
    at(shown, 2)
    shown.uncheck(".walls")  # the plate drawn for the wires hides the bridge below the sphere
    with_bridges = picture(shown)
    shown.uncheck(".bridges")
    orange = [(pixels[..., 0] - pixels[..., 2] > 30).sum() for pixels in (with_bridges, picture(shown))]
    assert orange[0] > 20 and orange[1] == 0
    where = "document.querySelector('.viewer').panels[0].where(0)"
    before = shown.evaluate(where)
    box = shown.locator("canvas").first.bounding_box()
    shown.mouse.move(box["x"] + 200, box["y"] + 200)
    shown.mouse.down()
    shown.mouse.move(box["x"] + 320, box["y"] + 200)
    shown.mouse.up()
    assert shown.evaluate(where) != pytest.approx(before, abs=5)
    shown.click(".reset")
    assert shown.evaluate(where) == pytest.approx(before, abs=0.5)


PANEL = "document.querySelector('.viewer').panels[0]"


def test_walls_in_front_do_not_wash_out_spheres(shown: Any) -> None:
    """Seen from below, sphere 1 is behind the translucent plane of the side walls: its colour is that without walls."""
    shown.evaluate(f"{PANEL}.camera.position.set(0.01, -0.05, -0.09), {PANEL}.controls.update()")
    x, y = (round(v) for v in shown.evaluate(f"{PANEL}.where(0)"))
    seen = []
    for visible in ("true", "false"):
        shown.evaluate(
            f"{PANEL}.walls.children.forEach((wall, k) => (wall.visible = k === 1 && {visible})), {PANEL}.draw()"
        )
        seen.append(picture(shown))
    assert seen[1][y, x, 2] - seen[1][y, x, 0] > 20
    assert np.abs(seen[0] - seen[1]).max() > 5  # the wall is drawn
    assert np.abs(seen[0] - seen[1])[y, x].max() <= 2


def test_small_curves_have_ticks(shown: Any) -> None:
    """Fraction retained from 0 to 1 in fifths, time to 0.02 s in steps of 0.005 s."""
    output_text = shown.locator(".charts svg").first.locator("text").all_text_contents()
    assert [t for t in ("0.2", "0.4", "0.6", "0.8", "1") if t not in output_text] == []
    assert [t for t in ("0.005", "0.01", "0.015", "0.02", "time in s") if t not in output_text] == []


def test_curves_are_saved_as_csv_and_svg(tmp_path: Path, tab: Any) -> None:
    """Two curves of two points: a head and four rows, quoted names; the drawing is whole by itself. No network is asked."""
    figure, axes = pictures.plt.subplots()
    axes.plot([0.0, 1.0], [1.0, 0.25], label='M = 5 %, "near"')
    axes.plot([0.0, 1.0], [1.0, 0.5], label="dry")
    axes.set_ylabel("fraction retained")
    axes.legend()
    file = page.write(tmp_path / "p.html", "P", "", [page.Section("Curve", page.curves(figure, "one"))])
    tab.goto(file.as_uri())
    saved = {}
    for end in ("csv", "svg"):
        link = tab.locator(f"a[download='fraction_retained.{end}']")
        with tab.expect_download() as download:
            link.click()
        saved[end] = Path(download.value.path()).read_text()
    table = pd.read_csv(io.StringIO(saved["csv"]))
    assert table["label"].tolist() == ['M = 5 %, "near"'] * 2 + ["dry"] * 2
    assert table["y"].tolist() == [1.0, 0.25, 1.0, 0.5] and table["x"].tolist() == [0.0, 1.0] * 2
    drawn = ElementTree.fromstring(saved["svg"])
    assert drawn.tag == "{http://www.w3.org/2000/svg}svg" and "dry" in "".join(drawn.itertext())
    assert [output_text for output_text in tab.messages if not output_text.startswith("data:")] == []


def test_tables_of_eighteen_cases_fit_the_page(tmp_path: Path, tab: Any) -> None:
    """At a width of 1280 pixels no table of effects or of the cross-check is cut off at its right."""
    quantity = "capillary force at touch / weight (1/Bond number)"
    row = {"effect": "viscous tangential", "on": True, "number": 0.0654, "threshold": 0.01, "quantity": quantity}
    compared = Agreement("contact_tangential_torque", "largest of the step", 3, 2.5e-13, 1.1e-16, 1e-9)
    config = settings.load(ROOT / "config")
    plan = {"rows": [{**row, "why": "", "law": None}]}
    results = [CaseResult(case, (), plan=plan, agreement=(compared,)) for case in config.cases.values()]
    out = tmp_path / "report.html"
    report._render("full", results, collected(results, config, "full"), ROOT / "workflow" / "report", None, out)
    tab.set_viewport_size({"width": 1280, "height": 900})
    tab.goto(out.as_uri())
    tab.evaluate("document.querySelectorAll('details').forEach((part) => (part.open = true))")
    sizes = tab.evaluate(
        "[...document.querySelectorAll('#effects .scroll, #agreement .scroll')].map((s) => [s.scrollWidth, s.clientWidth])"
    )
    assert len(sizes) == 2 + 3 and all(inner <= outer for inner, outer in sizes), sizes


def test_the_library_names_no_place_in_a_network() -> None:
    text = (Path(browser.__file__).parent / "three.min.js").read_text()
    assert set(re.findall(r"https?://[\w./-]+", text)) <= {"http://www.w3.org/1999/xhtml"}  # XML namespace of HTML
    assert "MIT License" in text[:200]
