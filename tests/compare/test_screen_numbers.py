"""Numbers of a screen in `pywet compare`: first in the table, with intervals within a run where there is one on each side."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from pywet.compare import command, digest, quantities, statistics, verdict
from pywet.products import screening_report
from pywet.runs.rundir import RunDir
from tests.error_codes import raises_code
from tests.products import made_up

NUMBERS = ["cut size", "efficiency", "throughput", "moisture of the overs", "moisture of the unders"]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A continuous run evaluated, and copies with other efficiencies and moistures in screen.json."""
    folder = tmp_path_factory.mktemp("screens")
    first = made_up.make(folder / "0")
    given = screening_report.write(first, aperture_mm=2.5, from_s=0.2)
    del given["options"]  # as if these were the run's own
    (first / "results" / "screen.json").write_text(json.dumps(given))
    for k, (efficiency, moist) in enumerate(((0.05, 0.0), (0.001, 0.5), (0.002, 0.51)), start=1):
        run = shutil.copytree(first, folder / str(k))
        changed = json.loads(json.dumps(given))
        for key in ("efficiency", "efficiency_low", "efficiency_high"):
            changed[key] += efficiency
        changed["moisture_percent_of_dry_mass"]["overs"] += moist
        (run / "results" / "screen.json").write_text(json.dumps(changed))
    return [folder / str(k) for k in range(4)]


@pytest.fixture(autouse=True)
def complete(monkeypatch: pytest.MonkeyPatch) -> None:
    """The made-up run has no plan, ledger or bed: its extent and those quantities are left out."""
    held = {"rows": {}, "outputs": 1, "steps": 1, "planned_outputs": 1, "windows": 0}
    monkeypatch.setattr(quantities, "_whole", lambda run: held)
    monkeypatch.setattr(verdict.whole, "sentence", lambda held: "all")
    for name in ("_liquid", "_counts", "_energies", "_bed", "_checks"):
        monkeypatch.setattr(quantities, name, lambda run: iter(()))


def test_they_come_first_with_their_intervals(runs: list[Path]) -> None:
    """Ends of screen.json; moisture ± its half width."""
    found, given = quantities.read_run(runs[0]), json.loads((runs[0] / "results" / "screen.json").read_text())
    assert list(found.quantities)[:5] == NUMBERS and all(q.of_screen for q in found.quantities.values())
    assert found.quantities["cut size"].interval == (given["d50_low_mm"], given["d50_high_mm"])
    value, half = (given[f"moisture_{key}"]["overs"] for key in ("percent_of_dry_mass", "half_width_percent"))
    assert found.quantities["moisture of the overs"].interval == pytest.approx((value - half, value + half))


def test_one_run_each_by_the_intervals_within_them(runs: list[Path]) -> None:
    """Moisture is off by far more than its interval, the efficiency by less; Holm over the two that differ."""
    found = verdict.compare([runs[0]], [runs[2]])
    rows = {row.quantity: row for row in found.rows}
    wet, sharp = rows["moisture of the overs"], rows["efficiency"]
    given = json.loads((runs[0] / "results" / "screen.json").read_text())
    half = np.sqrt(2.0) * given["moisture_half_width_percent"]["overs"]
    assert wet.interval == pytest.approx(half) and wet.different and wet.verdict == "differs beyond the intervals"
    assert wet.p == pytest.approx(2 * 2 * norm.sf(1.959963984540054 * 0.5 / half))
    above, below = (given[f"efficiency_{end}"] - given["efficiency"] for end in ("high", "low"))
    assert sharp.interval == pytest.approx(np.hypot(above, below))
    assert sharp.verdict == "within the intervals" and not sharp.different
    assert rows["cut size"].verdict == "identical"
    assert found.verdict.startswith(
        "1 of 5 numbers of the screen differ beyond their intervals within one run each: moisture of the overs;"
    )
    assert found.end.startswith("cut size [mm]: A 2.5") and "(95 %, within one run each): not significant" in found.end


def test_a_dry_and_a_moist_run(runs: list[Path], tmp_path: Path) -> None:
    """A number that is 0 in one of them is off by at most all of the other, not by its share of nothing."""
    dry = shutil.copytree(runs[0], tmp_path / "dry")
    given = json.loads((dry / "results" / "screen.json").read_text())
    none = dict.fromkeys(given["moisture_percent_of_dry_mass"], 0.0)
    changed = {**given, "moisture_percent_of_dry_mass": none, "moisture_half_width_percent": none}
    (dry / "results" / "screen.json").write_text(json.dumps(changed))
    for pair in ([[dry], [runs[0]]], [[runs[0]], [dry]]):
        rows = {row.quantity: row for row in verdict.compare(*pair).rows}
        wet = rows["moisture of the overs"]
        assert wet.deviation == pytest.approx(1.0) and wet.different


def test_an_interval_of_no_width_says_nothing(runs: list[Path], tmp_path: Path) -> None:
    """Constant over the window in both runs: that is no certainty, so that the number is named like one without an interval."""
    pair = [shutil.copytree(run, tmp_path / run.name) for run in (runs[0], runs[1])]
    for run in pair:
        path = run / "results" / "screen.json"
        given = json.loads(path.read_text())
        path.write_text(
            json.dumps({**given, "efficiency_low": given["efficiency"], "efficiency_high": given["efficiency"]})
        )
    found = verdict.compare([pair[0]], [pair[1]])
    assert "without an interval, but different: efficiency" in found.verdict and found.different
    assert next(row for row in found.rows if row.quantity == "efficiency").p is None


