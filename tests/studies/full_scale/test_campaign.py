"""Campaign, stored tables and page: what is stored, what goes on after a failure, and that the page follows from the tables."""

from __future__ import annotations

import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pywet import config as settings
from pywet import stages
from pywet.cost.cost import Coefficients
from pywet.errors import PywetError
from pywet.geometry.motion import velocity
from pywet.products.apertures import screen_of
from pywet.runs.rundir import RunDir
from pywet.scene import Vibration
from pywet.util.files import read_json, write_json, write_table
from studies.full_scale import campaign, judging, page, retirement, spread, stored_runs
from studies.full_scale.judging import FAILS, HOLDS, OPEN, Part, Statement
from studies.full_scale.stored_runs import StoredRun, keep, wedged
from tests.cases.screening import synthetic
from tests.cost.test_times import costs_of
from tests.studies.full_scale.made import make

ROOT = Path(__file__).parents[3]
MACHINE = Coefficients(costs_of(335), costs_of(17416))


@pytest.fixture
def finished(tmp_path: Path) -> Path:
    """A run directory with results, and a replay that agrees."""
    run = synthetic.make(tmp_path / "run" / "case02", moist=True)
    row = {"scale": "largest force", "count": 12, "largest": 1e-15, "median": 0.0, "tolerance": 1e-9}
    write_json(run / "replay.json", {"quantities": {"capillary": row}})
    stages.results(run)
    return run


def test_what_is_stored_can_be_read_again(finished: Path, tmp_path: Path) -> None:
    one = keep(finished, tmp_path / "data", "case02-1", {"case": 2, "variant": "", "scale": "full"})
    table = RunDir(finished).table("results/fraction_retained")
    np.testing.assert_allclose(one.retained(), table["fraction_retained"], rtol=1e-6)
    assert (one.case, one.about["contacts"], one.about["ledger_error"] < 1e-12) == (2, 12, True)
    held = one.liquid("coarse_material", "fines")[-1] + one.walls[-1] + one.liquid("collecting_bin")[-1]
    assert held == pytest.approx(1.0, rel=1e-6)
    assert list(stored_runs.variants(tmp_path / "data")[""]) == [2]


def test_a_run_that_may_not_be_believed_is_not_stored(finished: Path, tmp_path: Path) -> None:
    replay = read_json(finished / "replay.json", "")
    replay["quantities"]["capillary"]["largest"] = 1e-3
    write_json(finished / "replay.json", replay)
    with pytest.raises(PywetError, match="the replay disagrees on capillary"):
        keep(finished, tmp_path / "data", "case02-1", {"case": 2})
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize(
    ("height", "share", "stuck"), [(6e-3, 1.0, False), (3e-3, 1.0, True), (3e-3, 0.6, True), (3e-3, 0.4, False)]
)
def test_a_sphere_is_wedged_when_it_moves_with_the_screen(
    tmp_path: Path, height: float, share: float, stuck: bool
) -> None:
    """A sphere of 4 mm over the vibrating screen with a share of its speed: stuck when slower against it than half of that."""
    run = synthetic.make(tmp_path / "case02", moist=True)
    shaken = Vibration(amplitude_m=(0.0, 0.0, 9e-4), phase_rad=(0.0, 0.0, 0.0), frequency_Hz=50.0)
    scene = RunDir(run).scene.model_copy(update={"vibration": shaken})
    write_json(run / "scene.json", scene.model_dump(mode="json"))
    # at outputs the screen is at mid-stroke, at its highest speed
    assert scene.time_step_s * 100 * 50.0 == pytest.approx(0.5)
    table, motion = RunDir(run).trajectory.astype({"vz": float}), RunDir(run).mesh_motion
    coarse = table["id"] == 1
    shift = table.loc[coarse, "step"].map(motion[motion["mesh"] == "wires"].set_index("step")["dz"]).to_numpy()
    table.loc[coarse, "z"] = scene.screen_z_m + shift + height
    table.loc[coarse, ["vx", "vy"]] = 0.0
    table.loc[coarse, "vz"] = share * velocity(shaken, table.loc[coarse, "time"].to_numpy())[:, 2]
    write_table(table, run / "trajectory.parquet")
    found = wedged(RunDir(run), screen_of(RunDir(run)))[:, 0]
    assert len(found) == 3 and (found == stuck).all()


