"""Runs with every built-in law, with the exact bridge and with a law of the user's own, replayed."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pywet.cases.small import small
from pywet.laws import registry
from pywet.scene import Effects
from reference_impl.replay import capillary, coverage, laws
from reference_impl.replay.io import ReplayError
from reference_impl.replay.replay import replay, table
from tests.engines.liggghts.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
LARGE, LITTLE = 2.5e-3, 1.5e-3
SIXTY = math.pi / 3
"""Contact angle of the exact run: its table is one of the three that all tests share."""


def lift(run_dir: Path, effects: Effects, angles: tuple[float, float, float]) -> Path:
    """A sphere drawn off the floor and a smaller one drawn off the first, both with spin, until both bridges rupture."""
    bodies = [
        small.Sphere(1, (0.0, 0.0, LARGE - 6e-6), (0.01, 0.0, 0.06), (0.0, 5.0, 2.0), driven=True),
        small.Sphere(2, (0.0, 0.0, 2 * LARGE + LITTLE - 1.2e-5), (0.0, 0.02, 0.13), (3.0, -4.0, 0.0), driven=True),
    ]
    classes = [
        c.model_copy(update={"contact_angle_rad": a})
        for c, a in zip(spheres_of(LARGE, LITTLE), angles[:2], strict=True)
    ]
    small.prepare(
        run_dir, classes, bodies, contacts(2, stiffness=1e4), liquid=WATER, effects=effects, walls=[small.floor()],
        wall_angle_rad=angles[2], time_step_s=5e-5, steps=500, output_interval_s=5e-3,
    )  # fmt: skip
    small.run(run_dir, bodies)
    return run_dir


def far(result: dict[str, Any]) -> dict[str, float]:
    """The quantities beyond their limits."""
    return {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}


def test_reference_knows_every_built_in_law() -> None:
    """Names as a run's meta.json has them; those of the collision models (Buck, Davis) are replayed as unchecked."""
    for effect, built_in in registry.BUILT_IN.items():
        known = coverage.CLOSED[effect] | ({coverage.EXACT} if effect in coverage.SOLVED else set())
        assert known == {name for name in built_in if not name.startswith(("buck", "davis"))}, effect


CLOSED = list(capillary.LAWS)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_forms_agree(tmp_path: Path, name: str) -> None:
    """Forces of both bridges within 1e-9 of the reference; the other laws take turns."""
    turn = CLOSED.index(name)
    chosen = {
        kind: list(names)[turn % len(names)]
        for kind, names in (
            ("viscous_normal", laws.VISCOUS_NORMAL),
            ("viscous_tangential", laws.VISCOUS_TANGENTIAL),
            ("rupture", laws.RUPTURE),
        )
    }
    effects = small.PAPER.model_copy(update={"capillary": name, **chosen})
    result = replay(lift(tmp_path, effects, (0.5, 0.2, math.pi / 4)))
    assert far(result) == {}
    assert result["events"] == 4 and result["contacts"] > 400
    assert result["unchecked"] == [] and result["quantities"]["capillary"]["sample_of"] is None
    assert result["quantities"]["capillary"]["tolerance"] == 1e-9
    log = pd.read_parquet(tmp_path / "history" / "contacts.parquet")
    assert set(log["partner_kind"]) == {0, 1}
    assert log["separation"].max() > 0.2 * LARGE > 0.0 > log["separation"].min()


@pytest.fixture(scope="module")
def exact_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run the scene with preset `exact`."""
    return lift(tmp_path_factory.mktemp("exact"), small.EXACT, (SIXTY, SIXTY, SIXTY))


def test_exact_bridge_is_solved_for_a_sample(exact_dir: Path) -> None:
    """Force, rupture distance and split against the reference's own solver, the rest in full; the result says so."""
    result = replay(exact_dir)
    assert far(result) == {}
    q = result["quantities"]
    assert [q[n]["tolerance"] for n in ("capillary", "rupture_distance", "transfer_table")] == [1e-3, 2e-4, 1e-7]
    assert q["capillary"]["count"] == 60 and q["capillary"]["sample_of"] == result["contacts"]
    assert q["rupture_distance"]["count"] == 2 and q["rupture_distance"]["sample_of"] == 4  # one per bridge
    assert q["transfer_table"]["count"] == 48
    assert q["force"]["count"] == result["contacts"] and q["force"]["tolerance"] == 1e-9
    # the table between its nodes; solved by sample, no motion recorded, quantities without a record, nothing to compare with
    assert [n.split(":")[0] for n in result["notes"]] == ["transfer", "scene", "results"]
    gaps = ["capillary", "rupture", "transfer", "event_speed", "no record of", "scene", "results"]
    assert [sentence.split(":")[0] for sentence in result["not_checked"]] == gaps and result["unchecked"] == []
    text = table(json.loads((exact_dir / "replay.json").read_text()))
    assert f"sample of {result['contacts']}" in text and "forces take the logged term as given" in text


