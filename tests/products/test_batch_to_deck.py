"""A deck predicted from batch kinetics: closed forms of plug flow and mixing, made-up runs whose answer is known, refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.products import batch_to_deck, kinetics
from pywet.products.batch_to_deck import Residence
from pywet.util.files import read_table, write_json, write_table
from tests.error_codes import raises_code
from tests.products import made_up
from tests.products.test_kinetics import stored

FIRST_ORDER, K, DELAY = kinetics.LAWS[0], 3.0, 0.02
TIMES = np.linspace(0.0, 1.0, 201)


def test_plug_flow_and_a_mixer_in_closed_form() -> None:
    """First order and one residence time L/v: exp(-k L/v); with exponential residence times of mean tau: 1/(1 + k tau)."""
    length, speed, tau = 0.12, 0.2, 0.6
    one, half = batch_to_deck.share_retained(FIRST_ORDER, np.array([0.0, K]), Residence.of(np.array([length / speed])))
    assert one == pytest.approx(np.exp(-K * length / speed), rel=1e-12) and np.isnan(half)  # scatter of one sphere
    quantiles = (np.arange(200_000) + 0.5) / 200_000
    times = Residence.of(-tau * np.log1p(-quantiles))
    mixed, _ = batch_to_deck.share_retained(FIRST_ORDER, np.array([0.0, K]), times)
    assert mixed == pytest.approx(1.0 / (1.0 + K * tau), rel=1e-4)
    plug, _ = batch_to_deck.plug_flow(FIRST_ORDER, np.array([0.0, K]), times)
    assert plug == pytest.approx(np.exp(-K * tau), rel=1e-4)


def test_the_interval_of_a_mean_covers_it() -> None:
    """In 400 draws of 50 exponential residence times each, the 95 % interval holds 1/(1 + k tau) in 92 to 98 % of them."""
    random, tau = np.random.default_rng(3), 0.6
    held = 0
    for _ in range(400):
        mean, half = batch_to_deck.share_retained(
            FIRST_ORDER, np.array([0.0, K]), Residence.of(random.exponential(tau, 50))
        )
        held += abs(mean - 1.0 / (1.0 + K * tau)) < half
    assert 0.92 < held / 400 < 0.98


def inserted_to_the_end(
    stay_s: float, run_s: float, number: int, random: np.random.Generator
) -> tuple[np.ndarray, ...]:
    """Exponential stays of spheres that enter at a constant rate until the end: of those that left, and so far of the others."""
    entered, stay = run_s * (np.arange(number) + 0.5) / number, random.exponential(stay_s, number)
    out = entered + stay < run_s
    return stay[out], run_s - entered[~out]


def test_spheres_that_are_on_the_deck_at_the_end_count() -> None:
    """Stays of 5 s on average in 20 s, k = 0.2/s: 1/(1 + 0.2 × 5) = 0.5; of those that left alone the mean is 3.5 s, and 0.58."""
    values, random = np.array([0.0, 0.2]), np.random.default_rng(4)
    left, inside = inserted_to_the_end(5.0, 20.0, 40_000, random)
    alone, every = Residence.of(left), Residence.of(left, inside)
    assert left.mean() == pytest.approx(3.50, abs=0.05)
    assert batch_to_deck.share_retained(FIRST_ORDER, values, alone)[0] == pytest.approx(0.58, abs=0.01)
    share, half = batch_to_deck.share_retained(FIRST_ORDER, values, every)
    assert share == pytest.approx(0.5, abs=0.005) and half < 0.005
    beyond = np.exp(-4.0)  # longer than the run; they count with its length
    assert every.mean(every.time_s)[0] == pytest.approx(5.0 * (1.0 - beyond), abs=0.15)
    assert every.weight[-1] == pytest.approx(beyond, abs=0.01) and every.time_s[-1] == pytest.approx(20.0, abs=0.01)
    found = [
        batch_to_deck.share_retained(FIRST_ORDER, values, Residence.of(*inserted_to_the_end(5.0, 20.0, 80, random)))
        for _ in range(400)
    ]
    assert 0.92 < np.mean([abs(mean - 0.5) < half for mean, half in found]) < 0.98


def test_residence_times_are_those_of_another_library_and_of_plain_means() -> None:
    """Kaplan-Meier by SciPy; without spheres on the deck mean and standard error of a sample."""
    left, inside = inserted_to_the_end(5.0, 20.0, 200, np.random.default_rng(5))
    left = left.round(1)  # with ties
    found = Residence.of(left, inside.round(1))
    other = stats.ecdf(stats.CensoredData(uncensored=left, right=inside.round(1))).cdf
    assert np.cumsum(found.weight)[:-1] == pytest.approx(other.evaluate(found.time_s[:-1]), abs=1e-12)
    alone = Residence.of(left)
    assert alone.mean(alone.time_s) == pytest.approx((left.mean(), left.std(ddof=1) / np.sqrt(len(left))), rel=1e-9)


def test_tracers_on_the_deck_at_the_end_are_counted_and_reported(tmp_path: Path) -> None:
    """Ten of the 40 coarsest spheres of the made-up deck do not leave: beyond 0.12 s a quarter of them is there."""
    deck = made_up.make(tmp_path / "deck")
    path = deck / "history" / "retired.parquet"
    gone = read_table(path)
    stuck = sorted(gone.loc[gone["type"] == 4, "id"])[:10]
    write_table(gone[~gone["id"].isin(stuck)], path)
    seeds = [batch(tmp_path / f"batch{n}", {"3 mm": k}) for n, k in enumerate((2.0, 2.1))]
    row = batch_to_deck.predict(seeds, deck).iloc[0]
    assert row["tracers"] == made_up.EACH and row["tracers_inside"] >= 10
    assert row["unobserved"] == pytest.approx(10 / 39, abs=0.02)
    first = np.array(made_up.scene().enters([4] * made_up.EACH))[0] * made_up.STEP
    longest = 2.0 - first  # of the first sphere that entered
    low = (1.0 - row["unobserved"]) * np.exp(-2.05 * (0.12 - DELAY)) + row["unobserved"] * np.exp(-2.05 * longest)
    assert low < row["residence_times"] < low + 0.02
    printed = CliRunner().invoke(app, ["kinetics", *map(str, seeds), "--deck", str(deck)])
    assert f"{row['tracers_inside']} of 40 spheres of the coarsest class are on the deck at the end" in printed.output


def batch(folder: Path, rates: dict[str, float]) -> Path:
    """Stored tables of a batch whose classes pass by first order from a delay on."""
    return stored(folder, TIMES, {name: FIRST_ORDER(TIMES, DELAY, k) for name, k in rates.items()})


def test_a_made_up_deck(tmp_path: Path) -> None:
    """All of its spheres stay 0.1 s, and up to 0.02 s more until the next look; what does not pass in the batch stays."""
    deck = made_up.make(tmp_path / "deck")
    seeds = [batch(tmp_path / f"batch{n}", {"2 mm": 5.0, "3 mm": k, "4 mm": 0.0}) for n, k in enumerate((2.0, 2.0))]
    found = batch_to_deck.predict(seeds, deck).set_index("class")
    entered = np.array(made_up.scene().enters([4] * made_up.EACH))
    stay = made_up.STEP * (np.ceil((entered + 100) / made_up.EVERY) * made_up.EVERY - entered)
    stay = stay[entered * made_up.STEP + stay < 2.0]  # the others have not left at the end
    assert list(found.index) == ["2 mm", "3 mm", "4 mm"] and found["T"].tolist() == pytest.approx(
        [0.25, 0.75, 1.0], abs=0.1
    )
    for name, k in (("2 mm", 5.0), ("3 mm", 2.0)):
        assert found.loc[name, "residence_times"] == pytest.approx(np.exp(-k * (stay - DELAY)).mean(), rel=1e-3)
        assert found.loc[name, "plug_flow"] == pytest.approx(np.exp(-k * (stay.mean() - DELAY)), rel=1e-3)
    assert found.loc["4 mm", ["plug_flow", "residence_times"]].tolist() == [1.0, 1.0]
    one = CliRunner().invoke(app, ["kinetics", str(seeds[0]), "--deck", str(deck)])
    alone = batch_to_deck.predict(seeds[:1], deck).set_index("class")
    assert one.exit_code == 0 and f"{100 * alone.loc['3 mm', 'plug_flow']:.1f}  " in one.output  # ± what is not known
    assert np.isnan(alone.loc["3 mm", "plug_flow_half"])
    out = tmp_path / "found.csv"
    printed = CliRunner().invoke(app, ["kinetics", *map(str, seeds), "--deck", str(deck), "--out", str(out)])
    assert printed.exit_code == 0 and f"{100 * found.loc['3 mm', 'plug_flow']:.1f} ±" in printed.output
    assert pd.read_csv(out)["plug_flow"].to_numpy() == pytest.approx(found["plug_flow"].to_numpy(), rel=1e-9)


def made_batch(folder: Path, outlet: int = 2, inserted: bool = False) -> Path:
    """The made-up run as a batch: all spheres are there from the start and leave through one outlet."""
    run = made_up.make(folder)
    scene = json.loads((run / "scene.json").read_text())
    if not inserted:
        for kind in scene["classes"]:
            kind["insertion"] = None
    write_json(run / "scene.json", scene)
    path = run / "history" / "retired.parquet"
    write_table(read_table(path).assign(outlet=outlet), path)
    return run


def test_a_batch_with_outlets_is_counted(tmp_path: Path) -> None:
    found = kinetics.curves(made_batch(tmp_path / "batch"))
    gone = read_table(tmp_path / "batch" / "history" / "retired.parquet")
    for k, name in enumerate(("1 mm", "2 mm", "3 mm", "4 mm"), start=1):
        left = gone.loc[gone["type"] == k, "time"].to_numpy()
        share = (left[None, :] <= found["time_s"].to_numpy()[:, None] + 1e-9).sum(axis=1) / made_up.EACH
        assert found[name].to_numpy() == pytest.approx(1.0 - share, abs=1e-12) and len(left) > 30


def test_what_is_no_batch_or_no_tracer_is_refused(tmp_path: Path) -> None:
    with raises_code("kinetics.no_batch"):
        kinetics.curves(made_batch(tmp_path / "inserted", inserted=True))
    with raises_code("kinetics.no_batch", says="spheres through overs;"):
        kinetics.curves(made_batch(tmp_path / "overs", outlet=1))
    spilled = made_batch(tmp_path / "spilled")
    scene = json.loads((spilled / "scene.json").read_text())
    scene["outlets"].append({**scene["outlets"][0], "name": "spilled_left", "product": None})
    write_json(spilled / "scene.json", scene)
    path = spilled / "history" / "retired.parquet"
    gone = read_table(path)
    write_table(gone.assign(outlet=gone["outlet"].where(gone["id"] > 3, 3)), path)
    with raises_code("kinetics.no_batch", says="loses 3 spheres through spilled_left;"):
        kinetics.curves(spilled)
    deck, other = made_up.make(tmp_path / "deck"), batch(tmp_path / "other", {"5 mm": 1.0})
    with raises_code("kinetics.other_classes"):
        batch_to_deck.predict([other], deck)
    path = deck / "history" / "retired.parquet"
    write_table(read_table(path).assign(outlet=2), path)
    with raises_code("kinetics.no_tracer"):
        batch_to_deck.predict([other], deck)
