"""The report of synthetic cases: what a person must find in it, done and failed."""

from __future__ import annotations

import base64
import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import config as settings
from pywet import stages
from pywet.cases.screening import verdict
from pywet.config.entries import NonNegativeEntry, PositiveEntry
from pywet.errors import PywetError
from pywet.report import answer, plots, presets, report, report_numbers
from pywet.report.collect import CaseResult, collect, collect_run
from pywet.runs import record
from pywet.runs.rundir import RunDir
from reference_impl.shown import report_values
from reference_impl.shown.case_files import Cases
from reference_impl.shown.report_values import states
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

ROOT = Path(__file__).parent.parent.parent
REPLAY = {
    "quantities": {
        "bridge_volume": {"scale": "itself", "count": 3, "largest": 2e-12, "median": 1e-16, "tolerance": 1e-9}
    }
}
CASES = (1, 2, 3)


@pytest.fixture(scope="module")
def config() -> settings.Config:
    return settings.load(ROOT / "config")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Case 1 dry and done, case 2 moist and done, case 3 failed in the engine."""
    for number in CASES:
        run = synthetic.make(tmp_path / f"case{number:02d}", moist=number > 1, name=f"case{number:02d}")
        scene = json.loads((run / "scene.json").read_text())
        for sphere, name in zip(scene["classes"], ("large", "small"), strict=True):
            sphere["name"] = name
        (run / "scene.json").write_text(json.dumps(scene))
        if number > 1:
            (run / "replay.json").write_text(json.dumps(REPLAY))
        for stage in stages.NEEDS:
            stages.attempt(run, stage, _work(run, number, stage))
    return tmp_path


@pytest.fixture
def unbridged(tmp_path: Path) -> Path:
    """Cases 2 and 3 with liquid and `effects.bridges: off`: films that nothing touches, no ledger and no replay."""
    for number in (2, 3):
        run = synthetic.make(tmp_path / f"case{number:02d}", name=f"case{number:02d}", bridges=False)
        for stage in stages.NEEDS:
            stages.attempt(run, stage, _work(run, number=2, stage=stage))
    return tmp_path


def _work(run: Path, number: int, stage: str):  # type: ignore[no-untyped-def]
    def work() -> None:
        if (number, stage) == (3, "simulate"):
            raise PywetError("LIGGGHTS stopped: spheres left the simulated box <lost>")
        if stage == "results":
            stages.results(run)

    return work


def _write(
    config: settings.Config,
    folder: Path,
    picture: Path | None = None,
    scale: str = "smoke",
    cases: tuple[int, ...] = CASES,
) -> str:
    """Page as a reader sees it: without the marks of numbers."""
    report.write(config, scale, cases, folder, ROOT / "workflow" / "report", picture, folder / "report.html")
    return re.sub(r"</?data\b[^>]*>", "", (folder / "report.html").read_text())


def test_report_counts_done_and_cross_checked_cases(config: settings.Config, folder: Path) -> None:
    text = _write(config, folder)
    assert re.search(r"<b>2 of 3</b><span>cases done", text)
    assert re.search(r"<b>1 of 2</b><span>moist cases cross-checked", text)
    assert "2.0e−12" in text


def test_the_section_on_the_screen_is_on_top(config: settings.Config, folder: Path) -> None:
    """Before all other sections, with a row for each case that has results and a column for each number."""
    text = _write(config, folder)
    assert re.findall(r'<section id="(\w+)"', text)[0] == "screen"
    table = text.partition('<section id="screen">')[2].partition("</section>")[0]
    there = [n for n in CASES if (folder / f"case{n:02d}" / "results" / "screen.json").exists()]
    assert table.count("<tr>") == 1 + len(there) > 1
    assert table.count("<td>") == len(there) * (1 + len(report_numbers.SCREEN))
    given = json.loads((folder / "report.json").read_text())
    of = json.loads((folder / f"case{there[0]:02d}" / "results" / "screen.json").read_text())
    recovery = given[f"case{there[0]:02d}.screen.undersize_recovery_percent"]["value"]
    assert recovery == pytest.approx(100.0 * of["undersize_recovery"])


def test_moist_cases_without_bridges_are_done_and_have_no_ledger(config: settings.Config, unbridged: Path) -> None:
    text = _write(config, unbridged, cases=(2, 3))
    assert re.search(r"<b>2 of 2</b><span>cases done", text) and re.search(r"<b>0 of 0</b><span>moist cases", text)
    ledger = text.partition('<section id="ledger">')[2].partition("</section>")[0]
    assert ledger.count("<tr>") == 1  # header row only


def test_the_summary_of_a_dry_run_is_not_taken_for_a_moist_case(config: settings.Config, tmp_path: Path) -> None:
    run = synthetic.make(tmp_path / "case02", moist=False)
    for stage in stages.NEEDS:
        stages.attempt(run, stage, _work(run, number=1, stage=stage))
    assert "that of a dry run" in collect(tmp_path, [config.case(2)])[0].problems[0]


def test_presets_are_laid_side_by_side_with_what_their_bridges_did(config: settings.Config, folder: Path) -> None:
    """The synthetic run's ledger ends with four bridges formed and two ruptured."""
    usual = collect(folder, [config.case(2)])[0]
    numbers = report_numbers.Numbers()
    rows = presets.shown(usual, usual, "exact", numbers)["rows"]
    found = {
        (kind, name): numbers[f"presets.case02.{name}.{kind}"]["shown"] for kind in rows for name in ("paper", "exact")
    }
    assert [found[kind, name] for kind in ("formations", "ruptures") for name in ("paper", "exact")] == [
        "4",
        "4",
        "2",
        "2",
    ]


