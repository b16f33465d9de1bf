"""Numbers of a screen against made-up logs whose answers are known in closed form, and against the reference's own reading."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.figure import Figure
from typer.testing import CliRunner

import pywet
from pywet.cases.custom import building
from pywet.cli import ending
from pywet.cli import plant as cli_plant
from pywet.cli.app import app
from pywet.compare import grouping
from pywet.geometry.motion import engine_displacement
from pywet.products import intervals, screening_report, steady, streams
from pywet.products.partition import partition_curve, separation, size_at
from pywet.report import page, scene_page, screen_page
from pywet.runs import record
from pywet.runs.rundir import RunDir
from pywet.scene import Insertion, Vibration
from reference_impl.replay import io
from reference_impl.tables import period, plant, screen_series, screen_wall
from tests.cases.screening import synthetic
from tests.error_codes import raises_code
from tests.products import made_up
from tests.sweep.files import EXAMPLES

MASS = [2500.0 * math.pi / 6.0 * (1e-3 * d) ** 3 for d in made_up.SIZES_MM]


FROM_S = 0.2
"""From then to the end of the feed, 2 s, the third to the 38th sphere of each size leave: 36, nine of each four in a row."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = made_up.make(tmp_path_factory.mktemp("made_up"))
    screening_report.write(folder, aperture_mm=2.5, from_s=FROM_S)
    return folder


def numbers(folder: Path) -> dict:
    return json.loads((folder / "results" / "screen.json").read_text())


def reference_objects(folder: Path) -> list[str]:
    """Names of the numbers with which the reference disagrees."""
    return made_up.disagrees(folder, numbers(folder))


def test_partition_of_a_made_up_run(made: Path) -> None:
    """T = 0, 1/4, 3/4, 1 at 1 to 4 mm: d25, d50, d75 are 2, 2.5, 3 mm, ecart probable 0.5 mm, imperfection 0.2."""
    found = numbers(made)
    assert [found[k] for k in ("d25_mm", "d50_mm", "d75_mm", "ecart_probable_mm")] == pytest.approx([2, 2.5, 3, 0.5])
    assert found["imperfection"] == pytest.approx(0.2)
    m = np.array(MASS)
    share = 1 - np.array(made_up.OVERS) / made_up.EACH
    undersize = (m * share)[:2].sum() / m[:2].sum()
    oversize = (m * (1 - share))[2:].sum() / m[2:].sum()
    assert found["undersize_recovery"] == pytest.approx(
        undersize, rel=0.02
    )  # a few have not left at the end of the feed
    curve = pd.read_parquet(made / "results" / "partition.parquet")
    assert found["efficiency"] == pytest.approx(
        found["undersize_recovery"] + found["oversize_recovery"] - 1.0, rel=1e-14
    )
    assert found["oversize_recovery"] == pytest.approx(oversize, rel=1e-12)
    assert curve["T"].to_numpy() == pytest.approx([0, 0.25, 0.75, 1], rel=1e-12)
    assert (curve["T_low"] <= curve["T"]).all() and (curve["T"] <= curve["T_high"]).all()


def test_efficiency_by_binomial_counts(made: Path) -> None:
    """Of 2000 sets of independent spheres as many as the run has, the interval holds the true efficiency in 93 to 98 %."""
    random, m, t = np.random.default_rng(3), np.array(MASS), np.array([0.05, 0.25, 0.75, 0.95])
    true = (m * (1 - t))[:2].sum() / m[:2].sum() + (m * t)[2:].sum() / m[2:].sum() - 1.0
    inside = 0
    for _ in range(2000):
        overs = random.binomial(36, t)
        curve = partition_curve(1e-3 * np.array(made_up.SIZES_MM), overs, 36 - overs, m)
        low, high = intervals.of_efficiency(curve, 2.5)
        inside += low <= true <= high
    assert 0.93 <= inside / 2000 <= 0.98
    found = numbers(made)
    assert found["efficiency_low"] < found["efficiency"] < found["efficiency_high"]
    assert 0.1 < found["efficiency_high"] - found["efficiency_low"] < 0.4


def test_moisture_by_blocks() -> None:
    """Of 1000 sets of 80 spheres of two sizes with scattered films the interval holds the ratio of the means in 92 to 98 %."""
    random, inside = np.random.default_rng(4), {True: 0, False: 0}
    for _ in range(1000):
        mass = random.choice([1.0, 2.0], 80)
        liquid = mass * random.normal(0.02, 0.005, 80)
        rows = pd.DataFrame({"id": np.arange(80), "left_s": np.arange(80.0), "mass_kg": mass, "liquid_m3": liquid})
        value = screening_report.moisture_percent(rows, 1.0)
        for continuous in inside:
            inside[continuous] += abs(value - 2.0) <= intervals.of_moisture(rows, 1.0, continuous)
    assert all(0.92 <= n / 1000 <= 0.98 for n in inside.values())
    assert math.isnan(intervals.of_moisture(rows[:7], 1.0, True))


