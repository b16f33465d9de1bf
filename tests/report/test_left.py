"""Curves next to moving pictures of a scene without a collecting bin: what has left by each product, or none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from pywet.products import screening_report, streams
from pywet.report import browser, caption, movie, page
from pywet.runs.rundir import RunDir
from pywet.util.files import write_table
from reference_impl.shown import scenes
from tests.products import made_up

TITLES = ["overs, share of the feed", "unders, share of the feed"]


@pytest.fixture(scope="module", params=[2000, 1000])
def deck(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A deck on which overs and unders leave, run to the end of its feed or only half as long."""
    folder = made_up.make(tmp_path_factory.mktemp("left") / "deck", steps=request.param)
    places = pd.read_parquet(folder / "trajectory.parquet")
    write_table(places.assign(x=1e-3 * places["id"]), folder / "trajectory.parquet")
    write_table(pd.DataFrame(columns=["step", "mesh", "dx", "dy", "dz"]), folder / "mesh_motion.parquet")
    return folder


@pytest.fixture
def closed(deck: Path, tmp_path: Path) -> Path:
    """The same without outlets."""
    folder = tmp_path / "closed"
    folder.mkdir()
    for name in ("trajectory.parquet", "mesh_motion.parquet", "history"):
        (folder / name).symlink_to(deck / name)
    scene = json.loads((deck / "scene.json").read_text())
    (folder / "scene.json").write_text(json.dumps({**scene, "outlets": []}))
    return folder


def test_curves_are_what_left_over_what_entered(deck: Path) -> None:
    """Of the mass that has entered until each output, as the series of the screen has it: in the machine, overs and unders."""
    run = RunDir(deck)
    series = screening_report.time_series(run, streams.read(run, 0.2))
    feed = series[["hold_up_kg", "overs_kg", "unders_kg"]].sum(axis=1)
    curves = browser._curves(run)
    assert [c["quantity"] for c in curves] == ["left_overs", "left_unders"]
    assert [c["title"] for c in curves] == TITLES
    for curve, product in zip(curves, ("overs", "unders"), strict=True):
        expected = (series[f"{product}_kg"] / feed).where(feed > 0, 0.0)
        assert curve["y"] == pytest.approx(expected.tolist(), rel=1e-12) and 0.1 < curve["y"][-1] < 0.9


def test_outlets_without_a_product_are_called_by_their_name(deck: Path, tmp_path: Path) -> None:
    """Two outlets of one product are one curve."""
    scene = json.loads((deck / "scene.json").read_text())
    for name in ("trajectory.parquet", "history"):
        (tmp_path / name).symlink_to(deck / name)
    found = []
    for outlets in ([("far_edge", None), ("tray", None)], [("a", "unders"), ("b", "unders")]):
        for given, (name, product) in zip(scene["outlets"], outlets, strict=True):
            given |= {"name": name, "product": product}
        (tmp_path / "scene.json").write_text(json.dumps(scene))
        found.append(caption.curves(RunDir(tmp_path)))
    assert [c.title for c in found[0]] == ["far edge, share of the feed", "tray, share of the feed"]
    (both,) = found[1]
    assert both.values == pytest.approx(found[0][0].values + found[0][1].values, rel=1e-12)


def test_without_bin_and_outlets_there_is_no_curve(closed: Path) -> None:
    run = RunDir(closed)
    assert caption.curves(run) == [] and browser._curves(run) == []
    assert "retained" not in caption.sentence(run, 0)


def test_the_reference_reads_the_same_curves(deck: Path, closed: Path) -> None:
    """And objects to a share of what was planned, to one that is 1 % high, and to a fraction retained."""
    for folder in (deck, closed):
        text = browser.element([(folder.name, RunDir(folder))])
        assert scenes.check(text, folder.parent)[1] == []
    right = scenes.SCENE.findall(browser.element([(deck.name, RunDir(deck))]))[0][1]

    def wrong(change: Any) -> list[str]:
        head = json.loads(right)
        change(head["curves"])
        text = f'<script type="application/json" class="run" data-name="{deck.name}">{json.dumps(head)}</script>'
        return scenes.check(text, deck.parent)[1]

    name = f"scene of {deck.name}: "
    for k, product in enumerate(("overs", "unders")):
        (sentence,) = wrong(lambda curves, k=k: curves[k].update(y=[1.01 * y for y in curves[k]["y"]]))
        assert sentence.startswith(f"{name}the curve left_{product} is wrong")
    (sentence,) = wrong(lambda curves: curves[0].update(quantity="fraction_retained_spheres"))
    assert sentence.startswith(
        f"{name}curves are of ['fraction_retained_spheres', 'left_unders']; expected ['left_overs'"
    )


def test_the_chart_of_a_movie_has_a_dot_for_each_product() -> None:
    """Half of the time, a quarter and a half: on axes from (40, 420) to (206, 60), below two titles."""
    curves = [
        caption.Curve("left_a", "a", np.array([0.0, 0.25, 1.0])),
        caption.Curve("left_b", "b", np.array([0, 0.5, 0])),
    ]
    pixels = movie.chart(np.array([0.0, 1.0, 2.0]), curves, 1)
    rows, columns = np.nonzero((pixels == (0xD9, 0x80, 0x32)).all(axis=2))
    for share, those in ((0.25, rows > 300), (0.5, rows <= 300)):
        middle = ((40 + 206) / 2, 420 - share * 360)
        assert (columns[those].mean(), rows[those].mean()) == pytest.approx(middle, abs=1.0)
    for line in movie.LINES[:2]:
        of_line = (pixels == [int(line[k : k + 2], 16) for k in (1, 3, 5)]).all(axis=2)
        assert of_line[:44].any() and of_line[60:420].any()  # title and curve


def test_a_movie_without_curves_has_only_the_scene(
    deck: Path, closed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blank = np.full((movie.SIZE[1], movie.SIZE[0], 3), 255, dtype=np.uint8)
    monkeypatch.setattr(movie.render, "view", lambda *_: None)
    monkeypatch.setattr(movie.render, "scene", lambda *_, **__: (blank, 1.0))
    for folder, width in ((deck, movie.SIZE[0] + movie.CHART), (closed, movie.SIZE[0])):
        movie.draw(RunDir(folder), 1, tmp_path)
        with Image.open(tmp_path / "00000.png") as frame:
            assert frame.width == width


def test_a_browser_titles_the_curves(deck: Path, closed: Path, tmp_path: Path, tab: Any) -> None:
    """One chart for each product; of a run with neither bin nor outlets none."""
    for folder, titles in ((deck, TITLES), (closed, [])):
        file = page.write(
            tmp_path / f"{folder.name}.html", "S", "", [page.Section("S", browser.element([("a", RunDir(folder))]))]
        )
        tab.goto(file.as_uri())
        tab.wait_for_selector(".viewer[data-ready]")
        assert [chart.get_attribute("aria-label") for chart in tab.locator(".charts svg").all()] == [
            f"{title} over time" for title in titles
        ]
        assert {*tab.messages} <= {file.as_uri()}