def test_one_seed_of_each_preset_is_no_difference(config: settings.Config, folder: Path) -> None:
    """Inconclusive; of several Student's interval, by hand here: equal spreads s of 5 and 5 seeds have 8 degrees of freedom,
    t = 2.306, half width t s sqrt(2/5); t = 3.355 for a level of 1 %, as for one of five comparisons."""
    usual, numbers = collect(folder, [config.case(2)])[0], report_numbers.Numbers()
    presets.shown(usual, usual, "exact", numbers)
    assert numbers["presets.case02.difference"]["value"] == "inconclusive"
    assert numbers["presets.case02.paper.fraction_retained.seeds"]["value"] == 1
    spread = [0.64, 0.65, 0.66, 0.67, 0.68]
    error = np.std(spread, ddof=1) * np.sqrt(2 / 5)
    for by, of, t, found in (
        (0.01, 1, 2.306, "not significant"), (0.03, 1, 2.306, "significant"), (0.03, 5, 3.355, "not significant"),
    ):  # fmt: skip
        report_numbers.significance(numbers, "d", spread, [v + by for v in spread], of)
        half = t * error
        assert numbers["d"]["value"] == found
        assert [numbers[f"d.{end}"]["shown"] for end in ("low", "high")] == [f"{by - half:+.3f}", f"{by + half:+.3f}"]


def test_a_failed_case_is_named_with_its_reason_escaped(config: settings.Config, folder: Path) -> None:
    text = _write(config, folder)
    assert "<b>case03</b>: stage simulate failed: LIGGGHTS stopped: spheres left the simulated box &lt;lost&gt;" in text


def test_report_needs_no_other_file(config: settings.Config, folder: Path) -> None:
    (folder / "picture.png").write_bytes(b"\x89PNG stand-in")
    text = _write(config, folder, folder / "picture.png")
    sources = re.findall(r'src="([^"#][^"]*)"', text)
    assert sources
    assert all(source.startswith("data:image/") for source in sources)
    assert sum(source.startswith("data:image/png") for source in sources) == 1


def test_links_lead_to_files_that_are_there(config: settings.Config, folder: Path) -> None:
    links = re.findall(r'<a href="([^"#][^"]*)"', _write(config, folder))
    assert "case02/results/fraction_retained.csv" in links and "case01/replay.json" not in links
    assert all((folder / link).exists() for link in links)


def test_seeds_of_a_case_become_a_band(config: settings.Config, folder: Path) -> None:
    """Half of what case 2 retains, in a folder of another seed: the band spans both, the folder of a preset is none."""
    table = pd.read_parquet(folder / "case02" / "results" / "fraction_retained.parquet")
    for name in ("case02-10008", "case02-exact"):
        other = folder / name / "results" / "fraction_retained.parquet"
        other.parent.mkdir(parents=True)
        table.assign(fraction_retained=table["fraction_retained"] / 2).to_parquet(other)
    (result,) = collect(folder, [config.case(2)])
    assert len(result.seeds) == 1
    figure, axes = plots.plt.subplots()
    plots._draw_moisture(axes, [result])
    band = axes.collections[0].get_paths()[0].vertices[:, 1]
    plots.plt.close(figure)
    assert (band.min(), band.max()) == (table["fraction_retained"].min() / 2, table["fraction_retained"].max())


@pytest.mark.parametrize(("percent", "seed", "counted"), [(5.0, 2, 1), (10.0, 2, 0)])
def test_a_run_of_another_configuration_is_no_seed(
    config: settings.Config, folder: Path, percent: float, seed: int, counted: int
) -> None:
    """Seeds that were run with 5 % of liquid are not averaged with a run of 10 %."""
    _reseeded(folder / "case02", folder / "case02-10008", 10008)
    for name, liquid, number in (("case02", 5.0, 1), ("case02-10008", percent, seed)):
        of = {"case": {"case": 2, "liquid_percent": liquid}, "settings": {"seed": number, "effects": {}}}
        (folder / name / "config.json").write_text(json.dumps(of))
    (result,) = collect(folder, [config.case(2)])
    assert len(result.seeds) == counted


