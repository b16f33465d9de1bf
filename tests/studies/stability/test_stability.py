"""The stability study: reproducible cases, its parts against the workflow, and what the cases brought to light."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from pywet.cli.app import app
from pywet.laws.exact_bridge import rupture
from reference_impl.replay import exact, laws
from studies.stability import hard_scenes, maps, page, random_cases, running, study
from studies.stability.study import StabilityStudy
from tests.test_docs import check_shown


def test_the_same_seed_gives_the_same_cases() -> None:
    """Bit for bit; another seed gives others."""
    one, two, other = (
        random_cases.draw_batch(1, 3, 20),
        random_cases.draw_batch(1, 3, 20),
        random_cases.draw_batch(2, 3, 20),
    )
    assert one.cells[0].bodies == two.cells[0].bodies and one.time_step == two.time_step
    assert one.time_step != other.time_step


def test_cases_cover_the_stated_ranges() -> None:
    """Over 40 batches: radii from 20 um to 10 mm, size ratio to 10, liquids from none to 10 Pa s; steps within the advisor's."""
    batches = [random_cases.draw_batch(1, n, 1) for n in range(40)]
    radii = np.array([[c.radius_m for c in b.classes] for b in batches])
    assert radii.min() >= 20e-6 and radii.max() <= 10e-3 * (1 + 1e-12)
    assert (radii[:, 1] / radii[:, 0]).max() > 8.0
    viscosity = [b.liquid.viscosity_Pa_s for b in batches]
    assert min(viscosity) == 0.0 and 1.0 < max(viscosity) <= 10.0
    assert {b.how for b in batches} == {"explicit", "semi_implicit"} and {b.ranks for b in batches} == {1, 2}
    assert all(b.time_step < 0.3 * random_cases.allowed_step(b) for b in batches[:3])


def test_every_map_row_scene_and_case_is_a_job() -> None:
    """40 batches of 50 are 2000 cases, and the last batch holds the rest."""
    study = StabilityStudy(Path("unused"))
    assert len(study.batches) == 40 and len(study.jobs()) == 6 + 6 + 7 + 7 + 7 + 8 + 40
    assert [run.given["count"] for job in StabilityStudy(Path("unused"), 120).batches for run in study.runs(job)] == [
        50
    ] * 3
    short = StabilityStudy(Path("unused"), 120)
    assert [run.given["count"] for job in short.batches for run in short.runs(job)] == [50, 50, 20]


def test_a_longer_study_does_the_short_batch_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """20 cases are stored of a call that asked for no more: a call for 60 has 60."""
    monkeypatch.setattr(running, "judged", lambda batch, work: pd.DataFrame([{"case": c.name} for c in batch.cells]))
    monkeypatch.setattr(study, "FINE", ())
    monkeypatch.setattr(StabilityStudy, "_rows", lambda self, make, work: make(work).to_dict("records"))
    for cases in (20, 60):
        now = StabilityStudy(tmp_path, cases)
        for job in now.batches:
            now.do(job)
        assert len(now.gather(now.batches)) == cases


def test_the_command_prints_where_its_page_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The command of the page with one batch of cases, in place of the engine one that stops every cell."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(running, "run_cells", lambda batch, *_, **__: (batch, {c.name: "stopped" for c in batch.cells}))
    command = "pywet study stability --cases 2000 --seed 1"
    done = CliRunner().invoke(app, [*command.split()[1:], "--cases", "50"])
    assert done.exit_code == 0, done.output
    check_shown(command, done.stdout)
    assert "50 hard cases" in (tmp_path / "results" / "studies" / "stability.html").read_text()


@pytest.mark.engine
def test_a_cell_that_stops_the_run_is_quieted(tmp_path: Path) -> None:
    """The two that guards object to are named; the third comes through, and its liquid is whole."""
    batch, stopped = running.run_cells(hard_scenes.out_of_the_box(), tmp_path / "run", allow_unstable=True)
    assert set(stopped) == {"too fast for the step", "pressed too deep"}
    assert "lower the time step" in stopped["too fast for the step"] and "overlaps" in stopped["pressed too deep"]
    assert len(batch.cells) == 3


def test_share_of_a_bridge_that_swallows_a_wire() -> None:
    """A meridian that meets the large body beyond its equator widens before it narrows: its neck is still found.

    Against the independent solution, 1e-9 as both are converged to better.
    """
    thin = 1.0 / 7.0
    for volume in (0.3, 0.4, 0.5):
        other = exact.end((volume, 1.0, thin, 0.0, 0.0))
        assert other is not None
        mine = rupture(volume, 1.0, thin, 0.0, 0.0)
        assert mine.transfer_ratio == pytest.approx(other.transfer_ratio_i, abs=1e-9)
        assert mine.transfer_ratio < 1.0


def test_dynamic_rupture_without_surface_tension() -> None:
    """The static distance holds, also at rest, where the formula would be 0/0."""
    assert (laws.pitois_factor(np.array([0.0, 0.1]), 1e-3, 0.0) == 1.0).all()


def test_score_counts_both_sides_of_the_line() -> None:
    """Points within and beyond the advisor's line."""
    table = pd.DataFrame({"limit": [2.0, 2.0, 0.5, 0.5], "state": ["stable", "energy", "stable", "stopped"]})
    assert page.score(table) == (
        "Within the line 1 of 2 points are stable to 1 % of energy, 1 make more, 0 stop; beyond it 1 of 2 are still stable."
    )


def test_advised_step_for_the_energy_of_a_contact() -> None:
    """k dt^2/m = 0.04 for a pair of elastic spheres: a quarter of it, 1 %, is what a collision can make."""
    batch = maps.stiffness_batch(1.0)
    one = maps.stiffness_limit(float(maps.STIFFNESSES[0]), 1.0) * maps.STEP_STIFFNESS
    m = 0.5 * batch.classes[0].mass_kg
    assert one <= 2.0 * math.sqrt(m / maps.STIFFNESSES[0]) * (1.0 + 1e-9)