def test_mass_is_conserved_by_class_and_outlet_to_the_sphere(made: Path) -> None:
    run = RunDir(made)
    flow, gone = streams.read(run, 0.0), run.table("history/retired")
    for (kind, product), rows in flow.spheres[flow.spheres["product"] != ""].groupby(["type", "product"]):
        assert len(rows) == ((gone["type"] == kind) & (gone["outlet"] == 1 + (product == "unders"))).sum()
    inside = (flow.spheres["product"] == "").sum()
    assert inside + len(gone) == 4 * made_up.EACH and inside > 0


def test_throughput_moisture_residence(made: Path) -> None:
    """A sphere of each size every 0.05 s; each leaves 0.1 s after it entered, at the next multiple of 0.02 s, with its film.

    Blocks are of eleven intervals of 0.02 s: two at the start, and the third sphere with them, are cut off.
    """
    found = numbers(made)
    assert found["throughput_t_per_h"]["all"] == pytest.approx(3.6 * sum(MASS) * 35 / 1.76, rel=1e-9)
    assert 0 < found["throughput_half_width_t_per_h"]["all"] < 0.2 * found["throughput_t_per_h"]["all"]
    m, o = np.array(MASS), np.array(made_up.OVERS)
    films = made_up.FILM * np.arange(1, 5)
    for product, n in (("overs", o), ("unders", made_up.EACH - o)):
        want = 100 * 1000 * (n * films).sum() / (n * m).sum()
        assert found["moisture_percent_of_dry_mass"][product] == pytest.approx(want, rel=1e-12)
    entered = 25 + 50 * np.arange(2, 38)
    stays = 1e-3 * (np.ceil((entered + 100) / 20) * 20 - entered)
    of_unders = np.concatenate([np.tile(stays, 1)] + [stays[(np.arange(2, 38) % 4) >= n] for n in (1, 3)])
    assert found["residence_s"]["unders"]["mean"] == pytest.approx(of_unders.mean(), rel=1e-9)
    assert found["screen"] is None and found["screen_area_m2"] is None


def test_the_reference_gets_the_same_numbers(made: Path, tmp_path: Path) -> None:
    """From the logs alone; one that is changed is named."""
    assert reference_objects(made) == []
    path = made / "results" / "screen.json"
    text = path.read_text()
    try:
        given = json.loads(text)
        path.write_text(json.dumps({**given, "d50_mm": 1.01 * given["d50_mm"], "misplaced": 0.0}))
        assert reference_objects(made) == ["results/screen.json: d50_mm", "results/screen.json: misplaced"]
    finally:
        path.write_text(text)


SKIPPED = {"deck", "options"}
"""Of screen.json: what says how it was evaluated."""


def leaves(given: dict, path: str = "") -> list[str]:
    """Paths of all numbers that are defined."""
    found = []
    for key, value in given.items():
        found += (
            leaves(value, f"{path}{key}.") if isinstance(value, dict) else [f"{path}{key}"] if value is not None else []
        )
    return [p for p in found if p.split(".")[0] not in SKIPPED]


def test_every_number_that_is_wrong_is_named(made: Path) -> None:
    """Each of some forty numbers, half widths of intervals, purities and efficiencies among them, one per cent off."""
    given = numbers(made)
    wrong = leaves(given)
    assert len(wrong) >= 38 and {"throughput_half_width_t_per_h.all", "unders_purity", "efficiency_product"} <= {*wrong}
    for path in wrong:
        changed = json.loads(json.dumps(given))
        *above, key = path.split(".")
        inner = changed
        for name in above:
            inner = inner[name]
        inner[key] = "elsewhere" if isinstance(inner[key], str) else inner[key] * 1.01 + 1e-6
        assert made_up.disagrees(made, changed) == [f"results/screen.json: {path}"], path


def test_what_leaves_at_the_end_of_an_interval_has_left() -> None:
    """Steps of 7.5 µs: the sums of intervals are less than the times of their steps by round-off in 67 of 125 cases."""
    step, every = 7.5e-6, 2666
    times = every * step * np.arange(1, 126)
    left = step * (every * np.arange(1, 126))
    assert (times < left).sum() == 67
    table = pd.DataFrame({"entered_s": 0.0, "left_s": left, "mass_kg": 1.0})
    assert streams.hold_up(table, times).tolist() == list(range(124, -1, -1))


@pytest.mark.parametrize(("axes", "repeats", "count"), [([], False, 1), ([], True, 1), ([0.0], False, 1), ([0.0], True, 1),
    ([0.2, 0.0, 0.1], False, 2), ([0.2, 0.0, 0.1], True, 3), ([0.0, 0.1, 0.1, 0.2], False, 2)])  # fmt: skip
def test_gaps_are_between_axes(axes: list[float], repeats: bool, count: int) -> None:
    """Two pieces of wire on one axis have no gap between them."""
    assert screen_wall.gaps(axes, repeats) == count


def test_both_programs_find_the_same_steady_state() -> None:
    """Relaxations with noise, constants and drifts; of equal sums of squares the reference accepts each."""
    random, ties = np.random.default_rng(5), 0
    for length in (10, 16, 40, 125):
        for decay in (0.0, 0.1, 0.3, 2.0):
            for noise in (0.0, 0.02, 0.3):
                values = 0.3 + np.exp(-decay * np.arange(length)) + noise * random.normal(size=length)
                mine = period.starts(values)
                assert steady.start_of_steady(values) in mine
                ties += len(mine) > 1
    assert ties == 5  # series without noise that are constant from the start, or soon