def test_a_run_of_another_file_or_version_is_no_seed(config: settings.Config, folder: Path) -> None:
    """Configurations are the same; fingerprints without the seed differ, as after a change of a law's file or of pywet."""
    for seed, word in ((10008, "one"), (10009, "other")):
        record.leave_identity(_reseeded(folder / "case02", folder / f"case02-{seed}", seed), f"{seed}", word)
    record.leave_identity(folder / "case02", "10007", "one")
    (result,) = collect(folder, [config.case(2)])
    assert [other["seed"] for other in result.others] == [10008]
    assert Cases(folder, ROOT / "config" / "cases.csv", [2]).seeds(2) == ["case02-10008"]
    record.leave_identity(folder / "case02", "of a version without the second fingerprint")
    (result,), again = collect(folder, [config.case(2)]), Cases(folder, ROOT / "config" / "cases.csv", [2])
    assert [f"case02-{other['seed']}" for other in result.others] == again.seeds(2) == ["case02-10008", "case02-10009"]


def test_a_seed_that_fails_its_checks_is_a_problem_of_its_case(config: settings.Config, folder: Path) -> None:
    """A deviation of 1e-3 in the replay of case02-8: case 2 is not done, for this page and for its check."""
    seed = _reseeded(folder / "case02", folder / "case02-8", 8)
    assert collect(folder, [config.case(2)])[0].done and Cases(folder, ROOT / "config" / "cases.csv", [2]).done(2)
    found = json.loads((seed / "replay.json").read_text())
    found["quantities"]["bridge_volume"]["largest"] = 1e-3
    (seed / "replay.json").write_text(json.dumps(found))
    (result,) = collect(folder, [config.case(2)])
    assert not result.done and not Cases(folder, ROOT / "config" / "cases.csv", [2]).done(2)
    (problem,) = result.problems
    assert problem.startswith("case02-8: the replay disagrees on bridge_volume")


@pytest.mark.parametrize("stage", ["scene", "simulate", "replay"])
def test_a_seed_that_failed_is_a_problem_of_its_case(config: settings.Config, folder: Path, stage: str) -> None:
    """Case 1 is dry; its second seed failed in a stage, with or without results: seeds that fail are no random sample.

    A failed run of another configuration is none of it, and one whose seed was run again elsewhere is not missing."""

    def fail() -> None:
        raise PywetError("LIGGGHTS stopped: lost")

    assert collect(folder, [config.case(1)])[0].done and Cases(folder, ROOT / "config" / "cases.csv", [1]).done(1)
    seed = _reseeded(folder / "case01", folder / "case01-10008", 10008)
    if stage != "replay":
        shutil.rmtree(seed / "results")
    for name in list(stages.NEEDS)[list(stages.NEEDS).index(stage) :]:
        stages.attempt(seed, name, fail if name == stage else lambda: None, aloud=False)
    if stage == "replay":
        assert verdict.check_result(RunDir(seed)).word == "no"
    (result,) = collect(folder, [config.case(1)])
    assert result.problems == (f"case01-10008: stage {stage} failed: LIGGGHTS stopped: lost",)
    assert len(result.ends) == (2 if stage == "replay" else 1)
    assert not Cases(folder, ROOT / "config" / "cases.csv", [1]).done(1)
    again = _reseeded(folder / "case01", folder / "case01-9", 10008)
    if stage != "replay":
        assert collect(folder, [config.case(1)])[0].done
        assert Cases(folder, ROOT / "config" / "cases.csv", [1]).done(1)
    shutil.rmtree(again)
    for name, percent in (("case01", 0.0), ("case01-10008", 5.0)):
        (folder / name / "config.json").write_text(json.dumps({"case": {"liquid_percent": percent}}))
    assert collect(folder, [config.case(1)])[0].done and Cases(folder, ROOT / "config" / "cases.csv", [1]).done(1)


@pytest.mark.parametrize(("first", "counted"), [(10007, [10008, 10009]), (10008, [10009]), (7, [10008, 10009])])
def test_each_seed_counts_once(config: settings.Config, folder: Path, first: int, counted: list[int]) -> None:
    """`pywet run 2 --seeds 3`, then `pywet run 2 --seed 10008`: case02 has the seed of case02-10008; two folders have 10009."""
    for name, seed in (("case02-10008", 10008), ("case02-10009", 10009), ("case02-9", 10009)):
        _reseeded(folder / "case02", folder / name, seed)
    _reseeded(folder / "case02", folder / "case02", first)
    (result,) = collect(folder, [config.case(2)])
    assert sorted(other["seed"] for other in result.others) == counted
    assert len(result.seeds) == len(counted) and len(result.ends) == len(result.over_seeds("wall_s")) == 1 + len(
        counted
    )
    assert len(Cases(folder, ROOT / "config" / "cases.csv", [2]).seeds(2)) == len(counted)


