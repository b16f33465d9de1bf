"""A run that ends before all its spheres have entered: shares and counts are of those that have."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from pywet.cases.custom import results
from pywet.cli import ending
from pywet.products import screening_report
from pywet.report import bands, page, scene_page, screen_page
from pywet.runs.loaded import Run
from pywet.runs.rundir import RunDir
from pywet.schema import TABLES
from pywet.util.files import write_table
from reference_impl.replay import io
from reference_impl.tables import any_scene, check, plant, summary
from tests.products import made_up
from tests.products.test_screen import MASS

CAME = np.array([20, 20, 20, 0])
"""Spheres of each size that have entered by 1 s: half of three sizes; the fourth, and largest, is to come later."""
FILMS = made_up.FILM * np.array([1, 2, 3, 4])


@pytest.fixture(scope="module")
def early(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = made_up.make(tmp_path_factory.mktemp("early"), steps=1000)
    scene = json.loads((folder / "scene.json").read_text())
    scene["classes"][3]["insertion"]["from_s"] = 1.5
    (folder / "scene.json").write_text(json.dumps(scene))
    for name in ("trajectory", "history/retired"):  # of the fourth size the engine has none yet
        table = pd.read_parquet(folder / f"{name}.parquet")
        if name == "trajectory":
            table["z"] = -0.2 * (table["step"] > 500)  # below the screen's plane in the second half
        else:
            table = table[table["type"] < 4]
        write_table(table, folder / f"{name}.parquet")
    write_table(pd.DataFrame(columns=[*TABLES["mesh_motion"]]), folder / "mesh_motion.parquet")
    results.write(folder)
    return folder


def objections(folder: Path) -> list[str]:
    """What the reference says of the summary and the numbers of the screen."""
    scene, given = io.scene(folder), json.loads((folder / "summary.json").read_text())
    mine = any_scene.tables(folder, scene)
    screen = json.loads((folder / "results" / "screen.json").read_text())
    rows = [
        *summary.held(given, mine, scene, folder),
        *plant.held(folder, scene, plant.Deck.read(folder, scene, screen)),
    ]
    return [h.name for h in rows if h.wrong]


def test_the_summary_is_of_the_spheres_that_have_entered(early: Path) -> None:
    """Numbers, mass, liquid and the sentence on lost spheres; the reference finds the same, and objects to planned ones."""
    found = json.loads((early / "summary.json").read_text())
    assert list(found["spheres"].values()) == CAME.tolist()
    assert found["mass_kg"] == pytest.approx((CAME * MASS).sum(), rel=1e-12)
    assert found["initial_liquid_m3"] == pytest.approx((CAME * FILMS).sum(), rel=1e-12)
    assert found["checks"][0]["text"].startswith("60 spheres in")
    assert objections(early) == []
    assert all(q.ok for q in check.check(early).quantities)


def test_the_reference_objects_to_planned_spheres(early: Path, tmp_path: Path) -> None:
    for name in ("scene.json", "trajectory.parquet", "history", "results", "summary.json"):
        (tmp_path / name).symlink_to(early / name)
    (tmp_path / "summary.json").unlink()
    given = json.loads((early / "summary.json").read_text())
    planned = np.full(4, made_up.EACH)
    given |= {"mass_kg": float((planned * MASS).sum()), "initial_liquid_m3": float((planned * FILMS).sum())}
    given["spheres"] = dict.fromkeys(given["spheres"], made_up.EACH)
    (tmp_path / "summary.json").write_text(json.dumps(given))
    wrong = {name.removeprefix("summary.json: ") for name in objections(tmp_path)}
    assert wrong >= {"mass_kg", "initial_liquid_m3", *(f"spheres.{name}" for name in given["spheres"])}


def test_liquid_not_accounted_for_is_a_share_of_what_was_put_in(early: Path) -> None:
    """A tenth of what has entered, whatever was planned."""
    run = RunDir(early)
    liquid = results.liquid_by_wall(run)
    missing = liquid.assign(total_m3=liquid["total_m3"] - 0.1 * (CAME * FILMS).sum())
    assert results.checks(run, missing)[1].value == pytest.approx(0.1, rel=1e-9)
    mine = any_scene.accounted(missing, any_scene.tables(early, io.scene(early)).initial)
    assert mine == pytest.approx(0.1, rel=1e-9)


def test_printed_shares_of_liquid_add_up(early: Path) -> None:
    """3 of 20 spheres of each of three sizes are inside, at the end of the run: together with the products all of it."""
    (line,) = ending._liquid([RunDir(early)])
    shares = [float(part.split(" %")[0]) for part in line.removeprefix("liquid at the end: ").split(", ")]
    assert sum(shares) == pytest.approx(100.0, abs=0.6), line


def test_moisture_of_the_feed_is_that_of_what_entered(early: Path) -> None:
    found = screening_report.analyse(early)[0]
    liquid = RunDir(early).scene.liquid
    assert liquid is not None
    expected = 100.0 * liquid.density_kg_per_m3 * (CAME * FILMS).sum() / (CAME * MASS).sum()
    assert found["feed_moisture_percent"] == pytest.approx(expected, rel=1e-12)


def test_passage_is_a_share_of_what_entered(early: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The spheres that are below the plane are over the 20 that entered; those that wait below it have not passed."""
    drawn: list[Figure] = []
    monkeypatch.setattr(page, "curves", lambda figure, *_: drawn.append(figure) or "")
    run = RunDir(early)
    screen_page._passage(run, screening_report.analyse(early)[0])
    passed = screen_page.crossings(run).groupby("type").size()
    assert 4 not in passed.index
    for line, kind in zip(drawn[0].axes[0].lines, (1, 2, 3, 4), strict=True):
        assert sum(line.get_ydata()) == pytest.approx(passed.get(kind, 0) / 20)
    assert Run(early).discharge(-0.1)["passed_kg"].iloc[-1] == pytest.approx(
        sum(MASS[kind - 1] * n for kind, n in passed.items()), rel=1e-12
    )


def test_the_label_of_a_group_has_the_moisture_of_what_entered(early: Path) -> None:
    """100 % times liquid over mass of the 60 spheres, from the ledger's last line; 0 % of a dry run."""
    run, last = RunDir(early), {"step": [0, 1000], "initial": [0.0, (CAME * FILMS).sum()]}
    moist: Any = SimpleNamespace(
        scene=run.scene, moist=True, ledger=pd.DataFrame(last), spheres=run.spheres, enters=run.enters
    )
    assert run.scene.liquid is not None
    expected = 100.0 * run.scene.liquid.density_kg_per_m3 * (CAME * FILMS).sum() / (CAME * MASS).sum()
    assert bands._percent(moist) == f"{expected:.3g} %" and bands._percent(run) == "0 %"


def test_the_page_says_that_not_all_have_entered(early: Path) -> None:
    run = Run(early)
    row = {"name": "a", "count": 40, "asked_kg": 1.0, "made_kg": 1.0}
    run.summary["amounts"] = [row]
    (section,) = scene_page._sizes(run)
    assert "The run ended after 60 of the 160 spheres had entered." in section.body