@pytest.mark.parametrize(
    ("name", "column", "factor", "found"),
    [
        ("contacts", "capillary", 1.01, {"capillary", "force"}),
        ("events", "rupture_distance", 1.001, {"rupture_distance", "rupture_limit"}),
        ("transfer", "transfer_i", 1.0 + 1e-5, {"transfer_table", "share_i", "share_j"}),
        ("contacts", "torque_i_x", 1.001, {"torque_i"}),
    ],
)
def test_fault_in_the_exact_run_is_found(
    exact_dir: Path, tmp_path: Path, name: str, column: str, factor: float, found: set[str]
) -> None:
    """All that the fault touches, sampled or not, is named."""
    shutil.copytree(exact_dir, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "history" / f"{name}.parquet"
    frame = pd.read_parquet(path)
    frame[column] *= factor
    frame.to_parquet(path, index=False)
    assert found <= set(far(replay(tmp_path)))


CUSTOM_LAW = '''
from pywet.laws.force_law import force_law


@force_law
def spring(
    separation: float, volume: float, radius_i: float, radius_j: float,
    contact_angle_i: float, contact_angle_j: float, surface_tension: float,
) -> float:
    """A spring."""
    return surface_tension * max(1e-3 - separation, 0.0)


@force_law
def reach(volume: float, radius_i: float, radius_j: float, contact_angle_i: float, contact_angle_j: float) -> float:
    """A cube root."""
    return volume ** (1.0 / 3.0)
'''


SECOND = """
def spring(gap, volume, ri, rj, ti, tj, sigma):
    return {factor} * sigma * (1e-3 - gap if gap < 1e-3 else 0.0)


def reach(volume, ri, rj, ti, tj):
    return volume ** (1 / 3)
"""


def test_custom_law_is_named_and_the_rest_is_checked(tmp_path: Path) -> None:
    """No judgement on the own force and rupture distance; totals, torques, liquid and viscous terms in full."""
    law_file = tmp_path / "own.py"
    law_file.write_text(CUSTOM_LAW)
    effects = small.PAPER.model_copy(update={"capillary": f"{law_file}:spring", "rupture": f"{law_file}:reach"})
    run = lift(tmp_path / "run", effects, (0.5, 0.2, math.pi / 4))
    result = replay(run)
    assert far(result) == {} and result["ok"]
    assert [(u["effect"], u["law"]) for u in result["unchecked"]] == [
        ("capillary", f"{law_file}:spring"),
        ("rupture", f"{law_file}:reach"),
    ]
    assert not {"capillary", "rupture_distance"} & set(result["quantities"])
    assert f"capillary: the law {law_file}:spring is not built in and was not checked" in table(result)
    second = tmp_path / "second.py"
    functions = {"capillary": f"{second}:spring", "rupture": f"{second}:reach"}
    for factor, wrong in ((1.0, set()), (1.001, {"capillary", "force"})):
        second.write_text(SECOND.format(factor=factor))
        found = replay(run, functions=functions)
        assert set(far(found)) & {"capillary", "force", "rupture_distance"} == wrong
        assert found["unchecked"] == [] and found["second"] == functions
        assert found["quantities"]["capillary"]["count"] == result["contacts"]
    for text, words in (("import pywet.laws\n" + SECOND, "imports pywet"), ("spring = 1", "has no function spring"),
                        ("def spring(*given):\n    return 1 / 0\n", "raises ZeroDivisionError")):  # fmt: skip
        second.write_text(text)
        with pytest.raises(ReplayError, match=words):
            replay(run, functions={"capillary": f"{second}:spring"})
    assert f"{law_file}:spring" not in capillary.LAWS and f"{law_file}:spring" not in coverage.CLOSED["capillary"]
    path = run / "history" / "contacts.parquet"
    frame = pd.read_parquet(path)
    frame["capillary"] *= 1.0 + 1e-6  # differs from the value in the logged sum
    frame["rupture_distance"] *= 1.0 + 1e-6  # differs from the value at formation
    frame.to_parquet(path, index=False)
    assert set(far(replay(run))) == {"force", "rupture_limit"}


def test_every_law_may_be_custom(exact_dir: Path, tmp_path: Path) -> None:
    """With no law known, momentum, torques, volumes and the ledger are still checked."""
    shutil.copytree(exact_dir, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "history" / "meta.json"
    meta = json.loads(path.read_text())
    meta["effects"].update({effect: "own.py:law" for effect in coverage.WITHOUT})
    path.write_text(json.dumps(meta))
    result = replay(tmp_path)
    assert far(result) == {}
    assert [u["effect"] for u in result["unchecked"]] == list(coverage.WITHOUT)
    assert {"force", "torque_i", "volume", "film_i_after", "contact_volume", "ledger"} <= set(result["quantities"])
    assert np.isfinite([q["largest"] for q in result["quantities"].values()]).all()