def test_a_second_deck(tmp_path: Path) -> None:
    """The unders of the first deck are those of a second one and its overs by halves: T is 1/2; files are named with a 2."""
    folder = made_up.make(tmp_path / "run")
    scene = json.loads((folder / "scene.json").read_text())
    middle = {**scene["outlets"][0], "name": "middlings", "product": "middlings"}
    scene["outlets"].insert(1, middle)
    (folder / "scene.json").write_text(json.dumps(scene))
    gone = pd.read_parquet(folder / "history" / "retired.parquet")
    under = gone["outlet"] == 2
    gone.loc[under, "outlet"] = 2 + gone[under].groupby("type").cumcount() % 2
    gone.to_parquet(folder / "history" / "retired.parquet", index=False)
    first, second = (screening_report.write(folder, aperture_mm=2.5, from_s=0.0, deck=deck) for deck in (1, 2))
    assert first["d50_mm"] == pytest.approx(2.5, rel=0.02)
    curve = pd.read_parquet(folder / "results" / "partition_2.parquet").set_index("diameter_mm")["T"]
    # no sphere of the coarsest size reaches the second deck
    assert sorted(curve.index) == pytest.approx([1.0, 2.0, 3.0])
    assert curve.to_numpy() == pytest.approx([0.5, 0.5, 0.5], abs=0.06)
    assert second["deck"] == 2 and sum(second["spheres"].values()) == first["spheres"]["unders"]
    for name in ("screen", "screen_2"):
        given = json.loads((folder / "results" / f"{name}.json").read_text())
        assert made_up.disagrees(folder, given) == []
    with raises_code("screen.deck", given=3, expected=2):
        screening_report.write(folder, deck=3)


def test_a_batch_case_by_hand(tmp_path: Path) -> None:
    """One coarse sphere stays, two fine ones are in the bin at the end: a perfect cut between 4 and 8 mm."""
    folder = synthetic.make(tmp_path)
    found = screening_report.write(folder, aperture_mm=6.0)
    assert (found["efficiency"], found["misplaced"], found["d50_mm"]) == pytest.approx((1.0, 0.0, 6.0))
    mass = 1400.0 * 4.0 / 3.0 * math.pi * np.array([4e-3, 2e-3]) ** 3
    assert found["spheres"] == {"overs": 1, "unders": 2}
    assert found["residence_s"]["unders"]["mean"] == pytest.approx(0.5 * (0.01 + 0.02) - 0.005)
    assert found["throughput_t_per_h"]["unders"] == pytest.approx(3.6 * 2 * mass[1] / 0.015)
    assert found["throughput_t_per_h_m2"]["unders"] == pytest.approx(3.6 * 2 * mass[1] / 0.015 / 0.04**2)
    assert reference_objects(folder) == []


def test_liquid_on_a_screen_is_that_on_its_cross_wires_too(tmp_path: Path) -> None:
    """At the last output 0.75e-9 m3 are on the wires, 0.5e-9 on the third wall, here the cross wires of a second deck."""
    folder = synthetic.make(tmp_path / "run")
    names = {"wires": "screen_2", "collecting_bin": "cross_wires_2"}
    for path in (folder / "history" / "triangles.parquet", folder / "mesh_motion.parquet"):
        table = pd.read_parquet(path)
        table.assign(mesh=table["mesh"].replace(names)).to_parquet(path, index=False)
    scene = json.loads((folder / "scene.json").read_text())
    for wall in scene["walls"]:
        wall["name"] = names.get(wall["name"], wall["name"])
    (folder / "scene.json").write_text(json.dumps(scene))
    run = RunDir(folder)
    flow = replace(streams.read(run), deck=2)
    found = screening_report.time_series(run, flow)["screen_liquid_m3"]
    assert 1e9 * found.to_numpy() == pytest.approx([0.0, 0.0, 1.25], rel=1e-12)
    of = screen_series.table(folder, io.scene(folder), plant.spheres(folder, io.scene(folder), 1), 2)
    assert 1e9 * of["screen_liquid_m3"].to_numpy() == pytest.approx([0.0, 0.0, 1.25], rel=1e-12)


def test_the_command_prints_five_numbers(made: Path) -> None:
    result = CliRunner().invoke(
        app, ["screen", str(made), "--aperture", "2.5", "--from", "0.2"], env={"COLUMNS": "200"}
    )
    assert result.exit_code == 0 and "2.5 mm" in result.output and (made / "screen.html").exists()


def copies(made: Path, folder: Path, percents: list[float], name: str = "made up") -> list[Path]:
    """Copies of the run with a description and a seed of their own; `percents`: moisture of each."""
    runs = []
    for seed, percent in enumerate(percents, start=1):
        run = shutil.copytree(made, folder / f"run{percent:g}" / str(seed))
        scene = json.loads((run / "scene.json").read_text())
        scene["liquid"]["initial_film_thickness_m"] = 1e-5 * percent
        (run / "scene.json").write_text(json.dumps({**scene, "seed": seed}))
        liquid = {"percent": percent}
        description = {"name": name, "seed": seed, "liquid": liquid, "file": f"{seed}.yaml", "folder": str(run)}
        (run / "description.json").write_text(json.dumps(description))
        runs.append(run)
    return runs