FAKE = """
import os, shutil, sys
number, seed, out, config, ranks = sys.argv[1:10:2]
os.rename(out, out + ".1")  # as a run does with an earlier one of another configuration, including its log
if number == "1":
    sys.exit(f"case 1 cannot be run on {ranks} ranks")
shutil.copytree(sys.argv[0].replace("fake.py", "run/case02"), out, dirs_exist_ok=True)
"""


def test_one_failed_case_does_not_stop_the_others_and_what_is_stored_is_not_run_again(
    finished: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "fake.py").write_text(FAKE)
    loaded = settings.load(ROOT / "config")
    loaded = replace(loaded, settings=loaded.settings.model_copy(update={"ranks": 2}))
    jobs = campaign.prepare(dict.fromkeys((1, 2), loaded), [7], "smoke", tmp_path / "out", "", MACHINE)
    data, command = tmp_path / "data", [sys.executable, str(tmp_path / "fake.py")]
    failed = campaign.Campaign(jobs, data, command, {"variant": "", "scale": "smoke"}, cores=2).run()
    assert [(j.number, j.failed) for j in failed] == [(1, "case 1 cannot be run on 2 ranks")]
    assert StoredRun(data / "case02-7").case == 2
    assert StoredRun(data / "case02-7").about["settings"] == {"fraction": 0.05, "stiffness": 0.01, "bridges_every": 1}
    assert "case02-7: stored in" in capsys.readouterr().out


def test_disk_and_time_follow_from_the_configuration() -> None:
    """Finished runs on the disk: case 1 and 2 at smoke scale 4.04 and 19.2 MB, 1 and 14 at full scale 101 and 452 MB: within a
    quarter. With all spheres to the end, 1e-7 s at least are for an evaluation of a bridge."""
    loaded = settings.load(ROOT / "config").without_retirement()
    dry, moist = campaign.prepare(dict.fromkeys((1, 2), loaded), [1], "full", Path("out"), "", MACHINE)
    assert moist.name == "case02-1"
    assert moist.need.seconds - dry.need.seconds > 1e-7 * moist.need.load.evaluations
    smoke = campaign.prepare(dict.fromkeys((1, 2), loaded), [1], "smoke", Path("out"), "", MACHINE)
    (glass,) = campaign.prepare({14: loaded}, [1], "full", Path("out"), "", MACHINE)
    disk = [job.need.disk_B for job in (*smoke, dry, glass)]
    np.testing.assert_allclose(disk, [4.04e6, 19.2e6, 101e6, 452e6], rtol=0.25)
    lines = campaign.table([dry, moist])
    assert [line.split()[0] for line in lines] == ["case", "1", "2", "all"]
    assert float(lines[-1].split()[1]) == pytest.approx((dry.need.seconds + moist.need.seconds) / 3600.0, abs=0.05)


def test_the_campaign_turns_what_it_says_and_time_follows(tmp_path: Path) -> None:
    """Springs of 0.1 at 8 mm and 0.03 at 5.6 mm, each at a tenth of a collision: a step grows with the spring's period."""
    loaded = settings.load(ROOT / "config")
    configs = campaign.turned(loaded, (2, 8), tmp_path)
    two, eight = campaign.prepare(configs, [1], "full", tmp_path, "", MACHINE)
    for job, stiffness in ((two, 0.1), (eight, 0.03)):
        config = settings.load(job.config)
        assert config.scale("full").stiffness_factor.value == job.settings["stiffness"] == stiffness
        assert config.settings.time_step.fraction.value == job.settings["fraction"] == 0.1
    stiff = dict.fromkeys((8,), configs[2])
    (same,) = campaign.prepare(stiff, [1], "full", tmp_path, "", MACHINE)
    assert eight.steps / same.steps == pytest.approx(0.3**0.5, rel=1e-2)
    assert 0.3**0.5 < eight.need.seconds / same.need.seconds < 0.8


