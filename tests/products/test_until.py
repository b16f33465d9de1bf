"""Runs that end when their partition is known: interval in closed form, blocks, kills, what the replay finds."""

from __future__ import annotations

import json
import math
import shutil
from itertools import pairwise
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from scipy import stats

import pywet
from pywet import scene_stages
from pywet.cases.custom import building
from pywet.cli import scene_check
from pywet.engines import run_store, schedule
from pywet.engines.liggghts import driver, process
from pywet.products import screening_report, until
from pywet.products.partition import wilson
from pywet.report import screen_page
from pywet.runs.rundir import RunDir
from pywet.scene import EngineScene
from pywet.util.files import write_json
from reference_impl.replay import io, plans
from reference_impl.tables import known as known_accuracy
from tests.error_codes import raises_code
from tests.products import made_up
from tests.products.test_outlets import scene
from tests.reliability.kills import Stopped, assert_same, tables_of

ASKED = {"partition_percent": 12, "block_s": 0.06, "least_blocks": 5, "least_spheres": 10, "from_s": 0.1}
BEADS = {
    "name": "beads", "material": "glass", "diameter_mm": 3, "count": 140, "velocity_m_per_s": (0, 0, -0.3),
    "box": {"low_mm": (-8, -8, 20), "high_mm": (8, 8, 26)}, "insertion": {"from_s": 0.0, "for_s": 0.72},
}  # fmt: skip
OUTLETS = [
    {"name": "edge", "product": "overs", "low_mm": (-4, None, None), "high_mm": (-1, None, 3)},
    {"name": "under", "product": "unders", "high_mm": (None, None, -20)},
]


def known(asked: dict[str, Any] | None = None, **changes: Any) -> pywet.Scene:
    """Moist beads that enter for 0.72 s, of which some leave at the end of a plate and the others fall."""
    given = {
        "duration_s": 0.72, "spheres": [BEADS], "outlets": OUTLETS, "until": {**ASKED, **(asked or {})},
        "results": {"interval_s": 0.02, "windows": 12},
    }  # fmt: skip
    return scene(**{**given, **changes})


def test_a_check_is_of_the_longest_run() -> None:
    """0.72 s, twelve blocks, in steps as in time; without `until` the steps are those of the run."""
    whole, made = known(), building.Building(known())
    assert made.scene().steps < round(0.72 / made.time_step)
    first, time, *_ = scene_check.lines(whole)
    assert f": 140 spheres, at most {round(0.72 / made.time_step)} steps of" in first and "predicted at most " in time
    first, time, *_ = scene_check.lines(whole.with_(until=None))
    assert f": 140 spheres, {round(0.72 / made.time_step)} steps of" in first and "at most" not in time


OVERS = (2, 4, 3, 0, 1, 2)
"""Of four spheres of 2 mm in each of six blocks."""


def test_the_interval_is_that_of_the_blocks() -> None:
    """T = 12/24; deviations of overs from T times feed: Student's t over the root of six blocks; of 1 mm none leaves as overs."""
    whole = made_up.scene(1200).model_copy(update={"blocks": 6})
    kind, outlet, step = [], [], []
    for k, overs in enumerate(OVERS):
        kind += [2] * 4 + [1] * 4
        outlet += [1] * overs + [2] * (8 - overs)
        step += [200 * (k + 1)] * 8  # the last step of a block belongs to it
    spheres = pd.DataFrame({"id": range(1, 49), "type": kind})
    gone = spheres.assign(outlet=outlet, step=step, time=made_up.STEP * pd.Series(step), film=0.0)
    asked = until.Until(partition_percent=40, least_blocks=5, least_spheres=10, from_s=0.0)
    found = until.assess(whole, spheres, gone, asked)
    fine, coarse = found["sizes"]
    assert (fine["T"], fine["spheres"], coarse["spheres"]) == (0.0, 24, 24) and coarse["T"] == pytest.approx(0.5)
    low, high = wilson(0, 24)
    assert fine["half_width"] == pytest.approx(0.5 * (high - low))
    spread = math.sqrt(sum((n - 2) ** 2 for n in OVERS) / 5 / 6) / 4
    assert coarse["half_width"] == pytest.approx(stats.t.ppf(0.975, 5) * spread, rel=1e-12)
    assert found["reached"] and found["counted_blocks"] == 6
    later = until.assess(whole, spheres, gone, asked.model_copy(update={"from_s": 0.25}))
    assert later["counted_blocks"] == 4 and later["from_s"] == pytest.approx(0.4) and not later["reached"]
    assert not until.assess(whole, spheres, gone, asked.model_copy(update={"least_spheres": 25}))["reached"]