def test_only_seeds_of_one_scene_are_pooled(made: Path, tmp_path: Path) -> None:
    """Of 1 % twice and 4 % once the mean is that of two runs; 1 % and 4 % alone have columns and no mean."""
    runs = copies(made, tmp_path, [1.0, 1.0, 4.0])
    cli = CliRunner(env={"COLUMNS": "200"})
    result = cli.invoke(app, ["screen", *map(str, runs), "--aperture", "2.5", "--from", "0.2"])
    assert result.exit_code == 0, result.output
    lines = [line for line in result.output.splitlines() if "mean of" in line]
    assert len(lines) == 2 and all("(mean of 2 runs, 95 %)" in line and str(runs[0]) in line for line in lines)
    result = cli.invoke(app, ["screen", str(runs[0]), str(runs[2]), "--aperture", "2.5", "--from", "0.2"])
    assert result.exit_code == 0 and "mean of" not in result.output
    shutil.copytree(runs[0], again := tmp_path / "again")
    repeated = cli.invoke(app, ["screen", str(runs[0]), str(again), "--aperture", "2.5", "--from", "0.2"])
    assert repeated.exit_code == 0 and "mean of" not in repeated.output  # one seed counts once
    assert "run1/1" in result.output and "run4/3" in result.output


def test_seeds_of_runs_without_a_description(made: Path, tmp_path: Path) -> None:
    """Scenes that differ in the seed and the box alone are one; another duration is another scene."""
    runs = copies(made, tmp_path, [1.0, 1.0, 1.0])
    for run in runs:
        (run / "description.json").unlink()
    scene = json.loads((runs[1] / "scene.json").read_text())
    (runs[1] / "scene.json").write_text(json.dumps({**scene, "box_high_m": [1.0, 1.0, 1.5]}))
    scene = json.loads((runs[2] / "scene.json").read_text())
    (runs[2] / "scene.json").write_text(json.dumps({**scene, "duration_s": 3.0}))
    assert grouping.by_scene(runs) == [runs[:2], runs[2:]]
    for run, blocks in zip(runs, (8, 9, 9), strict=True):  # runs with `until` end after different numbers of blocks
        scene = json.loads((run / "scene.json").read_text())
        scene["output"]["contact_windows"], scene["blocks"] = 0, blocks
        (run / "scene.json").write_text(json.dumps({**scene, "duration_s": 0.2 * blocks}))
    assert grouping.by_scene(runs) == [runs]
    for run, word in zip(runs, ("one", "one", "other"), strict=True):  # or of files that have changed
        record.leave_identity(run, run.name, word)
    assert grouping.by_scene(runs) == [runs[:2], runs[2:]]


def test_values_have_intervals_and_an_unsteady_run_is_named(made: Path, tmp_path: Path) -> None:
    """Five numbers with intervals, and what is not steady, on the terminal, on the page and at the end of a run."""
    run = shutil.copytree(made, tmp_path / "run")
    found = screening_report.write(run, aperture_mm=2.5, from_s=FROM_S)
    (run / "results" / "screen.json").write_text(json.dumps({**found, "options": {}, "steady": False, "from_s": 1.0}))
    words = screen_page.five(found)
    assert [key for key, text in words.items() if not {"±", "–"} & {*text}] == ["ecart probable"]
    ends = [f"{100 * found[f'efficiency_{end}']:.3g}" for end in ("low", "high")]
    assert f"({ends[0]} – {ends[1]})" in words["efficiency"]
    page = screen_page.write(run, numbers(run)).read_text()
    assert "Not steady: means over the last 1 s of the feed." in page.split("<section")[0]
    lines = list(ending._screen([RunDir(run)]))
    assert lines[-1] == "not steady: means over the last 1 s of the feed" and "(" in lines[0]
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["screen", str(run), "--aperture", "2.5"])
    assert found["steady"] and result.exit_code == 0
    assert ("not steady" in result.output) == (not numbers(run)["steady"])


def test_pages_of_a_run_evaluate_without_options(made: Path, tmp_path: Path) -> None:
    """After `--aperture --from` a run ends with the numbers and tables of before; `screen.html` has those asked for."""
    run = shutil.copytree(made, tmp_path / "run")
    usual = screening_report.write(run)
    lines, (before,) = list(ending._screen([RunDir(run)])), screen_page.of_run(run)
    asked = screening_report.write(run, aperture_mm=3.5, from_s=1.0)
    assert asked["efficiency"] != usual["efficiency"] and asked["spheres"] != usual["spheres"]
    after = screen_page.of_run(run)[0]
    assert {**after[0], "options": {}} == usual == before[0] and list(ending._screen([RunDir(run)])) == lines
    for one, other in zip(before[1:], after[1:], strict=True):
        pd.testing.assert_frame_equal(one, other)
    assert "1 – 2 s (from --from on)" in screen_page.write(run, asked).read_text()


