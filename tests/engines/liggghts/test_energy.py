"""Energy: the works of all effects add up to the change of kinetic energy, and the capillary work to the energy stored."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.schema import WORKS
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R = 2.5e-3
SECONDS = 0.03


def gap_of(energy: pd.DataFrame) -> pd.Series:
    """Change of kinetic energy that the works do not account for [J]."""
    moving = energy["kinetic"] + energy["spin"]
    return moving - moving.iloc[0] - energy[WORKS].sum(axis=1)


def bed_energy(run_dir: Path, ranks: int = 1) -> pd.DataFrame:
    """Energy table of a moist bed on a vibrating floor, a plate being drawn through it."""
    spheres = beds.bed((6, 6, 6))
    beds.prepare(run_dir, spheres, 1000)
    small.run(run_dir, spheres, ranks)
    return beds.table(run_dir, "history/energy")


def test_budget_of_a_bed_closes(tmp_path: Path) -> None:
    """With the half kicks at both ends the budget is an identity of the integrator: round-off of 1000 steps, 1e-12 of the sum.

    Every term takes part: none of them is zero in this bed.
    """
    energy = bed_energy(tmp_path, 2)
    turnover = energy[WORKS].abs().sum(axis=1).iloc[-1]
    assert (gap_of(energy) - energy["half_kick"]).abs().max() < 1e-12 * turnover
    assert (energy[WORKS[:-1]].iloc[-1].abs() > 1e-9).all() and energy["drive"].abs().max() == 0.0
    assert energy["viscous_normal"].is_monotonic_decreasing  # drag only dissipates


def held_together(run_dir: Path, step: float, bridges_every: int = 1) -> pd.DataFrame:
    """Three wet spheres that fly apart against their bridges and swing: one formation each, no contact, no gravity."""
    bodies = [
        small.Sphere(1, (-2 * R - 1.5e-4, 0.0, 0.0), (-0.04, 0.03, 0.0)),
        small.Sphere(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.02), (0.0, 10.0, 5.0)),
        small.Sphere(1, (2 * R + 1.5e-4, 0.0, 0.0), (0.05, 0.0, -0.02)),
    ]
    steps = round(SECONDS / step)
    small.prepare(
        run_dir, spheres_of(R), bodies, contacts(1, stiffness=1e4), liquid=WATER, effects=small.PAPER, time_step_s=step,
        steps=steps, log_every_step=False, output_interval_s=SECONDS, bridges_every=bridges_every,
    )  # fmt: skip
    small.run(run_dir, bodies)
    return beds.table(run_dir, "history/energy")


def test_closure_improves_with_the_step(tmp_path: Path) -> None:
    """Without the half kicks the budget closes to second order in dt (factor 4 a halving); the capillary work against the
    energy stored, formed and ruptured to first order (factor 2: a bridge acts from the step after its formation)."""
    kicks, stored = [], []
    for k, step in enumerate((4e-5, 2e-5, 1e-5)):
        last = held_together(tmp_path / str(k), step)
        kicks.append(abs(float(gap_of(last).iloc[-1])))
        end = last.iloc[-1]
        stored.append(abs(float(end["capillary"] - (end["formed"] - end["ruptured"] - end["capillary_stored"]))))
        assert abs(end["capillary"]) > 5e-8
    for coarse, fine in pairwise(kicks):
        assert 3.0 < coarse / fine < 5.5, kicks
    for coarse, fine in pairwise(stored):
        assert 1.5 < coarse / fine < 2.6, stored


def test_work_of_a_slow_pull_is_the_stored_energy(tmp_path: Path) -> None:
    """A driven pull from contact beyond rupture: the drive pays the capillary energy that was stored, and the drag."""
    bodies = [
        small.Sphere(1, (0.0, 0.0, 0.0), driven=True),
        small.Sphere(1, (0.0, 0.0, 2 * R), (0.0, 0.0, 0.05), driven=True),
    ]
    small.prepare(
        tmp_path, spheres_of(R), bodies, contacts(1), liquid=WATER, effects=small.PAPER, time_step_s=1e-5, steps=3000,
        output_interval_s=1e-3,
    )  # fmt: skip
    small.run(tmp_path, bodies)
    end = beds.table(tmp_path, "history/energy").iloc[-1]
    assert end["ruptured"] > 0.0  # the dynamic rupture distance is longer than the static one
    assert end["capillary_stored"] == 0.0
    assert end["capillary"] == pytest.approx(end["formed"] - end["ruptured"], rel=2e-3)
    assert end["drive"] == pytest.approx(
        -(end["capillary"] + end["viscous_normal"] + end["viscous_tangential"]), rel=1e-9
    )
    assert end["kinetic"] == 0.0 and end["contact"] == pytest.approx(0.0, abs=1e-15)
    log = beds.table(tmp_path, "history/contacts")
    by_hand = np.trapezoid(log["capillary"], log["separation"])
    assert -end["capillary"] == pytest.approx(by_hand, rel=2e-3)
    assert math.isfinite(end["half_kick"])


def test_works_that_are_not_asked_for_change_no_bit(tmp_path: Path) -> None:
    """Without `output.energy` the table is empty and the bed moves as before; the summary knows what it knows of a dry run."""
    runs = []
    for energy in (True, False):
        run_dir = tmp_path / str(energy)
        spheres = beds.bed((5, 5, 4))
        made = beds.prepare(run_dir, spheres, 900)
        asked = made.model_copy(update={"output": made.output.model_copy(update={"energy": energy})})
        (run_dir / "scene.json").write_text(asked.model_dump_json())
        small.run(run_dir, spheres)
        runs.append(run_dir)
    assert len(beds.table(runs[0], "history/energy")) == 11 and beds.table(runs[1], "history/energy").empty
    for name in ("trajectory", "history/events", "history/contacts"):
        pd.testing.assert_frame_equal(*(beds.table(run_dir, name) for run_dir in runs), check_exact=True)
    assert len(beds.table(runs[0], "history/events")) > 10