def test_time_to_go_is_the_prediction_at_the_pace_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of 2 h, one half done in 2 h: as slow as it was, 2 h for its rest and 4 h for the other (the start counts 10 min)."""
    loaded = settings.load(ROOT / "config")
    first, second = campaign.prepare(dict.fromkeys((1, 2), loaded), [1], "smoke", tmp_path, "", MACHINE)
    for job in (first, second):
        job.need = replace(job.need, seconds=7200.0)
    one = campaign.Campaign([first, second], tmp_path, [], {}, cores=1)
    assert one.to_go([first, second], []) == 14400.0 and one.to_go([], []) == 0.0
    monkeypatch.setattr(campaign.Job, "step", property(lambda job: job.steps // 2))
    monkeypatch.setattr(campaign.time, "monotonic", lambda: 7200.0)
    assert one.to_go([second], [first]) == pytest.approx(10800.0 * (7200 + 600) / (3600 + 600), rel=1e-3)


def test_the_page_in_the_docs_follows_from_the_stored_tables(tmp_path: Path) -> None:
    folder = tmp_path / "full_scale"
    data = ROOT / "docs" / "full_scale" / "data"
    if data.exists():
        folder.mkdir()
        for name in ("data", "rigs"):
            (folder / name).symlink_to(data.with_name(name))
    assert (
        page.page_text(folder / "data", settings.load(ROOT / "config")) == (ROOT / "docs" / "full_scale.md").read_text()
    )
    made = {path.name: path.read_text() for path in folder.glob("*.csv")}
    assert set(made) == {
        "runs.csv", "statements.csv", "seeds.csv", "retirement.csv", "switched.csv", "reasons.csv", "stiffness.csv"
    }  # fmt: skip
    assert made == {name: (data.parent / name).read_text() for name in made}


def test_the_commits_that_tables_name_can_be_found() -> None:
    """In the history, where the first of them is, or as the page says."""
    git = ["git", "-C", str(ROOT), "rev-parse", "--verify", "--quiet"]
    if subprocess.run([*git, "101bd0f^{commit}"], capture_output=True, check=False).returncode:
        pytest.skip("no history here")
    with open(ROOT / "docs" / "full_scale" / "runs.csv", newline="", encoding="utf-8") as file:
        named = {row["commit"] for row in csv.DictReader(file)}
    lost = {c for c in named if subprocess.run([*git, f"{c}^{{commit}}"], capture_output=True, check=False).returncode}
    assert named and lost <= set(page.COMMITS)


def test_the_page_draws_what_there_is(tmp_path: Path) -> None:
    for case in (1, 2, 11):
        make(tmp_path / "data", case)
    half = tmp_path / "data" / "case01-1" / "run.json"
    write_json(half, {**read_json(half, ""), "cpu_s": 2400.0})
    text = page.page_text(tmp_path / "data", settings.load(ROOT / "config"))
    row = next(r for r in csv.DictReader((tmp_path / "runs.csv").read_text().splitlines()) if r["run"] == "case02-1")
    shown = (
        "stiffness_over_papers",
        "time_step_us",
        "engine_core_hours",
        "formations",
        "contacts_replayed",
        "ledger_error",
    )
    assert [row[name] for name in shown] == ["0.1", "1", "1.00", "10", "7", "1e-15"] and "Not run yet: 3, 4, 5" in text
    assert "A moist case takes 1.50 times" in text and "1.50 to 1.50, 1 pairs" in text
    assert {p.name for p in tmp_path.glob("*.svg")} == {f"fig{k}.svg" for k in ("09", 10, 12, 13, 14, 15)}
    assert all(f"full_scale/{p.name}" in text for p in tmp_path.glob("*.svg"))


def test_the_numbers_of_the_readme_are_those_of_the_stored_tables() -> None:
    """Case 2 at full scale: bridges formed, ledger, and what is left on the screen, moist and dry."""
    readme = " ".join((ROOT / "README.md").read_text().split())
    retired = stored_runs.variants(ROOT / stored_runs.RIGS)[stored_runs.DEFAULT]
    (moist,) = (run for run in retired[2] if run.about["seed"] == 10007)
    assert f"{moist.about['events']['formations']:,} liquid bridges" in readme
    assert f"ledger closes to {moist.about['ledger_error']:.0e}".replace("e-0", "e-") in readme
    left = [round(100 * stored_runs.mean(retired[case], lambda run: run.at(run.retained(), 1.5))) for case in (2, 1)]
    assert (
        f"After 1.5 s {left[0]} % of this feed has not reached the bin, of the same feed without liquid {left[1]} % "
        "(means of six seeds)" in readme
    )
    assert {len(retired[case]) for case in (1, 2)} == {6}
    assert max(run.at(run.undersize, 10.0) for case in (1, 2) for run in retired[case]) < 0.005
    reported = (ROOT / "docs" / "full_scale.md").read_text()
    with open(ROOT / "docs" / "full_scale" / "statements.csv", newline="", encoding="utf-8") as file:
        verdicts = {int(row["statement"]): row["verdict"] for row in csv.DictReader(file)}
    screening = [verdict for number, verdict in verdicts.items() if number < 40]
    holding, failing, open_ = (screening.count(verdict) for verdict in (HOLDS, FAILS, OPEN))
    assert "All 18 cases have run." in reported and "not looked for yet" not in reported
    assert len(retired) == 18 and all({run.about["seed"] for run in of} >= stored_runs.SEEDS for of in retired.values())
    with open(ROOT / "docs" / "full_scale" / "reasons.csv", newline="", encoding="utf-8") as file:
        assert failing + open_ == len([row for row in csv.DictReader(file) if int(row["statement"]) < 40])
    assert (
        "All 18 cases of the paper have been run at this scale with at least three seeds each; of the paper's 39 statements on "
        f"screening, {holding} are confirmed, {failing} are not and {open_} are inconclusive, with their reasons where "
        "known" in readme
    )
    with open(ROOT / "docs" / "full_scale" / "seeds.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    moved = {(r["case"], r["quantity"]): (float(r["mean"]), float(r["difference"]))
             for r in rows if r["significant"].startswith("yes")}  # fmt: skip
    half = "half of the undersize through [s]"
    assert len(rows) == 28
    assert [case for case, _ in moved] == ["2"] * 3 + ["8"] * 5 + ["17"] * 5
    later = {case: moved[case, half] for case in ("2", "8", "17")}
    of_coarse = moved["17", "liquid of the coarse material at the end"][1]
    shown = {case: f"{more:.2f} s ({100 * more / mean:.0f} %)" for case, (mean, more) in later.items()}
    assert (
        "With the paper's contact stiffness 13 of 28 quantities of the moist cases 2, 8, 11 and 17 differ significantly: "
        f"half of the undersize passes {shown['2']} later in case 2, {shown['8']} in case 8 and {shown['17']} in case 17, "
        f"in which {100 * of_coarse:.1f} % more of the liquid stays on the coarse material." in readme
    )


def test_a_case_with_all_seeds_is_judged_by_its_retired_runs(tmp_path: Path) -> None:
    """Case 1 has all seeds of the list and one more, case 2 lacks one, case 3 was not run again."""
    every = {case: [make(tmp_path / "data", case, seed=10007)] for case in (1, 2, 3)}
    retired = {
        case: [make(tmp_path / "rigs", case, seed=seed) for seed in seeds]
        for case, seeds in ((1, (10007, 10009, 10012, 10013)), (2, (10007, 10009)))
    }
    assert stored_runs.default(every, retired) == {1: retired[1], 2: every[2], 3: every[3]}
    assert stored_runs.mean(retired[1], lambda run: float(run.about["seed"])) == 10010.25


def test_what_springs_do_is_distinguished_from_scatter(tmp_path: Path) -> None:
    """Half of U = (exp(−0.4 t) + exp(−0.32 t))/2 is through at 1.93 s; three seeds, Student's 4.303 · √(1 + 1/3)."""
    seeds = [make(tmp_path / "a", 1, seed=k, rate=r) for k, r in ((1, 0.38), (2, 0.4), (3, 0.42))]
    one = make(tmp_path / "b", 1)
    assert spread.half_through(one) == pytest.approx(1.934, abs=2e-3)
    halves = [spread.half_through(k) for k in seeds]
    near, far = make(tmp_path / "near", 1, rate=0.41), make(tmp_path / "far", 1, rate=1.5)
    for stiff, reported in ((near, "no"), (far, "yes")):
        row = next(r for r in spread.rows({1: seeds}, {1: [stiff]}, (1, 2)) if "half of the undersize" in r[1])
        cells = list(row)
        assert cells[2:4] == ["3", f"{np.mean(halves):.4f}"] and float(cells[4]) == pytest.approx(
            np.std(halves, ddof=1), abs=1e-4
        )
        assert float(cells[5]) == pytest.approx(spread.half_through(stiff) - np.mean(halves), abs=1e-4)
        limit = 4.3027 * np.std(halves, ddof=1) * (4 / 3) ** 0.5
        assert cells[6].startswith(reported) and float(cells[6].split("±")[1]) == pytest.approx(limit, abs=1e-4)
    more = [make(tmp_path / "c", 1, seed=k, rate=r) for k, r in ((1, 0.9), (2, 1.1))]
    row = next(
        r for r in spread.rows({1: seeds}, {1: [near]}, (1,), alike={1: more}) if "half of the undersize" in r[1]
    )
    within = [np.var([spread.half_through(k) for k in of]) * len(of) for of in (seeds, more)]
    assert row[3] == f"{np.mean(halves):.4f}" and float(row[4]) == pytest.approx((sum(within) / 3) ** 0.5, abs=1e-4)
    compared = spread.rows({1: seeds}, {1: [near]}, (1,))
    assert "(cases 1, one seed each; case 1 with bridges in every third step)" in spread.lines(compared, [1])[0]
    assert spread.lines(spread.rows({1: seeds[:1]}, {}, (1,))) == []