def test_without_an_interval_they_are_named(runs: list[Path], tmp_path: Path) -> None:
    pair = [shutil.copytree(run, tmp_path / run.name) for run in (runs[0], runs[1])]
    for run in pair:
        path = run / "results" / "screen.json"
        given = json.loads(path.read_text())
        path.write_text(json.dumps({**given, "efficiency_low": None, "efficiency_high": None}))
    found = verdict.compare([pair[0]], [pair[1]])
    assert "without an interval, but different: efficiency" in found.verdict and found.different


def test_a_cut_size_that_is_not_enclosed_is_named(
    runs: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Absent on one side it is not compared, with the reason; at an end of the sizes it is compared and named."""
    pair = [shutil.copytree(runs[0], tmp_path / name) for name in "ab"]
    path = pair[1] / "results" / "screen.json"
    given = json.loads(path.read_text())
    for size, where in ((None, "above the largest size"), (given["d50_mm"], "at the largest size")):
        path.write_text(json.dumps({**given, "d50_mm": size, "d50_position": where}))
        found = verdict.compare([pair[0]], [pair[1]])
        assert found.notes == [f"cut size: {where} in {pair[1]}"]
        assert ("cut size" in found.left_out) == (size is None)
        command.show(found)
        assert found.notes[0] in capsys.readouterr().out.splitlines()


def test_the_numbers_of_the_screen_and_checks_decide(
    runs: list[Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Other quantities of two single runs differ always, as a bed is chaotic: only 1 and 2 differ in a number of the screen."""
    monkeypatch.setattr(
        quantities, "_counts", lambda run: iter([quantities._number("ruptures", "events", at(run), 1.0)])
    )

    def at(run: RunDir) -> float:
        return float(run.path.name)

    for pair, code in (((0, 1), 0), ((0, 2), 1)):
        assert command.compare([runs[k] for k in pair], (), (), None, False, None) == code
        assert "which do not decide" in capsys.readouterr().out
        rows = {row.quantity: row for row in verdict.compare(*([runs[k]] for k in pair)).rows}
        assert rows["ruptures"].different
    monkeypatch.setattr(quantities, "_checks", lambda run: iter([("replay", (run.path != runs[1], 0.0))]))
    assert command.compare([runs[0], runs[1]], (), (), None, False, None) == 1


def test_a_deck_that_is_not_steady_is_named(
    runs: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """By `pywet compare` in its output, by `pywet digest` and `--digest` in notices."""
    moving = shutil.copytree(runs[0], tmp_path / "moving")
    given = json.loads((moving / "results" / "screen.json").read_text())
    (moving / "results" / "screen.json").write_text(json.dumps({**given, "steady": False, "from_s": 1.5}))
    found = verdict.compare([runs[0]], [moving])
    assert found.notes == [f"not steady: means over the last 0.5 s of the feed in {moving}"]
    command.show(found)
    assert found.notes[0] in capsys.readouterr().out.splitlines()
    digest.check(digest.of_runs("decks", "command", [moving]), moving)
    assert caplog.text.count(f"{moving}: not steady: means over the last 0.5 s of the feed") == 2


def test_another_film_on_some_spheres_is_another_scene(runs: list[Path], tmp_path: Path) -> None:
    """The thickest film is the same, that of the fines is not; dry scenes have none. The key liquid allows for it, too."""
    other = shutil.copytree(runs[0], tmp_path / "other")
    path = other / "history" / "spheres.parquet"
    spheres = pd.read_parquet(path)
    spheres["film"] = spheres["film"].where(spheres["type"] != 1, 3.0 * spheres["film"])
    spheres.to_parquet(path)
    with raises_code("compare.scenes", given=("initial films",)):
        verdict.compare([runs[0]], [other])
    for across in ("liquid", "initial films"):
        assert not verdict.compare([runs[0]], [other], across=[across]).different
    with raises_code("digest.scenes", key="initial films"):
        digest.of_runs("films", "command", [runs[0], other])
    spheres.assign(film=spheres["film"] * (1.0 + 1e-12)).to_parquet(path)
    assert not verdict.compare([other], [shutil.copytree(other, tmp_path / "same")]).different


def test_seeds_of_both_sides(runs: list[Path]) -> None:
    """Two seeds each: by the spread of the seeds, and the verdict names the number of the screen."""
    found = verdict.compare(runs[:2], runs[2:], force=True)
    rows = {row.quantity: row for row in found.rows}
    overs = [[json.loads((r / "results" / "screen.json").read_text())["moisture_percent_of_dry_mass"]["overs"] for r in g]
             for g in (runs[:2], runs[2:])]  # fmt: skip
    half = statistics.of_difference(*(np.array(values) for values in overs))
    assert rows["moisture of the overs"].interval == pytest.approx(half)
    assert rows["moisture of the overs"].different
    assert found.verdict.startswith("1 of 5 numbers of the screen (moisture of the overs) and 0 of 0 other quantities")


def test_options_of_an_evaluation_change_no_comparison(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A run evaluated with another aperture and period is compared as it is without, with a notice."""
    runs = [made_up.make(tmp_path / name) for name in "ab"]
    whole, _ = (screening_report.write(run) for run in runs)
    asked = screening_report.write(runs[1], aperture_mm=3.5, from_s=1.0)
    assert asked["efficiency"] != whole["efficiency"] and asked["options"] == {"aperture": 3.5, "from": 1.0}
    assert screening_report.stored(runs[0]) == whole and "evaluated" not in caplog.text
    found = verdict.compare([runs[0]], [runs[1]])
    assert {row.verdict for row in found.rows if row.quantity in NUMBERS} == {"identical"}
    assert "b was last evaluated with --aperture 3.5 --from 1" in caplog.text
    again = screening_report.stored(runs[1])
    assert again is not None and again["efficiency"] == whole["efficiency"]
    assert caplog.text.count("was last evaluated") == 1