def test_cards_and_seeds_in_words(made: Path, tmp_path: Path) -> None:
    """A card has the value in front and its interval behind the name; of d50 of 2, 3, 4 mm the mean is 3.0 ± 2.5 mm (Student)."""
    found = numbers(made)
    cut = screen_page.cards(screen_page.five(found))[0]
    assert cut.value == "2.5 mm" and cut.text.startswith("cut size d50 (")
    assert screen_page.between(3.57, (None, 5.18), " mm") == "3.57 mm (at most 5.18)"
    assert screen_page.measured(0.02, 0.01, " %", 100.0) == "2.0 ± 1.0 %"
    assert screen_page.measured(0.0, 0.0, " %") == "0 %"
    found["options"] = {}  # as if these were the run's own
    every = [{**found, "d50_mm": d50, "pegged_share": share} for d50, share in ((2.0, None), (3.0, 0.1), (4.0, 0.1))]
    words = screen_page.over_seeds(every)
    assert words.keys() == screen_page.five(found).keys()
    folders = [shutil.copytree(made, tmp_path / f"run-{k}") for k in range(3)]
    for folder, numbers_of in zip(folders, every, strict=True):
        (folder / "results" / "screen.json").write_text(json.dumps(numbers_of))
    line, *_, last = ending._screen([RunDir(folder) for folder in folders])
    assert line.split("  ")[0] == "cut size d50" and line.endswith(" 3.0 ± 2.5 mm")
    assert last == "±: 95 % interval of the mean over 3 seeds"
    (folders[1] / "results" / "screen.json").write_text(json.dumps({**every[1], "steady": False}))
    (section,) = scene_page._screens([], words, [SimpleNamespace(path=folder) for folder in folders])  # type: ignore[misc]
    assert "Not steady: run-1." in section.body and "mean of 3 seeds" in section.body
    assert words["cut size d50"] == "3.0 ± 2.5 mm" and words["apertures pegged"] == "10 ± 0 % (2 of 3 seeds)"


def test_what_left_in_no_product_is_named(made: Path, tmp_path: Path) -> None:
    """The unders of 1 and 2 mm leave by an outlet without a product: their share of the mass of all 160 spheres; the reference
    finds it, and objects to another one. With products alone nothing is named."""
    assert numbers(made)["spilled_share"] == 0.0 and screen_page.SPILLED not in screen_page.five(numbers(made))
    run = shutil.copytree(made, tmp_path / "run")
    scene = json.loads((run / "scene.json").read_text())
    scene["outlets"].append({"name": "side", "low_m": [None] * 3, "high_m": [-0.5, None, None], "product": None})
    (run / "scene.json").write_text(json.dumps(scene))
    gone = pd.read_parquet(run / "history" / "retired.parquet")
    gone.loc[(gone["outlet"] == 2) & (gone["type"] <= 2), "outlet"] = 3
    gone.to_parquet(run / "history" / "retired.parquet", index=False)
    found = screening_report.write(run, from_s=FROM_S)
    lost = pd.read_parquet(run / "history" / "retired.parquet").query("outlet == 3")["type"].value_counts()
    share = sum(n * MASS[kind - 1] for kind, n in lost.items()) / (made_up.EACH * sum(MASS))
    assert found["spilled_share"] == pytest.approx(share, rel=1e-12) and share > 0.01
    assert screen_page.five(found)[screen_page.SPILLED] == f"{100 * share:.3g} % of the feed"
    assert made_up.disagrees(run, found) == []
    assert made_up.disagrees(run, {**found, "spilled_share": 0.0}) == ["results/screen.json: spilled_share"]


