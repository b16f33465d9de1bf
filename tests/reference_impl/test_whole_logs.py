"""Logs that lack or add rows no other table misses: each is refused, or is a fault that is named."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reference_impl.replay import command
from reference_impl.replay.replay import _of_dry
from tests.reference_impl.test_weight_and_drops import bed

pytestmark = pytest.mark.engine
Table = Callable[[pd.DataFrame], pd.DataFrame]


def changed(sound: Path, copy: Path, name: str, change: Table) -> dict[str, object]:
    """What the replay says of a copy with another table."""
    shutil.copytree(sound, copy)
    path = copy / f"{name}.parquet"
    change(pd.read_parquet(path)).to_parquet(path)
    return command.outcome(copy)


def first_half(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["step"] <= table["step"].max() // 2]


def every_other_check(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["step"].rank(method="dense") % 2 == 1]


@pytest.fixture(scope="module")
def dripping(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return bed(tmp_path_factory.mktemp("dripping"), shedding="tate")


@pytest.mark.parametrize("change", [first_half, every_other_check])
def test_checks_for_drops_are_all_there(dripping: Path, tmp_path: Path, change: Table) -> None:
    """The log of felt forces ends early, or is of checks that are twice as rare as they must be."""
    found = changed(dripping, tmp_path / "copy", "history/felt", change)
    assert found["status"] == "unreadable" and "at every step at which drops fall" in str(found["reason"])


def test_energies_of_all_windows_are_there(fixture_dir: Path, tmp_path: Path) -> None:
    found = changed(fixture_dir, tmp_path / "copy", "history/window_energy", first_half)
    assert found["status"] == "unreadable" and "window_energy.parquet is not whole" in str(found["reason"])


def test_first_velocities_are_those_of_the_scene(heap_dir: Path, tmp_path: Path) -> None:
    def thrown(table: pd.DataFrame) -> pd.DataFrame:
        return table.assign(vx=table["vx"] + 0.01 if "vx" in table else 0.01)

    found = changed(heap_dir, tmp_path / "copy", "spheres", thrown)
    assert found["status"] == "unreadable" and "first places or velocities" in str(found["reason"])


def test_a_bridge_that_ends_by_retirement_where_nothing_is_retired(heap_dir: Path, tmp_path: Path) -> None:
    def retired(table: pd.DataFrame) -> pd.DataFrame:
        return table.assign(kind=np.where(table.index == table.index[table["kind"] == 1][0], 2, table["kind"]))

    found = changed(heap_dir, tmp_path / "copy", "history/events", retired)
    assert found["status"] == "disagrees"
    assert not found["quantities"]["retired_events"]["ok"]  # type: ignore[index]


def test_an_event_of_a_kind_that_there_is_not(heap_dir: Path, tmp_path: Path) -> None:
    def unknown(table: pd.DataFrame) -> pd.DataFrame:
        return table.assign(kind=np.where(table.index == table.index[table["kind"] == 1][0], 3, table["kind"]))

    found = changed(heap_dir, tmp_path / "copy", "history/events", unknown)
    assert found["status"] in ("disagrees", "unreadable")
    assert found["status"] == "unreadable" or not found["quantities"]["rupture_due"]["ok"]  # type: ignore[index]


def test_no_sphere_of_a_case_has_a_prescribed_motion(dry_dir: Path, tmp_path: Path) -> None:
    """Else Newton's law would be checked for the others alone."""
    copy = Path(shutil.copytree(dry_dir, tmp_path / "copy"))
    deck = copy / "engine" / "setup.liggghts"
    deck.write_text(f"{deck.read_text()}group driven id 3 4\n")
    found = command.outcome(copy)
    assert found["status"] == "disagrees" and "motion is prescribed" in str(found["scene"]), found["scene"]


def test_a_dry_run_that_disagrees_without_a_fault_of_its_motion(dry_dir: Path) -> None:
    """What no equation of the diagnosis speaks of is listed, also where several runs are replayed at once."""
    found = _of_dry(dry_dir).named(["retired_rest"])
    assert found is not None and found["findings"] == [] and found["not_explained"] == ["retired_rest"]
