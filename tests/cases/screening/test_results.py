"""Results of the synthetic run, added up by hand (see synthetic.py); all tolerances are round-off."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.screening.results import Results, checks, coarse_share, summarise, write_results
from pywet.laws.contact import film_thickness
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic
from tests.cases.screening.synthetic import UNIT
from tests.error_codes import raises_code

COARSE = 1400 * 4 / 3 * math.pi * 4e-3**3
FINE = 1400 * 4 / 3 * math.pi * 2e-3**3


@pytest.fixture
def moist(tmp_path: Path) -> RunDir:
    return RunDir(synthetic.make(tmp_path / "case02"))


def test_fraction_retained_in_all_counts_liquid_outside_the_bin(moist: RunDir) -> None:
    table = Results.of(moist).retained
    start = COARSE + 2 * FINE + 20e-6
    # Output 3: the coarse sphere with 7.5 + 1.5 + 0.25, and 0.75 on the wires; 0.5 on the collecting bin does not count.
    expected = [1.0, (COARSE + FINE + 15e-6) / start, (COARSE + 10.0e-6) / start]
    np.testing.assert_allclose(table["fraction_retained"], expected, rtol=1e-14)
    np.testing.assert_allclose(table["time_s"], [0.0, 0.01, 0.02], rtol=1e-14)
    np.testing.assert_allclose(table["time_since_opening_s"], [-0.005, 0.005, 0.015], rtol=1e-14)


def test_fraction_retained_per_class_counts_the_liquid_of_the_class(moist: RunDir) -> None:
    table = Results.of(moist).retained
    coarse = [1.0, 1.0, (COARSE + 9.25e-6) / (COARSE + 10e-6)]
    np.testing.assert_allclose(table["fraction_retained_pom_8_mm"], coarse, rtol=1e-14)
    np.testing.assert_allclose(table["fraction_retained_pom_4_mm"], [1.0, 0.5, 0.0], atol=1e-15)


def test_liquid_of_bridges_is_booked_to_each_side_by_the_transfer_share(moist: RunDir) -> None:
    last = Results.of(moist).liquid.iloc[-1] / UNIT
    expected = {
        "coarse_material_m3": 9.25,
        "coarse_material_pom_4_mm_m3": 0.0,
        "fines_m3": 5 + 4 + 0.5,
        "fines_pom_4_mm_m3": 9.5,
        "wires_m3": 0.75,
        "side_wall_m3": 0.0,
        "collecting_bin_m3": 0.5,
        "left_m3": 0.0,
        "total_m3": 20.0,
        "standing_bridges_m3": 3.0,
    }
    assert {k: last[k] for k in expected} == pytest.approx(expected, rel=1e-14, abs=1e-14)
    assert "outlet_m3" not in last


def test_what_breaks_a_check_is_its_value(moist: RunDir) -> None:
    """Y that rises by 0.01, and a millionth of the liquid that nobody has."""
    made = Results.of(moist)
    rising = made.retained.assign(fraction_retained=[0.5, 0.51, 0.2])
    lost = made.liquid.assign(total_m3=made.liquid["total_m3"] * [1.0, 1.0 - 1e-6, 1.0])
    found = {c.name: (c.ok, c.value) for c in checks(moist, rising, lost)}
    assert found["fraction_retained_monotone"] == (False, pytest.approx(0.01, rel=1e-12))
    assert found["liquid_accounted_for"] == (False, pytest.approx(1e-6, rel=1e-9))


def test_checks_hold_and_a_lost_sphere_is_named(moist: RunDir) -> None:
    assert [c.ok for c in write_results(moist).checks] == [True, True, True]
    trajectory = pd.read_parquet(moist.path / "trajectory.parquet")
    trajectory[~((trajectory["step"] == 200) & (trajectory["id"] == 1))].to_parquet(moist.path / "trajectory.parquet")
    lost = {c.name: c for c in write_results(RunDir(moist.path)).checks}["no_particle_lost"]
    assert (lost.ok, lost.value) == (False, 1)
    saved = json.loads((moist.path / "results" / "checks.json").read_text())
    assert saved[0]["text"] == "3 spheres in, 2 on the screen or in the bin at the end, 1 missing at most"


def test_a_sphere_that_bounces_out_of_the_bin_stays_counted_as_passed(moist: RunDir) -> None:
    trajectory = pd.read_parquet(moist.path / "trajectory.parquet")
    trajectory.loc[(trajectory["step"] == 200) & (trajectory["id"] == 2), "z"] = 0.0
    trajectory.to_parquet(moist.path / "trajectory.parquet")
    run = RunDir(moist.path)
    assert run.timeline.came_back == 1
    assert Results.of(run).retained["spheres_in_bin"].tolist() == [0, 1, 2]


def test_the_summary_ends_with_the_last_output(moist: RunDir) -> None:
    """The fraction of the third output, not of the second; written as it is given back."""
    content = summarise(moist, Results.of(moist))
    last = (COARSE + 10.0e-6) / (COARSE + 2 * FINE + 20e-6)
    assert content["fraction_retained_end"] == pytest.approx(last, rel=1e-14)
    assert json.loads((moist.path / "summary.json").read_text()) == json.loads(json.dumps(content))


def test_dry_run_has_no_liquid_and_the_dry_fraction(tmp_path: Path) -> None:
    run = RunDir(synthetic.make(tmp_path / "case01", moist=False))
    made = write_results(run)
    table = made.retained
    np.testing.assert_allclose(table["fraction_retained"], table["fraction_retained_spheres"], rtol=1e-15)
    assert table["fraction_retained"].iloc[-1] == pytest.approx(coarse_share(run.scene), rel=1e-14)
    assert made.liquid["total_m3"].tolist() == [0.0, 0.0, 0.0]
    assert all(c.ok for c in made.checks)


def test_csv_says_the_same_as_parquet(moist: RunDir) -> None:
    write_results(moist)
    for name in ("fraction_retained", "liquid_by_holder"):
        csv = pd.read_csv(moist.path / "results" / f"{name}.csv")
        pd.testing.assert_frame_equal(csv, pd.read_parquet(moist.path / "results" / f"{name}.parquet"), rtol=1e-15)


def test_film_thickness_of_thin_and_thick_films() -> None:
    # A film as thick as the sphere holds 7 times its volume; a thin one is L/(4πr²) to first order in h/r.
    r = 2e-3
    assert film_thickness(np.array(7 * 4 / 3 * math.pi * r**3), np.array(r)) == pytest.approx(r, rel=1e-14)
    assert film_thickness(np.array(1e-18), np.array(r)) == pytest.approx(1e-18 / (4 * math.pi * r**2), rel=1e-9)


def test_a_folder_that_is_no_run_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with raises_code("run.no_scene"):
        write_results(RunDir(tmp_path))


@pytest.mark.parametrize("written", [[0], [0, 100], [0, 50, 100, 200]])
def test_output_steps_must_be_the_planned_ones(moist: RunDir, written: list[int]) -> None:
    path = moist.path / "trajectory.parquet"
    table = pd.read_parquet(path)
    frames = [table[table["step"] == table["step"].unique()[0]].assign(step=step) for step in written]
    pd.concat(frames).to_parquet(path)
    with raises_code("run.output_steps", given=len(written), expected=3):
        write_results(RunDir(moist.path))
    assert not (moist.path / "results").exists()