def test_a_run_with_other_springs_decides_ranges_by_the_scatter_of_seeds(tmp_path: Path) -> None:
    """Half is through at 1.94 s, three seeds 1.85 to 2.03 s: up to 2.5 s both; one that takes 2.6 s, ± 0.45 s, decides nothing;
    with 9 s it does."""
    seeds = [make(tmp_path / "a", 1, seed=k, rate=r) for k, r in ((1, 0.38), (2, 0.4), (3, 0.42))]
    half = Part("half", 0.0, 2.5, lambda cases: spread.half_through(cases[1]))
    statements = [Statement(1, "", "", (1,), (half,)), Statement(2, "", "", (1, 2), (half, half))]
    for rate, reported in ((0.39, HOLDS), (0.3, OPEN), (0.08, FAILS)):
        other = make(tmp_path / f"{rate}", 1, rate=rate)
        first, *more = judging.redecided(statements, {1: [other]}, {1: seeds})
        assert len(more) == 2 and first[2] == HOLDS and first[5] == reported
        assert first[3] == pytest.approx(spread.half_through(other))
        values = [spread.half_through(k) for k in seeds]
        assert first[4] == pytest.approx(4.3027 * np.std(values, ddof=1), rel=1e-4)  # of one run
    assert judging.redecided(statements, {2: [other]}, {1: seeds}) == []