def _reseeded(run: Path, to: Path, seed: int) -> Path:
    """Copy a run, with another seed in its scene and summary."""
    if to != run:
        shutil.copytree(run, to)
    for name in ("scene.json", "summary.json"):
        (to / name).write_text(json.dumps({**json.loads((to / name).read_text()), "seed": seed}))
    return to


def test_the_first_screen_answers(config: settings.Config, folder: Path) -> None:
    """Of what can pass has passed (1 - Y)/(1 - share that cannot pass), Y of the spheres without their liquid; the answer comes
    first, the cross-check last."""
    text = _write(config, folder)
    summary = json.loads((folder / "case02" / "summary.json").read_text())
    table = pd.read_parquet(folder / "case02" / "results" / "fraction_retained.parquet")
    share = 100 * (1 - table["fraction_retained_spheres"].iloc[-1]) / (1 - summary["coarse_share"])
    assert f"{share:.0f} % with 5 % liquid" in text.partition("<nav>")[0]
    assert (
        text.index('id="answer"')
        < text.index('id="moisture"')
        < text.index('id="cases"')
        < text.index('id="agreement"')
    )
    assert "Not cross-checked: case 3." in text


def test_several_seeds_have_an_interval_and_say_what_is_significant() -> None:
    """Means and Student's intervals of the seeds by hand; 0.706 against 0.717 with these spreads is no difference."""
    dry, moist, far = (0.70, 0.72, 0.74, 0.66), (0.71, 0.75, 0.69, 0.72), (0.90, 0.91, 0.89, 0.90)
    numbers = report_numbers.Numbers()
    numbers.spread("retained", dry)
    numbers.spread("passed", answer.passed(dry, 0.2))
    found = [re.sub(r"<.*?>", "", numbers.html(key)) for key in ("retained", "passed")]
    assert found == ["0.705 ± 0.054", "36.9 ± 6.8"]  # 0.054/(1 − 0.2) in per cent
    for key, one, two in (("near", dry, moist), ("far", dry, far), ("one", dry, far[:1])):
        report_numbers.significance(numbers, key, one, two)
    assert [numbers[key]["value"] for key in ("near", "far", "one")] == [
        "not significant",
        "significant",
        "inconclusive",
    ]
    assert numbers["near.low"]["shown"] == "-0.04" + numbers["near.low"]["shown"][5:] and "one.low" not in numbers


@pytest.mark.parametrize(
    ("dry", "moist", "found"),
    [
        ((0.5, 0.5), (0.52, 0.52), "inconclusive"),
        ((0.1 + 0.2, 0.3), (0.7, 0.7), "inconclusive"),
        ((1.0, 1.0), (1.0, 1.0), "inconclusive"),
        ((0.5, 0.5), (0.52, 0.53), "not significant"),
        ((0.5, 0.5), (0.9, 0.901), "significant"),
    ],
)
def test_seeds_that_coincide_show_no_difference(
    dry: tuple[float, float], moist: tuple[float, float], found: str
) -> None:
    """Few seeds may coincide by accident; without scatter (but for round-off) in both groups nothing is known of it.

    With scatter in one: 0.025 ± 12.7 × 0.005, 0.4005 ± 12.7 × 0.0005. The independent check of the page agrees.
    """
    numbers = report_numbers.Numbers()
    report_numbers.significance(numbers, "d", dry, moist)
    assert numbers["d"]["value"] == found and ("d.low" in numbers) is (found != "inconclusive")
    again = {key: value for key, value, _ in report_values._difference("d", dry, moist)}
    assert again.keys() == numbers.keys() and again["d"] == found
    assert [again[key] for key in list(again)[1:]] == pytest.approx([numbers[key]["value"] for key in list(again)[1:]])


def test_the_answer_of_one_configuration_names_each_amount(config: settings.Config, folder: Path) -> None:
    """Case 2 with two seeds that end at 0.5 and 0.7, where 0.8 cannot pass: 250 % and 150 %, 200 ± 12.706 × 50."""
    _seeds_of_case_2(folder)
    text = " ".join(_write(config, folder).split())
    assert ": 100 % dry, 200 ± 635 % with 5 % liquid. 5 % liquid against dry: inconclusive, two seeds of each" in text


