"""Inserted spheres in a run with outlets: created shortly before they enter, with nothing else changed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import pywet
from pywet.cases.custom.building import Building, write
from pywet.engines.liggghts import driver
from pywet.runs.tables import ledger_error
from pywet.util.files import read_table
from reference_impl.replay.replay import replay
from tests.cases.custom.conftest import beads
from tests.engines.liggghts.test_restart import killed, same_bits
from tests.error_codes import raises_code

STEP = 2e-5
WINDOWS = {"windows": 4, "window_steps": 5}
LIQUID = {"percent": 2, "surface_tension_N_per_m": 0.005}
"""Too weak to hold a bead at the bar."""
SHELF = {"name": "shelf", "block": {"low_mm": (-0.2, -20, -6), "high_mm": (0.2, 20, -2)}}


def pulses(moist: bool = True, for_s: float = 0.7, **changes: Any) -> pywet.Scene:
    """Two classes in two pulses, between which all have left; some fall on a bar."""
    inlet = {"low_mm": (-10, -10, 20), "high_mm": (10, 10, 26)}
    insertion = {"for_s": for_s, "profile": "pulsed", "pulses": 2, "pulse_share": 0.1}
    common = {"material": "glass", "box": inlet, "velocity_m_per_s": (0, 0, -0.2), "insertion": insertion}
    spheres = [{"name": f"d{d}", "diameter_mm": d, "count": n, **common} for d, n in ((3, 8), (2, 12))]
    outlets = [{"name": "unders", "high_mm": (None, None, -30)}]
    given = beads(
        duration_s=for_s, spheres=spheres, outlets=outlets, walls=[SHELF], time_step={"time_step_s": STEP}, **changes
    )
    return pywet.Scene(**{**given, "liquid": LIQUID} if moist else given)


def held(folder: Path) -> np.ndarray:
    """Return the numbers of spheres that the engine reports, in the order of steps."""
    text = (folder / "engine" / "output.log").read_text()
    return np.array(re.findall(r"^ +\d+ +(\d+) +\S+ +\S+ *$", text, re.MULTILINE), dtype=int)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> pywet.Run:
    """The moist run."""
    return pywet.run(pulses(results=WINDOWS), tmp_path_factory.mktemp("created"))


@pytest.mark.engine
def test_the_engine_holds_those_that_enter_soon(run: pywet.Run) -> None:
    """Half at most, none between the pulses; as many of each class leave as were asked for."""
    count = held(run._run.path)
    assert count[0] <= 10 and count.max() <= 10 and (count[: int(np.flatnonzero(count)[-1])] == 0).any()
    gone = run._run.table("history/retired")
    assert gone["type"].value_counts().to_dict() == {1: 8, 2: 12}


@pytest.mark.engine
def test_it_enters_where_and_when_the_scene_says(run: pywet.Run) -> None:
    """At x + v t until then, in free fall after, in all tables that contain it."""
    start = run._run.spheres.sort_values("id")
    first = read_table(run._run.path / run.scene.spheres_file).sort_values("id")
    enters = np.array(run.scene.enters(start["type"]))
    for table in (run.trajectory, run._run.table("history/window_states")):
        rows = table.merge(first.assign(enters=enters), on="id", suffixes=("", "_0"))
        since = STEP * np.maximum(rows["step"] - rows["enters"], 0)
        rows = rows[since < 0.02].assign(since=since)  # none has met the shelf
        assert (rows["since"] == 0).sum() > 20
        time = STEP * rows["step"]
        for axis in "xy":
            assert rows[axis].to_numpy() == pytest.approx(rows[f"{axis}_0"].to_numpy(), abs=1e-12)
        fallen = 0.5 * 9.81 * (rows["since"] + STEP) * rows["since"]
        want = (rows["z_0"] - 0.2 * time - fallen).to_numpy()
        assert rows["z"].to_numpy() == pytest.approx(want, abs=9.81 * 0.02 * STEP)
        waits = (rows["since"] == 0).to_numpy()
        assert rows["z"].to_numpy()[waits] == pytest.approx(want[waits], abs=1e-12)
    due = [start.loc[enters <= step, "film"].sum() for step in run.ledger["step"]]
    assert run.ledger["initial"].to_numpy() == pytest.approx(due, rel=1e-9, abs=1e-22)
    assert len(run.events) and 0.0 <= ledger_error(run.ledger) < 1e-12


@pytest.mark.engine
def test_nothing_else_changes(run: pywet.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables of the same rows, the same spheres at the same outlet, and the same quantities of the replay as without."""
    monkeypatch.setattr(Building, "ahead_s", None)
    other = pywet.run(pulses(results=WINDOWS), tmp_path)
    assert held(tmp_path)[0] == 20 and other.scene.created_ahead_s is None
    gone, same = (of._run.table("history/retired").sort_values("id")[["id", "step", "outlet"]] for of in (run, other))
    assert gone.to_numpy().tolist() == same.to_numpy().tolist()
    one, two = (of.trajectory.sort_values(["step", "id"]) for of in (run, other))
    assert one[["step", "id"]].to_numpy().tolist() == two[["step", "id"]].to_numpy().tolist()
    assert one[[*"xyz"]].to_numpy() == pytest.approx(two[[*"xyz"]].to_numpy(), abs=1e-8)
    assert len(run.events) == len(other.events)
    replayed = [replay(of._run.path) for of in (run, other)]
    assert all(one["ok"] for one in replayed)
    assert replayed[0]["quantities"].keys() == replayed[1]["quantities"].keys()