def test_what_retirement_changes_is_distinguished_from_scatter(tmp_path: Path) -> None:
    """Means of three and of two runs: Student's 3.182 · √(1/3 + 1/2) of their common spread; two single runs have none."""
    seeds = [make(tmp_path / "a", 2, seed=k, rate=r) for k, r in ((1, 0.38), (2, 0.4), (3, 0.42))]
    halves = np.array([spread.half_through(k) for k in seeds])
    for rate, reported in ((0.4, "no"), (1.0, "yes")):
        retired = [make(tmp_path / str(rate), 2, seed=k, rate=rate) for k in (1, 2)]
        rows = retirement.rows({2: seeds, 8: seeds[:1]}, {2: retired, 8: retired[:1]})
        cells = next(row for row in rows if row[0] == "2" and "half of the undersize" in row[1])
        assert cells[2] == "3, 2" and cells[7].startswith(reported)
        assert float(cells[6]) == pytest.approx(spread.half_through(retired[0]) - halves.mean(), abs=1e-4)
        common = (((halves - halves.mean()) ** 2).sum() / 3) ** 0.5  # the two retired runs are equal
        limit = 3.1824 * common * (1 / 3 + 1 / 2) ** 0.5
        assert float(cells[7].split("±")[1].strip(" |")) == pytest.approx(limit, abs=1e-4)
        assert any(row[:3] == ("8", "Y at 5 s", "1, 1") and row[-1] == "one seed" for row in rows)
        (output_text,) = retirement.lines({2: seeds}, {2: retired})
        assert "The engine needs 1.00 of the processor time in the median (1.00 to 1.00, 1 cases" in output_text
        changed = len(
            [row for row in rows if row[0] == "2" and row[7].startswith("yes") and row[1] in retirement.OF_CURVES]
        )
        assert f"Significant among 10 other differences: {changed} (" in output_text
    assert retirement.lines({2: seeds}, {}) == []