def test_the_caveat_of_the_scale_stands_first(config: settings.Config, folder: Path) -> None:
    """Before the first number of the answer: the curves of the paper are for the full scale."""
    text = _write(config, folder)
    assert text.index("the curves of the paper are for the full scale") < text.index('<p class="proof">')


def test_laws_that_were_not_checked_are_listed(config: settings.Config, folder: Path) -> None:
    """Amber on the first screen, the card and the case's row; the kind with a user reference implementation is named too."""
    replayed = folder / "case02" / "replay.json"
    row = {"effect": "capillary", "law": "/home/somebody/my_law.py:neck", "instead": "taken as logged"}
    replayed.write_text(json.dumps({**REPLAY, "unchecked": [row], "second": {"rupture": "/x/second.py:reach"}}))
    text = _write(config, folder)
    assert '<span class="fair">case 2 not checked: capillary (own law)</span>' in text
    assert '<span class="fair">case 2 compared with a reference implementation of the user' in text
    assert '<span class="fair">done; not checked: capillary (own law)</span>' in text
    assert "1 but for laws of their own" in text
    results = collect(folder, [config.case(2)])
    assert answer.agrees(results) and answer.outcome(results) == "agrees but for laws"
    assert "/home/somebody" not in text


def test_kinds_of_which_nothing_was_compared_are_listed(config: settings.Config, folder: Path) -> None:
    """In the sentence on the check, below it and in the case's row; the verdict of the run is `in part`."""
    sentence = "dry contacts with walls: there is none in the sampling windows"
    (folder / "case02" / "replay.json").write_text(json.dumps({**REPLAY, "nothing_compared": [sentence]}))
    text = _write(config, folder)
    assert answer.outcome(collect(folder, [config.case(2)])) == "agrees in part"
    assert f'<span class="fair">case 2 nothing compared: {sentence}</span>' in text
    assert f'<span class="fair">done; nothing compared: {sentence}</span>' in text
    outcome = verdict.check_result(RunDir(folder / "case02"))
    assert (outcome.word, outcome.grade) == ("in part", "fair") and sentence in outcome.sentence


def test_the_word_proven_is_nowhere(config: settings.Config, folder: Path) -> None:
    """A page says what was recomputed, not that anything is proven."""
    assert "proven" not in _write(config, folder).lower()


def test_every_number_of_several_seeds_has_its_interval(config: settings.Config, folder: Path) -> None:
    """Y at end of 0.5 and 0.7: 0.6 ± 12.706 × 0.1 (Student, one degree of freedom); bridges formed of 4 and 6: 5 ± 13."""
    _seeds_of_case_2(folder)
    text = _write(config, folder)
    row = next(line for line in text.split('<section id="cases">')[1].splitlines() if ">0.6 ± " in line)
    assert "<td>0.6 ± 1.3</td>" in row and "<td>5 ± 13</td>" in row
    assert "interval of the mean over the seeds" in text and "inconclusive" in text


def _seeds_of_case_2(folder: Path) -> None:
    """Fraction retained at the end of 0.5 and 0.7, bridges formed of 4 and 6."""
    first = folder / "case02"
    for run, y, formed in ((first, 0.5, 4), (_reseeded(first, folder / "case02-8", 8), 0.7, 6)):
        table = pd.read_parquet(run / "results" / "fraction_retained.parquet")
        table.loc[table.index[-1], ["fraction_retained", "fraction_retained_spheres"]] = y
        table.to_parquet(run / "results" / "fraction_retained.parquet")
        summary = json.loads((run / "summary.json").read_text())
        summary["events"]["formations"] = formed
        (run / "summary.json").write_text(json.dumps({**summary, "fraction_retained_end": y}))


def test_the_wall_time_of_a_resumed_run_is_left_out(config: settings.Config, folder: Path) -> None:
    """It is of some of the steps in the column before it; of several seeds those count that ran in one piece."""
    path = folder / "case02" / "summary.json"
    whole = path.read_text()
    path.write_text(json.dumps({**json.loads(whole), "resumed_at_step": 100}))
    for value, shown, times in ((None, "–", []), (2.0, "2", [2.0])):
        if times:
            (_reseeded(folder / "case02", folder / "case02-8", 8) / "summary.json").write_text(whole)
        _write(config, folder, cases=(2,))
        numbers = json.loads((folder / "report.json").read_text())
        assert numbers["case02.wall_s"] == {"value": value, "shown": shown}
        assert Cases(folder, ROOT / "config" / "cases.csv", [2]).wall_times(2) == times


