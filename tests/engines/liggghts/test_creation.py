"""Spheres that are created at a checkpoint leave the tangential springs of all others as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.scene import Insertion, Outlet
from tests.engines.liggghts import beds
from tests.engines.liggghts.scenes import contacts, spheres_of

pytestmark = pytest.mark.engine
R, STEP, STEPS, HALF = 2.5e-3, 2e-5, 600, 0.02
FORCE = ["fx", "fy", "fz"]


def sheared(run_dir: Path, ranks: int, ahead_s: float | None) -> pd.DataFrame:
    """Two spheres press and shear each other across a periodic face for 8 ms; a third appears elsewhere. States of the two."""
    at, speed = HALF - R, 0.05
    spheres = [
        small.Sphere(1, (0.005, at, 0.0), (0.02, speed, 0.0)),
        small.Sphere(1, (0.005, -at, 0.0), (-0.02, -speed, 0.0)),
        small.Sphere(2, (0.01, 0.01, 0.01)),
    ]
    one, two = spheres_of(R, R)
    enters = {"insertion": Insertion(from_s=275 * STEP, for_s=1e-4), "count": 1}
    small.prepare(
        run_dir, [one, two.model_copy(update=enters)], spheres, contacts(2, stiffness=12.6, friction=0.5),
        time_step_s=STEP, steps=STEPS, box=HALF, periodic="y", contacts="batched", created_ahead_s=ahead_s,
        outlets=(Outlet(name="below", low_m=(None,) * 3, high_m=(None, None, -0.018)),),
        output_interval_s=100 * STEP, checkpoints=5, window_trajectories=True,
    )  # fmt: skip
    small.run(run_dir, spheres, ranks)
    return beds.table(run_dir, "history/window_states").query("id < 3").set_index(["step", "id"])


@pytest.mark.parametrize("ranks", [1, 2])
def test_springs_of_contacts_with_ghosts_stay(tmp_path: Path, ranks: int) -> None:
    """At step 200, in the middle of the contact; ghosts are then where the new sphere is put. Forces are opposite to round-off,
    and the path is that of a run in which it is there from the start."""
    states, expected = (sheared(tmp_path / str(ahead), ranks, ahead) for ahead in (1e-3, None))
    force = states[FORCE]
    largest = force.abs().max().max()
    assert abs(force.loc[(200, 1), "fx"]) > 0.1 * largest
    assert np.abs(force.groupby("step").sum()).max(axis=None) < 1e-9 * largest
    assert np.abs((states - expected)[[*"xyz"]]).max(axis=None) < 1e-9 * R