@pytest.mark.engine
@pytest.mark.parametrize(("moist", "after"), [(True, 1000), (True, 14000), (False, 1000)])
def test_killed_and_resumed(tmp_path: Path, moist: bool, after: int) -> None:
    """The same bits in all tables, wherever the run was killed."""
    for name in ("whole", "killed"):
        write(pulses(moist, results=WINDOWS), tmp_path / name)
    assert driver.run(tmp_path / "whole", progress=False).resumed_at_step is None
    killed(tmp_path / "killed", after=after)
    assert (driver.run(tmp_path / "killed", progress=False).resumed_at_step or 0) >= after
    same_bits(tmp_path / "whole", tmp_path / "killed")


@pytest.mark.engine
def test_two_ranks(tmp_path: Path) -> None:
    """The same spheres in the outlet at the same steps, and all at the same places, as on one rank."""
    one, two = (pywet.run(pulses(for_s=0.12), tmp_path / str(n), ranks=n) for n in (1, 2))
    gone, same = (of._run.table("history/retired").sort_values("id")[["id", "step"]] for of in (one, two))
    assert len(gone) and gone.to_numpy().tolist() == same.to_numpy().tolist()
    at, there = (of.trajectory.sort_values(["step", "id"])[["id", *"xyz"]].to_numpy() for of in (one, two))
    assert at == pytest.approx(there, abs=1e-9)
    assert one.ledger["initial"].tolist() == pytest.approx(two.ledger["initial"].tolist(), rel=1e-14)


def test_the_box_ends_where_they_are_created() -> None:
    """As far up as a sphere is created, not as far as it would come in the whole run; the start of others is no obstacle."""
    made = Building(pulses(for_s=5.0))
    scene, ahead = made.scene(), made.ahead_s
    assert ahead is not None and scene.created_ahead_s == ahead < 0.1
    assert scene.box_high_m[2] < 0.026 + 0.2 * ahead + 0.1 < 0.4 < made.spheres["z"].max()


@pytest.mark.engine
def test_a_path_that_is_taken(tmp_path: Path) -> None:
    """A bead that lies on a ledge in the path stops the run when another is to be created there, with both named."""
    ledge = {"name": "ledge", "block": {"low_mm": (-20, -20, 26), "high_mm": (-2, 20, 28)}}
    box = {"low_mm": (-1.6, -1.6, 20), "high_mm": (1.6, 1.6, 24)}
    common = {"material": "glass", "diameter_mm": 3}
    given = beads(
        duration_s=0.8, walls=[ledge], outlets=[{"name": "unders", "high_mm": (None, None, -30)}],
        time_step={"time_step_s": STEP},
        spheres=[
            {"name": "lies", "at_mm": [(-2.3, 0, 29.5)], **common},
            {"name": "comes", "count": 20, "box": box, "velocity_m_per_s": (0, 0, -0.2), "insertion": {"for_s": 0.8}, **common},
        ],
    )  # fmt: skip
    with raises_code("plugin.refused", says="sphere 1 is at .* in the path of sphere"):
        pywet.run(pywet.Scene(**given), tmp_path)


@pytest.mark.engine
def test_a_sphere_that_is_not_created_yet_touches_nothing(tmp_path: Path) -> None:
    """On its way to the region it passes through a wet sphere at outputs; no bridge is missed there."""
    glass = {"material": "glass", "diameter_mm": 3.0}
    scene = pywet.Scene(
        name="passes", duration_s=0.3, results={"interval_s": 0.002, "checkpoints": 10},
        materials={"glass": {"density_kg_per_m3": 2500.0, "stiffness_N_per_m": 400.0}}, liquid={"percent": 1.0},
        spheres=[
            {"name": "falls", **glass, "at_mm": [[0.0, 0.0, 142.0]]},
            {"name": "enters", **glass, "count": 1, "velocity_m_per_s": [0.0, 0.0, -0.5],
             "insertion": {"from_s": 0.26, "for_s": 0.001}, "box": {"low_mm": [-1.6, -1.6, 16.0], "high_mm": [1.6, 1.6, 20.0]}},
        ],
        walls=[{"name": "aside", "block": {"low_mm": [10.0, -20.0, -2.0], "high_mm": [20.0, 20.0, 0.0]}}],
        outlets=[{"name": "below", "high_mm": [None, None, -10.0]}],
    )  # fmt: skip
    run = pywet.run(scene, tmp_path / "run")
    places = pd.read_parquet(run.path / "trajectory.parquet").pivot_table(index="step", columns="id", values="z")
    assert ((places[1] - places[2]).abs() < 0.003).any() and run.scene.created_ahead_s is not None
    assert replay(run.path)["ok"]