def test_the_partition_curve_is_that_of_the_blocks(tmp_path: Path) -> None:
    """From `from_s` on, rounded up to a block, T of each size is that of the screen and its page: of masses, where two classes
    of one size differ in density. The reference finds the same numbers."""
    run, whole = made_up.make(tmp_path), made_up.scene()
    one, two, three, four = whole.classes
    heavy = three.model_copy(update={"radius_m": two.radius_m, "density_kg_per_m3": 2.0 * two.density_kg_per_m3})
    whole = whole.model_copy(update={"blocks": 10, "classes": (one, two, heavy, four)})
    write_json(run / "scene.json", whole.model_dump(mode="json"))
    asked = until.Until(partition_percent=40, least_spheres=10, from_s=0.5)
    write_json(run / "description.json", {"until": asked.model_dump(mode="json")})
    found, numbers = until.write(RunDir(run)), screening_report.write(run)
    curve = RunDir(run).table("results/partition")
    assert numbers["from_s"] == found["from_s"] == pytest.approx(0.6) and numbers["steady"]
    assert [s["T"] for s in found["sizes"]] == pytest.approx(curve["T"].tolist(), rel=1e-12)
    assert curve["T"].iloc[1] > 0.55  # a quarter of the light and three of the heavy spheres
    assert sum(s["spheres"] for s in found["sizes"]) == sum(numbers["spheres"].values())
    assert screen_page._more(RunDir(run), numbers)["means from – to"] == "0.6 – 2 s (from until.from_s on)"
    assert made_up.disagrees(run, numbers) == []
    assert [h.name for h in known_accuracy.held(run, io.scene(run)) if h.wrong] == []


def test_a_longer_run_begins_like_a_shorter_one() -> None:
    """Windows, checkpoints and the fingerprint of a run of n blocks are those of n + 1, for the reference too."""
    few = building.Building(known()).scene()
    assert few.blocks == 7 and few.block_steps == 3000 and until.most_blocks(few) == 12
    for blocks in range(7, 12):
        short, long = few.of_blocks(blocks), few.of_blocks(blocks + 1)
        windows = schedule.windows(short)
        assert len(windows) == blocks and schedule.windows(long)[:blocks] == windows
        assert short.output_steps == [s for s in long.output_steps if s <= short.steps]
        assert schedule.checkpoints(short) == [s for s in schedule.checkpoints(long) if s < short.steps]
        given = json.loads(long.model_dump_json())
        assert [plans.sample_start(given, long.steps, k) for k in range(blocks)] == [a for a, _ in windows]
        assert plans.checkpoints_every(given, long.steps) == schedule.checkpoint_every(short) == 1000


@pytest.mark.parametrize(
    ("asked", "changes", "code", "says"),
    [
        ({}, {"outlets": []}, "config.inconsistent", "until together with a deck or with outlets"),
        ({}, {"outlets": OUTLETS[:1]}, "scene.until_outlets", ""),
        ({}, {"spheres": [{**BEADS, "insertion": {"for_s": 0.5}}]},
         "config.inconsistent", "until with an insertion up to duration_s, 0.72 s"),
        ({}, {"spheres": [{k: v for k, v in BEADS.items() if k != "insertion"}]},
         "config.inconsistent", "until together with spheres that are inserted"),
        ({"block_s": 0.2}, {}, "scene.until_blocks", ""),
        ({"least_blocks": 2}, {}, "config.value", "least_blocks"),
        ({"partition_percent": 0}, {}, "config.value", "partition_percent"),
        ({"deck": 2}, {}, "scene.until_deck", ""),
        ({"from_s": 1.0}, {}, "config.inconsistent", "until.from_s below duration_s"),
        ({"from_s": 0.72}, {}, "config.inconsistent", "until.from_s below duration_s"),
        ({}, {"results": {"interval_s": 0.01, "windows": 0}}, "scene.until_short", ""),
        ({}, {"results": {"interval_s": 0.02, "windows": 12, "window_steps": 2000}}, "scene.outlet_windows", ""),
    ],
)  # fmt: skip
def test_what_cannot_be_is_one_sentence(asked: dict[str, Any], changes: dict[str, Any], code: str, says: str) -> None:
    with raises_code(code, says=says):
        building.Building(known(asked, **changes)).scene()


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> pywet.Run:
    """A run that ends early; `pywet.run` raises where a check, the ledger or the replay objects."""
    return pywet.run(known(), tmp_path_factory.mktemp("until") / "run")