def test_passage_is_below_the_screen_where_that_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sphere that rests on a deck 6.8 mm below its place at the start has not passed; one that is below it later has."""
    steps = np.array([0, 10, 20])
    table = pd.DataFrame({"step": [0, 0, 10, 10, 20, 20], "id": [1, 2] * 3, "type": 1, "x": [0.01, 0.02] * 3,
                          "z": [0.003, 0.003, -0.004, -0.004, -0.004, -0.009]})  # fmt: skip
    motion = pd.DataFrame({"mesh": "screen", "step": steps, "dz": [0.0, -0.0068, -0.0068]})
    run: Any = SimpleNamespace(
        trajectory=table, mesh_motion=motion, scene=SimpleNamespace(screen_z_m=0.0), enters=np.zeros(2),
        timeline=SimpleNamespace(ids=np.array([1, 2])),
    )  # fmt: skip
    monkeypatch.setattr(screen_page.apertures, "screen_of", lambda run, deck: SimpleNamespace(name="screen"))
    monkeypatch.setattr(
        screen_page.apertures, "extents", lambda run, screen: (np.full((1, 3), -0.002), np.zeros((1, 3)))
    )
    assert screen_page.crossings(run)["id"].tolist() == [2]


def test_what_a_screen_does_not_have(made: Path) -> None:
    """A dry feed has no moisture; a cut size that no size reaches says which way the spheres went, for seeds as well."""
    found = {**numbers(made), "feed_moisture_percent": 0.0, "d50_mm": None, "ecart_probable_mm": None}
    found |= {"d50_low_mm": None, "d50_high_mm": None, "spheres": {"overs": 469, "unders": 137}}
    found["d50_position"] = "below the smallest size"
    why = {1: "– (below the smallest size: 469 overs, 137 unders)", 2: "– (2 below the smallest size)"}
    for count, words in ((1, screen_page.five(found)), (2, screen_page.over_seeds([found, found]))):
        assert screen_page.MOISTURE not in words and words["cut size d50"] == why[count]
        assert words["ecart probable"] == "– (d25 or d75 outside the sizes)"
        assert screen_page.cards(words)[0] == page.Card("–", f"cut size d50 {why[count][2:]}")
    for deck, end in ((1, ", feed 3 %"), (2, ", feed of the top deck 3 %")):
        moist = screen_page.five({**found, "feed_moisture_percent": 3.0, "deck": deck})
        assert moist[screen_page.MOISTURE].endswith(end)
    del found["d50_position"]  # results of an older version
    assert screen_page.five(found)["cut size d50"] == "– (outside the sizes: 469 overs, 137 unders)"


OVERS_OF = {
    "within the sizes": (made_up.OVERS, 2.5, "2.5 mm ("),
    "at the smallest size": ((20, 30, 30, 40), 1.0, "1 mm (at most 1.63), at the smallest size"),
    "at the largest size": ((0, 10, 10, 20), 4.0, "4 mm (at least 3.37), at the largest size"),
    "below the smallest size": ((30, 30, 40, 40), None, "– (below the smallest size: "),
    "above the largest size": ((0, 10, 10, 10), None, "– (above the largest size: "),
    "T does not stay above 0.5": ((30, 30, 10, 10), None, "– (T does not stay above 0.5: "),
}
"""Position -> of 40 spheres of each size those to the overs, cut size [mm], its words."""


@pytest.fixture(scope="module")
def positions(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A run for each position of the cut size, evaluated from a time on from which whole fours of each size leave."""
    folder, runs = tmp_path_factory.mktemp("positions"), {}
    for where, (overs, *_) in OVERS_OF.items():
        runs[where] = made_up.make(folder / where.replace(" ", "_"), overs)
        screening_report.write(runs[where], aperture_mm=2.5, from_s=FROM_S)
    return runs


@pytest.mark.parametrize("where", OVERS_OF)
def test_where_the_cut_size_is_among_the_sizes(positions: dict[str, Path], where: str) -> None:
    """A half of the mass at an end of the sizes, beyond it or nowhere: in the file, in words, and by the reference."""
    found, (_, size, words) = numbers(positions[where]), OVERS_OF[where]
    assert (found["d50_mm"], found["d50_position"]) == (pytest.approx(size), where)
    assert screen_page.five(found)["cut size d50"].startswith(words)
    assert reference_objects(positions[where]) == []
    assert made_up.disagrees(positions[where], {**found, "d50_position": "–"}) == ["results/screen.json: d50_position"]


def test_several_runs_name_the_cut_sizes_that_are_not_enclosed(positions: dict[str, Path]) -> None:
    """A mean over some of the runs says how many it leaves out, and where their cut sizes are."""
    every = [numbers(run) for run in positions.values()]
    words = screen_page.over_seeds(every)["cut size d50"]
    others = ", ".join(f"1 {where}" for where in [*OVERS_OF][1:])
    assert words == f"2.5 ± 3.7 mm (3 of 6 seeds; {others})"
    lines = [*cli_plant._over_seeds(every)]
    assert lines[0] == f"cut size [mm]: 2.5 ± 3.7 (mean of 3 runs, 95 %; {others})"
    assert lines[1].endswith("(mean of 6 runs, 95 %)")


def test_no_sphere_has_no_cut_size() -> None:
    """Of an empty product neither a size nor a position; the reason is printed."""
    none = separation(partition_curve(np.array([1e-3]), np.array([0]), np.array([0]), np.array([1.0])))
    assert none.d50_position == plant.place_of([], None) == "no sphere left"


