"""Laws of batch kinetics: parameters are found again, the right law is ranked first, stored full-scale runs are fitted."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet import stages
from pywet.cli.app import app
from pywet.products import kinetics
from pywet.runs import record
from pywet.runs.distinct_seeds import distinct_seeds
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic
from tests.error_codes import raises_code

DATA = Path(__file__).parents[2] / "docs" / "full_scale" / "data"
SEEDS = (10007, 10009, 10012)
TIMES = np.linspace(0.0, 20.0, 201)
TRUE = {
    "first order": (0.4, 0.5), "first order, residue": (0.4, 0.5, 0.2), "second order": (0.4, 0.5),
    "power of time": (0.4, 0.5, 0.7), "two rates": (0.4, 0.6, 1.0, 0.1), "crowded, then first order": (0.4, 0.2, 2.0),
}  # fmt: skip
"""Delay and parameters."""


@pytest.mark.parametrize("law", kinetics.LAWS, ids=lambda law: law.name)
def test_parameters_are_found_again(law: kinetics.Law) -> None:
    """Exactly without noise; with noise s = 0.01 of n points, p parameters leave the curve an error of s sqrt(p/n); thrice."""
    y = law(TIMES, *TRUE[law.name])
    assert kinetics.fit(law, TIMES, y) == pytest.approx(TRUE[law.name], rel=1e-3)
    noisy = kinetics.fit(law, TIMES, y + np.random.default_rng(1).normal(0.0, 0.01, len(TIMES)))
    assert 0.0 < kinetics.rms(law, noisy, TIMES, y) < 3.0 * 0.01 * np.sqrt(len(noisy) / len(TIMES))


def test_laws_begin_at_one_and_the_crowded_one_is_smooth() -> None:
    for law in kinetics.LAWS:
        assert law(np.array([0.0, 0.3]), *TRUE[law.name]) == pytest.approx([1.0, 1.0])
    law = kinetics.LAWS[-1]
    y = law(np.array([2.4 - 1e-6, 2.4, 2.4 + 1e-6]), *TRUE[law.name])
    assert np.diff(y) == pytest.approx([-0.2e-6, -0.2e-6], rel=1e-3)


def test_no_law_falls_below_zero_however_long() -> None:
    """A curve that is straight to its end: the constant rate does not go on when all has passed."""
    t = np.linspace(0.0, 3.0, 61)
    y = 1.0 - 0.3 * np.maximum(t - 0.1, 0.0) + np.random.default_rng(1).normal(0.0, 0.003, len(t))
    for law in kinetics.LAWS:
        beyond = law(np.linspace(0.0, 30.0, 301), *kinetics.fit(law, t, y))
        assert beyond.min() >= 0.0 and beyond.max() <= 1.0


def test_a_curve_of_a_few_hundredths_of_a_second_is_fitted() -> None:
    t = np.linspace(0.0, 0.06, 7)
    values = kinetics.fit(kinetics.LAWS[0], t, kinetics.LAWS[0](t, 0.01, 2.0))
    assert values == pytest.approx([0.01, 2.0], rel=1e-3)


@pytest.mark.parametrize("right", ["power of time", "crowded, then first order"])
def test_the_right_law_is_ranked_first(right: str) -> None:
    """On seeds that were not fitted, where first order is wrong by several per cent."""
    law, random = next(w for w in kinetics.LAWS if w.name == right), np.random.default_rng(2)
    runs = [
        pd.DataFrame({"time_s": TIMES, "small": law(TIMES, *TRUE[right]) + random.normal(0.0, 0.005, len(TIMES))})
        for _ in range(3)
    ]
    table = kinetics.ranking(runs, "small")
    assert table["law"].iloc[0] == right and table["rms_held_out"].iloc[0] == pytest.approx(0.005, rel=0.15)
    assert table.set_index("law")["rms_held_out"]["first order"] > 0.009  # more than 1.8 times the noise


def test_stored_full_scale_runs() -> None:
    """Case 2, three seeds: passage is slower at first (a power of time above 1); what does not pass has no kinetics."""
    table = kinetics.kinetics([DATA / f"case02-{seed}" for seed in SEEDS])
    assert set(table["class"]) == {"small", "near_mesh"} and len(table) == 2 * len(kinetics.LAWS)
    small = table[table["class"] == "small"].set_index("law")["rms_held_out"]
    assert small.idxmin() == "power of time" and small.min() < 0.01 and small["first order"] > 1.5 * small.min()
    best = table[(table["class"] == "small") & (table["law"] == "power of time")]["parameters"].iloc[0]
    each = [
        kinetics.fit(kinetics.LAWS[3], *kinetics.points(kinetics.curves(DATA / f"case02-{k}"), "small")) for k in SEEDS
    ]
    assert best.endswith(f"n {np.mean(each, axis=0)[-1]:.4g} ± 0.16")


def test_one_run_has_no_intervals() -> None:
    """In the table and in the terminal: the outputs of one run are no independent points, three seeds have n 1.345 ± 0.16."""
    single = kinetics.kinetics([DATA / f"case02-{SEEDS[0]}"])
    assert single["rms_held_out"].isna().all() and not single["parameters"].str.contains("±").any()
    named = single.set_index(["class", "law"])["parameters"]["small", "power of time"]
    assert re.fullmatch(r"t0 0\.\d+, k 0\.\d+, n 1\.386", named)
    one, two = (
        CliRunner().invoke(app, ["kinetics", *(str(DATA / f"case02-{seed}") for seed in SEEDS[:n])]).output
        for n in (1, 2)
    )
    assert "±" not in one and "give several seeds for intervals" in " ".join(one.split())
    assert "± 95 %" in " ".join(two.split()) and "one run" not in two


@pytest.mark.parametrize("law", ["first order", "power of time"])
def test_the_interval_of_several_seeds_belongs_to_the_value_before_it(law: str) -> None:
    """Seeds of first order with one rate and other delays: the law of all seeds together has another rate, and n = 1.6."""
    runs = [pd.DataFrame({"time_s": TIMES, "small": kinetics.LAWS[0](TIMES, t0, 0.6)}) for t0 in (0.2, 2.2, 1.2)]
    printed = kinetics.ranking(runs, "small").set_index("law")["parameters"][law]
    for name, true in {"t0": 1.2, "k": 0.6, "n": 1.0}.items():
        for value, half in re.findall(rf"\b{name} (\S+) ± ([^\s,]+)", printed):
            assert float(value) == pytest.approx(true, abs=float(half) + 1e-4)


def stored(folder: Path, times: Any, above: dict[str, Any], **facts: Any) -> Path:
    """Tables of a case as the repository stores them, with the spheres that have not passed."""
    folder.mkdir(exist_ok=True)
    pd.DataFrame({"time_since_opening_s": times}).to_csv(folder / "fraction_retained.csv", index=False)
    spheres = pd.DataFrame({f"above_{name}": 1e3 * y for name, y in above.items()}, index=range(len(times)))
    spheres.to_csv(folder / "spheres.csv", index=False)
    (folder / "run.json").write_text(json.dumps(facts))
    return folder


def test_liquid_that_leaves_a_class_is_no_passage(tmp_path: Path) -> None:
    """With shedding the large spheres lose 2.8 % of their mass, all of it liquid, and none passes; a run counts spheres, too."""
    table = kinetics.kinetics([DATA / "case02-shedding-10007"])
    assert set(table["class"]) == {"small", "near_mesh"}
    run = synthetic.make(tmp_path / "run", moist=True)
    stages.results(run)
    wet = RunDir(run).table("results/fraction_retained")
    found = kinetics.curves(run)
    assert found["POM 4 mm"].tolist() == [0.5, 0.0] and found["POM 8 mm"].tolist() == [1.0, 1.0]
    assert wet["fraction_retained_pom_8_mm"].iloc[-1] != 1.0


def test_another_case_is_no_seed(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Of stored tables by their case, of runs by their fingerprints, even with one seed and the same initial spheres."""
    alone = kinetics.kinetics([DATA / "case01-10007"])
    for other in ("case02-10009", "case01-paper-10007"):
        caplog.clear()
        assert kinetics.kinetics([DATA / "case01-10007", DATA / other]).equals(alone)
        assert f"{other} was run with another configuration" in caplog.text
    once = kinetics.kinetics([DATA / "case01-10007", DATA / "case01-10007"])
    assert once.equals(alone) and "each seed is counted once" in caplog.text
    runs = [synthetic.make(tmp_path / name, moist=False) for name in ("case01", "case02")]
    for run in runs:
        record.leave_identity(run, f"{run.name}, seed 1", run.name)
    caplog.clear()
    assert distinct_seeds(runs) == runs[:1] and "another configuration" in caplog.text and "seed 1" not in caplog.text


def test_each_seed_counts_once(tmp_path: Path) -> None:
    """A run with the seed of another adds nothing to the fits, and is not taken for data that were not fitted."""
    for name, seed in (("one", 1), ("two", 2), ("again", 1)):
        stored(tmp_path / name, TIMES, {"small": np.exp(-seed * TIMES)}, seed=seed)
    one, two, again = (tmp_path / name for name in ("one", "two", "again"))
    assert kinetics.kinetics([one, two, again]).equals(kinetics.kinetics([one, two]))
    assert kinetics.kinetics([one, again])["rms_held_out"].isna().all()


def test_what_has_no_curve_is_refused(tmp_path: Path) -> None:
    with raises_code("kinetics.no_curve"):
        kinetics.kinetics([tmp_path])
    with raises_code("kinetics.none_passes"):
        kinetics.kinetics([stored(tmp_path, TIMES, {"large": 1.0})])