@pytest.mark.slow
@pytest.mark.engine
def test_a_run_ends_when_its_partition_is_known(run: pywet.Run, tmp_path: Path) -> None:
    """At the first block at which the interval is narrow; its tables are those of a run of so many blocks from the start."""
    found = json.loads((run.path / until.RESULT).read_text())
    assert found["reached"] and 7 <= found["blocks"] < 12 and run.scene.blocks == found["blocks"]
    gone, spheres = run._run.table("history/retired"), run._run.spheres
    for blocks in range(7, found["blocks"] + 1):
        short = run.scene.of_blocks(blocks)
        early = until.assess(short, spheres, gone[gone["step"] <= short.steps], until.Until(**ASKED))
        assert early["reached"] == (blocks == found["blocks"])
    building.write(known(), tmp_path / "whole", found["blocks"])
    driver.run(tmp_path / "whole", progress=False)
    assert_same(tables_of(tmp_path / "whole"), tables_of(run.path))
    pywet.run(known(), run.path)  # the run already exists
    assert EngineScene.read(run.path / "scene.json").blocks == found["blocks"]


@pytest.mark.engine
def test_each_block_goes_on_where_the_last_one_ended(tmp_path: Path) -> None:
    """The engine is never started again at step 0 once it has begun."""
    starts: list[int] = []

    def launch(*given: Any) -> process.Usage:
        starts.append(int(given[0][-2]))
        return process.execute(*given)

    asked = known({"partition_percent": 9, "least_blocks": 5})
    building.write(asked, tmp_path)
    driver.run(tmp_path, progress=False, launch=launch, extend=until.extension(asked.until))
    assert len(starts) > 2 and starts[0] == 0 and all(b > a for a, b in pairwise(starts)), starts


@pytest.mark.slow
@pytest.mark.engine
def test_killed_within_a_block_and_between_two(run: pywet.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Killed while a block is simulated, at its end before the decision, and after it: the same run to the last bit."""

    def launch(*given: Any) -> process.Usage:
        command, at, of, report, watch = given

        def look() -> None:
            watch()
            if list((at / run_store.CHECKPOINTS).glob("sums.*.json")):
                raise Stopped

        return process.execute(command, at, of, report, look)

    asked = known()
    building.write(asked, tmp_path)
    scene_stages.record.leave_identity(tmp_path, scene_stages.fingerprint(asked))
    with pytest.raises(Stopped):
        driver.run(tmp_path, progress=False, launch=launch, extend=until.extension(asked.until))

    def stop(*_: object) -> None:
        raise Stopped

    with monkeypatch.context() as patch:  # interrupted before the decision
        patch.setattr(until, "assess", stop)
        with pytest.raises(Stopped):
            pywet.run(asked, tmp_path)
    # interrupted after the decision, before the scene with one more block is written
    with monkeypatch.context() as patch:
        patch.setattr(driver, "write_json", stop)
        with pytest.raises(Stopped):
            pywet.run(asked, tmp_path)
    with monkeypatch.context() as patch:  # interrupted after the scene is written
        patch.setattr(driver, "_together", stop)
        with pytest.raises(Stopped):
            pywet.run(asked, tmp_path)
    assert EngineScene.read(tmp_path / "scene.json").blocks == 8
    assert pywet.run(asked, tmp_path)
    assert_same(tables_of(run.path), tables_of(tmp_path))
    assert json.loads((tmp_path / until.RESULT).read_text()) == json.loads((run.path / until.RESULT).read_text())


@pytest.mark.slow
@pytest.mark.engine
def test_the_replay_finds_another_decision(run: pywet.Run, tmp_path: Path) -> None:
    """Another interval, a run that went on too long or ended too early."""
    copy = Path(shutil.copytree(run.path, tmp_path / "copy"))
    path = copy / until.RESULT
    given = json.loads(path.read_text())
    given["sizes"][0]["half_width"] *= 1.01
    path.write_text(json.dumps(given))
    found = pywet.replay(copy) or {}
    assert not found["quantities"]["results_until"]["ok"]