def test_a_product_has_one_colour_on_all_charts(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Overs and unders over time as mass and as moisture."""
    colours: list[dict[str, str]] = []

    def drawn(figure: Figure, *_: str) -> str:
        colours.append({str(line.get_label()): str(line.get_color()) for line in figure.axes[0].get_lines()})
        return ""

    monkeypatch.setattr(screen_page.page, "curves", drawn)
    series = pd.read_parquet(made / "results" / "screen_series.parquet")
    screen_page._products(series)
    screen_page._moisture(RunDir(made), series)
    masses, moistures = colours
    assert {*moistures} == {"overs", "unders"} and moistures.items() <= masses.items()
    assert len({*masses.values()}) == 3


def test_a_level_of_custom_walls_has_no_aperture(tmp_path: Path) -> None:
    """An outlet named middlings next to a single deck: its level is evaluated with the cut size as the limit."""
    folder = made_up.make(tmp_path / "run")
    scene = json.loads((folder / "scene.json").read_text())
    scene["outlets"].append({**scene["outlets"][0], "name": "middlings_gap", "product": "middlings"})
    (folder / "scene.json").write_text(json.dumps(scene))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(screening_report.apertures, "deck_of", lambda run: {"aperture_mm": 2.5})
        assert [screening_report.aperture_of(RunDir(folder), k) for k in (1, 2)] == [2.5, None]


def test_a_run_without_products_is_refused(tmp_path: Path) -> None:
    folder = made_up.make(tmp_path / "run")
    text = (folder / "scene.json").read_text()
    (folder / "scene.json").write_text(text.replace('"product": "overs"', '"product": null'))
    with raises_code("screen.uncollected"):
        screening_report.write(folder)
    (folder / "scene.json").write_text(json.dumps({**json.loads(text), "outlets": []}))
    with raises_code("screen.no_outlets"):
        screening_report.write(folder)


def test_sizes_and_recoveries_that_are_not_defined() -> None:
    """A feed all of which passes has no cut size; without oversize its recovery is 1, and nothing is misplaced."""
    none = separation(partition_curve(np.array([1e-3]), np.array([0]), np.array([0]), np.array([1.0])), 3.0)
    assert math.isnan(none.efficiency) and math.isnan(none.misplaced)
    curve = partition_curve(np.array([1e-3, 2e-3]), np.array([0, 0]), np.array([5, 7]), np.array([1.0, 8.0]))
    found = separation(curve, 3.0)
    assert math.isnan(found.d50_mm) and found.efficiency == 1.0 and found.misplaced == 0.0
    assert math.isnan(separation(curve).efficiency)
    assert size_at(pd.DataFrame({"diameter_mm": [1.0, 2.0, 3.0], "T": [0.5, 0.5, 1.0]}), 0.5) == 2.0
    blocked = separation(partition_curve(np.array([1e-3]), np.array([10]), np.array([0]), np.array([1.0])), 5.0)
    assert math.isnan(blocked.unders_purity) and blocked.overs_purity == blocked.undersize_recovery == 0.0


def test_sizes_of_a_curve_that_crosses_a_share_more_than_once_are_in_order() -> None:
    """Fine classes of five spheres do not move the cut size out of its interval or behind d25; the reference finds the same."""
    diameters, mass = np.array([1e-3, 2e-3, 3e-3, 4e-3]), np.ones(4)
    found = separation(partition_curve(diameters, np.array([2, 3, 10, 190]), np.array([3, 2, 90, 10]), mass))
    assert found.d50_mm == pytest.approx(3.0 + (0.5 - 0.1) / (0.95 - 0.1)) and found.reference_mm == found.d50_mm
    random = np.random.default_rng(4)
    for _ in range(200):
        overs, unders = random.integers(0, 4, size=(2, 4))
        unders += overs + unders == 0
        curve = partition_curve(diameters, overs, unders, mass)
        sizes = [(row.diameter_mm, row.overs_kg, row.unders_kg) for row in curve.itertuples()]
        ends = [size_at(curve, 0.5, column) for column in ("T_high", "T", "T_low")]
        for several in ([size_at(curve, share) for share in (0.25, 0.5, 0.75)], ends):
            known = [size for size in several if not math.isnan(size)]
            assert known == sorted(known)
        for share in (0.25, 0.5, 0.75):
            theirs = plant.size_of(sizes, share)
            assert size_at(curve, share) == pytest.approx(
                math.nan if theirs is None else theirs, rel=1e-12, nan_ok=True
            )


def test_a_batch_with_outlets_counts_all_that_left_and_what_stayed(tmp_path: Path) -> None:
    """Without insertion no time is left out; what stays is overs with its liquid. The reference finds the same numbers."""
    folder = made_up.make(tmp_path / "run")
    scene = json.loads((folder / "scene.json").read_text())
    for kind in scene["classes"]:
        kind["insertion"] = None
    (folder / "scene.json").write_text(json.dumps(scene))
    found = screening_report.write(folder)
    gone = pd.read_parquet(folder / "history" / "retired.parquet")
    unders = int((gone["outlet"] == 2).sum())
    assert found["kind"] == "batch" and 0 < len(gone) < 4 * made_up.EACH
    assert found["spheres"] == {"overs": 4 * made_up.EACH - unders, "unders": unders}
    assert reference_objects(folder) == []


def test_means_last_to_the_end_of_the_last_feed() -> None:
    """A tracer fed for a tenth of a second does not end the averaging period of the feed."""
    made = made_up.scene()
    tracer = made.classes[0].model_copy(update={"insertion": Insertion(from_s=1.0, for_s=0.1)})
    assert made.model_copy(update={"classes": (tracer, *made.classes[1:])}).insertion_s == (0.0, 2.0)


def test_steady_state_of_a_relaxation() -> None:
    """An exponential start-up of 20 steps within noise is cut off after 2 to 6 times that; a ramp is never steady."""
    random = np.random.default_rng(1)
    values = 1.0 - np.exp(-np.arange(1000) / 20.0) + random.normal(0.0, 0.05, 1000)
    start = steady.start_of_steady(values)
    assert start is not None and 40 <= start <= 120
    assert steady.start_of_steady(np.arange(100.0)) is None


def test_block_interval_covers_the_mean() -> None:
    """Expect that the 95 % interval contains the mean 0 in 90 to 98 % of 400 correlated series."""
    random, inside = np.random.default_rng(2), 0
    for _ in range(400):
        noise, x = random.normal(size=800), np.zeros(800)
        for k in range(1, 800):
            x[k] = 0.8 * x[k - 1] + noise[k]
        mean, half = steady.block_mean(x)
        inside += abs(mean) <= half
    assert 0.90 <= inside / 400 <= 0.98


def test_the_plane_of_the_screen_is_where_the_engine_has_it() -> None:
    """The reference counts pegged spheres by the engine's sum of velocities, which is 0.2 µm from the sine: a sphere between both
    would be pegged for one of the two programs alone."""
    moves = Vibration(amplitude_m=(0.0, 0.0, 1e-3), phase_rad=(0.0, 0.0, 0.4), frequency_Hz=20.0)
    rate, step = 2.0 * math.pi * 20.0, 1.8e-5
    mine = screen_series.summed(1e-3, rate, 0.4, step, 5000)
    engine = engine_displacement(moves, np.arange(5001), step)[:, 2]
    assert np.abs(mine - engine).max() < 1e-15
    sine = 1e-3 * (np.sin(rate * step * np.arange(5001) + 0.4) - math.sin(0.4))
    assert 1e-7 < np.abs(mine - sine).max() < 3e-6


def test_a_class_that_has_exactly_the_share_encloses_it_whatever_the_rounding() -> None:
    """A quarter of the finest class to the overs: d25 is its size, though the masses give 0.25 and the last bits more or less."""
    for t in (0.25, np.nextafter(0.25, 1.0), np.nextafter(0.25, 0.0)):
        curve = pd.DataFrame({"diameter_mm": [2.5, 3.5], "T": [t, 0.5]})
        assert size_at(curve, 0.25) == pytest.approx(2.5, rel=1e-12)
        assert plant.size_of([(2.5, t, 1.0 - t), (3.5, 1.0, 1.0)], 0.25) == pytest.approx(2.5, rel=1e-12)
        ends = pd.DataFrame({"diameter_mm": [2.5, 3.5], "T": [0.1, t]})
        assert size_at(ends, 0.25) == pytest.approx(3.5, rel=1e-12)


def test_liquid_of_a_deck_at_the_end_by_product(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both products, all spheres that are still inside and all walls have one share each."""
    there = {
        "spheres_a": 1.0,
        "spheres_b": 2.0,
        "outlet_overs": 4.0,
        "outlet_unders": 2.5,
        "wall_screen": 0.4,
        "left": 0.1,
    }
    summary = {"initial_liquid_m3": 10.0, "liquid_end_m3": {**there, "total": 10.0}, "events": None}
    monkeypatch.setattr(ending, "_summary", lambda run: summary)
    classes = [SimpleNamespace(name=name) for name in "ab"]
    run = SimpleNamespace(scene=SimpleNamespace(classes=classes, outlets=[None, None]))
    printed = "liquid at the end: 40 % outlet overs, 30 % spheres inside, 25 % outlet unders, 4 % walls, 1 % left"
    assert [*ending._liquid([run])] == [printed]  # type: ignore[list-item]
    run.scene.outlets = []
    assert [*ending._liquid([run])] == ["liquid at the end: 40 % outlet overs, 25 % outlet unders, 20 % spheres b"]  # type: ignore[list-item]


def test_sizes_that_were_not_simulated_are_named_with_the_numbers(tmp_path: Path) -> None:
    """Rosin-Rammler of 5 mm and spread 2.5 from 2.5 mm on: 1 - exp(-0.5^2.5) = 16 % are finer. Not of a file."""
    folder = made_up.make(tmp_path / "run")
    psd = {"rosin_rammler": {"size_mm": 5, "spread": 2.5}, "smallest_mm": 2.5, "largest_mm": 40, "classes": 6}
    gone = {"name": "other", "psd": {"file": "no.csv"}}
    (folder / "description.json").write_text(json.dumps({"feed": [{"name": "ore", "psd": psd}, gone]}))
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["screen", str(folder)])
    line = "feed ore was simulated without 16 % of its mass finer: the numbers are those of the rest"
    assert line in done.output.splitlines() and "feed other" not in done.output
    assert "Feed ore was simulated without 16 %" in (folder / "screen.html").read_text()


def test_sizes_left_out_of_a_sieve_analysis_are_those_of_the_run(tmp_path: Path) -> None:
    """Of 20 % between 2 and 4 mm, half is finer than sqrt(8) mm by logarithm; another file of that name changes nothing."""
    file = tmp_path / "sieves.csv"
    file.write_text("2,4,20\n4,6,75\n6,8,5\n")
    given = yaml.safe_load((EXAMPLES / "scenes" / "deck.yaml").read_text())
    given["feed"][0]["psd"] = {"file": "sieves.csv", "smallest_mm": math.sqrt(8.0), "largest_mm": 6}
    building.write(pywet.Scene(**given, folder=tmp_path), tmp_path / "run")
    file.write_text("4,6,100\n")
    line = "feed ore was simulated without 10 % of its mass finer and 5 % of its mass coarser: the numbers are those of the rest"
    assert screen_page.left_out(tmp_path / "run") == [line]
