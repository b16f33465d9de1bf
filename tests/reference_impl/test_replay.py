"""The replay of a real engine run: it agrees, and it finds every fault planted in the logs or in the plugin's conventions."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import small
from reference_impl import io
from reference_impl.replay import replay
from tests.engine.scenes import WATER, contacts, spheres_of

pytestmark = pytest.mark.engine
R = 2.5e-3
Fault = Callable[[dict[str, pd.DataFrame]], None]


@pytest.fixture(scope="module")
def run_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twelve wet spheres of two sizes falling on a floor, every step logged."""
    folder = tmp_path_factory.mktemp("heap")
    generator = np.random.default_rng(3)
    at = [(0.0052 * i, 0.0052 * j, 0.003 + 0.0052 * k) for i in (-1, 0, 1) for j in (-1, 0) for k in (0, 1)]
    spheres = [
        small.Sphere(1 + n % 2, p, tuple(generator.normal(0, 0.15, 3)), tuple(generator.normal(0, 20, 3)))
        for n, p in enumerate(at)
    ]
    small.prepare(
        folder,
        spheres_of(R, 2e-3),
        spheres,
        contacts(2, stiffness=1e4),
        liquid=WATER,
        effects=small.PAPER,
        walls=[small.floor()],
        wall_angle_rad=math.radians(45.0),
        time_step_s=2e-5,
        steps=3000,
        output_interval_s=1e-3,
        gravity=(0.0, 0.0, -9.81),
    )
    small.run(folder, spheres)
    return folder


def test_agrees(run_dir: Path) -> None:
    """Volumes, shares, films, forces and torques within 1e-9, the ledger within 1e-12, ruptures as the papers say."""
    result = replay(run_dir)
    assert result["events"] > 20 and result["contacts"] > 1000
    assert (pd.read_parquet(run_dir / "history" / "events.parquet")["kind"] == 1).any()
    bad = {n: q["largest"] for n, q in result["quantities"].items() if not q["ok"]}
    assert result["ok"], bad


def _scaled(table: str, columns: list[str], factor: float) -> Fault:
    def fault(tables: dict[str, pd.DataFrame]) -> None:
        for column in columns:
            tables[table][column] *= factor

    return fault


def _swap(tables: dict[str, pd.DataFrame]) -> None:
    events = tables["events"]
    unequal = (events["kind"] == 1) & (np.abs(events["share_i"] - events["share_j"]) > 1e-3 * events["volume"])
    assert unequal.any()
    row = events.index[unequal][0]
    events.loc[row, ["share_i", "share_j"]] = events.loc[row, ["share_j", "share_i"]].to_numpy()


def _drop(kind: int) -> Fault:
    def fault(tables: dict[str, pd.DataFrame]) -> None:
        events = tables["events"]
        tables["events"] = events.drop(events.index[events["kind"] == kind][2]).reset_index(drop=True)

    return fault


def _twice(tables: dict[str, pd.DataFrame]) -> None:
    events = tables["events"]
    row = events.index[events["kind"] == 0][3]
    events.loc[row, ["volume", "share_i", "share_j"]] *= 2.0


def _early(tables: dict[str, pd.DataFrame]) -> None:
    events = tables["events"]
    events.loc[events.index[events["kind"] == 1][0], "separation"] *= 0.5


def _leak(tables: dict[str, pd.DataFrame]) -> None:
    ledger = tables["ledger"]
    ledger.loc[ledger.index[-1], "films"] *= 1.0 + 1e-10


def _film(tables: dict[str, pd.DataFrame]) -> None:
    films = tables["films"]
    films.loc[films.index[-1], "film"] *= 1.0 + 1e-6


def _volume_bit(tables: dict[str, pd.DataFrame]) -> None:
    contacts = tables["contacts"]
    contacts.loc[contacts.index[-1], "volume"] = np.nextafter(contacts["volume"].iloc[-1], 1.0)


def _stands_on(tables: dict[str, pd.DataFrame]) -> None:
    contacts = tables["contacts"]
    row = contacts.index[contacts["partner_kind"] == 1][-1]
    contacts.loc[row, "xi_z"] = contacts.loc[row, "xj_z"] + 2.0 * R + contacts.loc[row, "rupture_distance"]


FAULTS: dict[str, tuple[Fault, set[str]]] = {
    "capillary radius halved": (_scaled("contacts", ["capillary"], 0.5), {"capillary"}),
    "a force a billionth off": (_scaled("contacts", ["viscous_normal"], 1.0 + 1e-6), {"viscous_normal"}),
    "torque arm wrong": (_scaled("contacts", ["torque_i_x", "torque_i_y", "torque_i_z"], 1.1), {"torque_i"}),
    "torque on j forgotten": (_scaled("contacts", ["torque_j_x", "torque_j_y", "torque_j_z"], 0.0), {"torque_j"}),
    "tangential sign turned": (
        _scaled("contacts", [f"viscous_tangential_{a}" for a in "xyz"], -1.0),
        {"viscous_tangential"},
    ),
    "dynamic rupture ignored": (_scaled("contacts", ["rupture_distance"], 0.98), {"rupture_limit"}),
    "shares swapped": (_swap, {"share_i", "share_j"}),
    "a formation dropped": (_drop(0), {"film_i_before"}),
    "a rupture dropped": (_drop(1), {"film_i_before"}),
    "volume drawn twice": (_twice, {"volume"}),
    "ruptured too early": (_early, {"rupture_due"}),
    "liquid leaks": (_leak, {"ledger"}),
    "a film wrong at the end": (_film, {"final_film_spheres"}),
    "a contact's volume a bit off": (_volume_bit, {"contact_volume"}),
    "a bridge stands beyond its limit": (_stands_on, {"standing_beyond_limit"}),
    "transfer table wrong": (_scaled("transfer", ["transfer_i"], 0.99), {"transfer_table"}),
}


@pytest.mark.parametrize("name", FAULTS)
def test_planted_fault_is_found(run_dir: Path, tmp_path: Path, name: str) -> None:
    """The replay objects, and one of the quantities it names is the faulty one."""
    fault, named = FAULTS[name]
    shutil.copytree(run_dir / "history", tmp_path / "history")
    tables = {t: pd.read_parquet(tmp_path / "history" / f"{t}.parquet") for t in io.TABLES}
    fault(tables)
    for table, frame in tables.items():
        frame.to_parquet(tmp_path / "history" / f"{table}.parquet", index=False)
    result = replay(tmp_path)
    found = {n for n, q in result["quantities"].items() if not q["ok"]}
    assert not result["ok"]
    assert found & named


def test_missing_history_is_one_sentence(tmp_path: Path) -> None:
    """A folder without logs is refused by name."""
    with pytest.raises(io.ReplayError, match=r"holds no meta\.json; expected the history of a moist run"):
        replay(tmp_path)