def test_a_number_of_some_seeds_says_so(config: settings.Config, folder: Path) -> None:
    """A share that one of two seeds does not have: the other's, with a note; the check of the page has it too."""
    _reseeded(folder / "case02", folder / "case02-8", 8)
    path = folder / "case02" / "results" / "screen.json"
    found = json.loads(path.read_text())
    path.write_text(json.dumps({**found, "overs_purity": None}))
    text = _write(config, folder, cases=(2,))
    table = text.partition('<section id="screen">')[2].partition("</section>")[0]
    assert re.findall(r"<td>([^<]*) \(1 of 2 seeds\)</td>", table) == [f"{100 * found['overs_purity']:.3g}"]
    again = report_values._screen(Cases(folder, ROOT / "config" / "cases.csv", [2]), 2)
    some = {key: value for key, value, digits in again if key.endswith(".seeds") and digits != "absent"}
    assert some == {"case02.screen.overs_purity_percent.seeds": "1 of 2"}


def test_pages_that_were_made_are_linked(config: settings.Config, folder: Path) -> None:
    assert "studies/" not in _write(config, folder)
    page = folder.parent / "studies" / "effects.html"
    page.parent.mkdir(exist_ok=True)
    page.touch()
    text = _write(config, folder)
    page.unlink()
    assert '<a href="../studies/effects.html">which effects count</a>' in text and "accuracy.html" not in text


def test_an_empty_picture_is_left_out(config: settings.Config, folder: Path) -> None:
    (folder / "picture.png").touch()
    assert "data:image/png" not in _write(config, folder, folder / "picture.png")


@pytest.mark.parametrize(
    ("loops", "still", "shown"),
    [
        ((1,), True, (None, "still", True)), ((1, 2), True, ("2", "still", True)), ((1,), False, ("1", None, False)),
        ((), False, (None, None, False)),
    ],
)  # fmt: skip
def test_what_is_seen_is_called_by_what_it_is(
    config: settings.Config, tmp_path: Path, loops: tuple[int, ...], still: bool, shown: tuple[object, ...]
) -> None:
    """Case 1 is dry, case 2 moist, and so is the picture: neither the dry loop nor its absence is called moist."""
    results = [CaseResult(config.case(n), (), folder=tmp_path / f"{n}") for n in (1, 2)]
    for n in (1, 2):
        (tmp_path / f"{n}").mkdir()
        (tmp_path / f"{n}" / "movie.webp").write_bytes(f"{n}".encode() if n in loops else b"")
    (tmp_path / "picture.png").write_bytes(b"still" if still else b"")
    seen = report.context("smoke", results, report_numbers.Numbers(), tmp_path / "picture.png")
    found = [seen[name] and base64.b64decode(seen[name].split(",")[1]).decode() for name in ("movie", "picture")]
    assert (*found, seen["moist_picture"]) == shown


def test_statement_says_how_the_scale_departs_from_the_paper(config: settings.Config, folder: Path) -> None:
    smoke = _write(config, folder)
    # Softened to 0.01: the duration of a collision goes with stiffness to the power -1/2.
    assert "0.01 of table 1's stiffness, so collisions take 10 times as long" in smoke
    full = _write(config, folder, scale="full")
    assert "have the stiffness of table 1" in full
    assert "curves end early" not in full


def test_every_assumption_of_the_configuration_is_listed_with_its_reason(config: settings.Config) -> None:
    rows = report_numbers.assumptions(config, "smoke")
    scales = (ROOT / "config" / "scales.yaml").read_text()
    apparatus = scales.split("scales:")[0].count("source: assumption")
    assert sum(path[0] == "apparatus" for path, _, _ in rows) == apparatus
    assert all(len(reason) >= 10 for _, _, reason in rows)


def test_a_source_of_one_word_is_listed_too(config: settings.Config) -> None:
    """Assumed without a reason, measured: both are numbers that the paper does not give."""
    output_text = {
        "viscosity_Pa_s": NonNegativeEntry(value=0.002, source="assumption"),
        "surface_tension_N_per_m": PositiveEntry(value=0.05, source="measured"),
    }
    materials = config.materials.model_copy(update={"liquid": config.materials.liquid.model_copy(update=output_text)})
    rows = {
        ".".join(path): of for path, *of in report_numbers.assumptions(replace(config, materials=materials), "smoke")
    }
    assert rows["materials.liquid.viscosity_Pa_s"] == [0.002, "no reason is given"]
    assert rows["materials.liquid.surface_tension_N_per_m"] == [0.05, "measured"]


def test_cases_with_another_feed_are_not_compared_as_moisture(config: settings.Config) -> None:
    """Their panels and headings differ, and the label of a curve names the liquid of a case that has its own."""
    usual = [config.cases[1], config.cases[2]]
    oily = usual[1].model_copy(update={"liquid": "oil"})
    feeds = [usual[1].model_copy(update=feed) for feed in ({"class_mass_g": 12.5}, {"class_volume_cm3": 12.5})]
    results = [CaseResult(case, ("not run",)) for case in (*usual, oily, *feeds)]
    panels = plots.moisture(results).panels
    assert [len(group) for _, group in panels] == [2, 2, 1, 1]
    ends = ["", ", oil", ", 12.5 g per class", ", 12.5 cm³ per class"]
    assert [title.partition("A = 1 mm")[2] for title, _ in panels] == ends
    assert [plots._moisture(r) for r in results[:3]] == ["dry", "M = 5 %", "M = 5 % oil"]
    for of in results:
        assert states(plots.title(of), plots.configuration_value(of), {})


def test_cases_with_another_liquid_are_not_compared_as_moisture(
    config: settings.Config, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Case 1 is dry, cases 2 and 4 have 5 % of water and of oil: each is compared with case 1, and each has its liquid drawn."""
    shutil.copytree(folder / "case02", folder / "case04")
    oily = config.case(2).model_copy(update={"case": 4, "liquid": "oil"})
    results = [*collect(folder, [config.case(1), config.case(2)]), collect_run(folder / "case04", oily)]
    assert [[r.case.case for r in row] for row in answer.rows(results)] == [[1, 2], [1, 4]]
    assert [[r.case.case for r in group] for _, group in plots.liquid(results).panels] == [[2], [4]]
    assert [title.endswith("M = 5 % oil") for title, _ in plots.liquid(results).panels] == [False, True]
    numbers = report_numbers.Numbers()
    report_numbers._answer(numbers, results)
    output_text = [numbers[f"case0{n}.moisture"]["shown"] for n in (1, 2, 4)]
    assert output_text == ["dry", "5 % liquid", "5 % oil"]
    assert {key for key in numbers if key.endswith(".difference")} == {"case02.difference", "case04.difference"}
    _listed(tmp_path / "cases.csv", "", "oil")
    monkeypatch.setattr(report_values, "_every", report_values._answer)
    count, faults, _ = report_values.wrong(Cases(folder, tmp_path / "cases.csv", [1, 2, 4]), numbers)
    assert faults == [] and count > 12
    monkeypatch.setitem(numbers, "case04.difference", {"value": "significant", "shown": "significant"})
    assert report_values.wrong(Cases(folder, tmp_path / "cases.csv", [1, 2, 4]), numbers)[1]


def _listed(path: Path, *liquids: str) -> Path:
    """Write a list of cases: case 1 dry, cases 2 and 4 with 5 % of these liquids."""
    table = pd.read_csv(ROOT / "config" / "cases.csv", comment="#", dtype=str)
    moist = [table[table["case"] == "2"].assign(case=f"{2 * k}", liquid=of) for k, of in enumerate(liquids, start=1)]
    pd.concat([table[table["case"] == "1"].assign(liquid=""), *moist]).to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    ("liquids", "moist", "found"),
    [
        (("",), (0.5, 0.52), "not significant"),
        (("",), (0.57, 0.59), "significant"),
        (("", "oil"), (0.57, 0.59), "not significant"),
    ],
)
def test_moisture_is_judged_by_the_spheres_at_one_level_for_all_comparisons(
    config: settings.Config,
    folder: Path,
    tmp_path: Path,
    liquids: tuple[str, ...],
    moist: tuple[float, ...],
    found: str,
) -> None:
    """Spheres retained of 0.50 and 0.52 dry; Y of moist seeds is 0.1 more by the liquid alone, which has not passed.

    The standard error of the difference is 0.0141 with two degrees of freedom: 0.07 is beyond t = 4.303 for a level of 5 %,
    and within t = 6.205 for one of 2.5 % with two comparisons. The check of the page agrees.
    """
    if "oil" in liquids:
        shutil.copytree(folder / "case02", folder / "case04")
    cases = [config.case(1), *(config.case(2).model_copy(update={"case": 2 * k, "liquid": name or None})
             for k, name in enumerate(liquids, start=1))]  # fmt: skip
    for case in cases:
        runs = folder / case.name, _reseeded(folder / case.name, folder / f"{case.name}-8", 8)
        for run, end in zip(runs, moist if case.liquid_percent else (0.5, 0.52), strict=True):
            table = pd.read_parquet(run / "results" / "fraction_retained.parquet")
            y = end + (0.1 if case.liquid_percent else 0.0)
            table.loc[table.index[-1], ["fraction_retained", "fraction_retained_spheres"]] = y, end
            table.to_parquet(run / "results" / "fraction_retained.parquet")
            summary = json.loads((run / "summary.json").read_text())
            (run / "summary.json").write_text(json.dumps({**summary, "fraction_retained_end": y}))
    numbers, results = report_numbers.Numbers(), [collect_run(folder / case.name, case) for case in cases]
    report_numbers._answer(numbers, results)
    differences = [numbers[f"{case.name}.difference"]["value"] for case in cases[1:]]
    assert differences == [found] * len(liquids)
    again = Cases(folder, _listed(tmp_path / "cases.csv", *liquids), [case.case for case in cases])
    assert [
        value for key, value, _ in report_values._answer(again, numbers) if key.endswith("difference")
    ] == differences


def test_panels_are_those_of_the_paper_for_the_eighteen_cases(config: settings.Config) -> None:
    results = [CaseResult(case, ("not run",)) for case in config.cases.values()]
    assert [len(group) for _, group in plots.moisture(results).panels] == [3] * 6
    assert [r.case.case for r in plots._strong(results)] == [1, 2, 3, 7, 8, 9, 10, 11, 12, 16, 17, 18]
    for draw in (plots.dry, plots.moisture, plots.classes, plots.liquid):
        panels = plots.apart(draw(results), "figure")
        assert panels and all("<svg" in panel["svg"] for panel in panels)


def test_headings_end_within_their_panel(config: settings.Config) -> None:
    """Of all eighteen cases, also with a liquid amount of three digits behind it."""
    results = [CaseResult(case, ("not run",)) for case in config.cases.values()]
    sheets = [draw(results) for draw in (plots.dry, plots.moisture, plots.classes, plots.liquid)]
    names = [name for sheet in sheets for name, _ in sheet.panels]
    with plots.plt.rc_context(plots.STYLE):
        for name in [*names, f"{max(names, key=len)[:-4]} 12.5 %"]:
            figure, (axes,) = plots.panels(1, 1, (4.2, 4.5))
            plots._panel(axes, sheets[-1], name, results[:1])
            figure.canvas.draw()
            (title,) = [text for text in axes.get_children() if getattr(text, "get_text", str)() == name]
            assert title.get_window_extent().x1 <= figure.bbox.x1, name
            plots.plt.close(figure)


def test_curves_hold_the_numbers_of_the_tables(folder: Path, config: settings.Config) -> None:
    results = collect(folder, [config.case(n) for n in CASES])
    assert [r.done for r in results] == [True, True, False]
    table = results[1].retained
    assert isinstance(table, pd.DataFrame)
    figure = plots.plt.figure()
    axes = figure.subplots()
    plots._draw_moisture(axes, results)
    line = axes.get_lines()[1]
    assert list(line.get_ydata()) == table["fraction_retained"].tolist()
    assert line.get_label() == "M = 5 %"
    plots.plt.close(figure)


def test_a_folder_may_have_colons_in_its_name(folder: Path, config: settings.Config) -> None:
    """Curves, their band and the line of the coarse share keep the whole name; the page is written and names the columns."""
    (result,) = collect(folder, [config.case(2)])
    assert result.retained is not None and result.folder is not None
    named = replace(result, folder=result.folder.rename(folder / "run:band_12:30"), seeds=(result.retained,))
    for sheet, columns in (
        (plots.moisture([named]), {"fraction_retained", "coarse_share"}),
        (plots.liquid([named]), {f"{n}_m3" for n in plots.PLACES if f"{n}_m3" in pd.DataFrame(named.liquid)}),
    ):
        (panel,) = plots.apart(sheet, "figure")
        assert {curve["case"] for curve in json.loads(panel["curves"])} == {"run:band_12:30"}
        keys = {of.key.removeprefix("figure.figure.0.") for of in panel["meanings"]}
        assert keys - {"title", "x", "y"} == {f"run:band_12:30.{column}" for column in columns}


def test_each_share_that_cannot_pass_has_its_line(folder: Path, config: settings.Config) -> None:
    """Three dry cases of one material with two shares: two lines with the name of a case that has it, one entry of the legend."""
    (result,) = collect(folder, [config.case(1)])
    shares = {"a": 0.3, "b": 0.3, "c": 0.6}
    group = [
        replace(result, folder=Path(n), summary={**(result.summary or {}), "coarse_share": s})
        for n, s in shares.items()
    ]
    figure, axes = plots.plt.subplots()
    plots._draw_dry(axes, group)
    plots._label_fraction(axes)
    lines = [line for line in axes.get_lines() if str(line.get_gid()).endswith(plots.COARSE)]
    assert [(line.get_gid(), *set(line.get_ydata())) for line in lines] == [
        ("a:coarse_share", 0.3),
        ("c:coarse_share", 0.6),
    ]
    entries = [text.get_text() for text in axes.get_legend().get_texts()]
    assert len(entries) == len(group) + 1 and entries.count(plots.WORDS[plots.COARSE]) == 1
    plots.plt.close(figure)


def test_a_missing_template_is_named(config: settings.Config, folder: Path) -> None:
    with raises_code("report.no_template"):
        report.write(config, "smoke", CASES, folder, folder, None, folder / "report.html")
