"""The export for OVITO, read by a reader of LAMMPS' text dumps written here after their description."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import stages
from pywet.errors import PywetError
from pywet.report import ovito
from tests.cases.screening import synthetic
from tests.cases.screening.synthetic import UNIT


def dumped(path: Path, rows: str) -> Iterator[tuple[int, pd.DataFrame]]:
    """Step and table of each output of a dump; four items in LAMMPS' order, the last one names the columns."""
    lines = iter(path.read_text().splitlines())
    for line in lines:
        assert line == "ITEM: TIMESTEP"
        step = int(next(lines))
        assert next(lines).startswith("ITEM: NUMBER OF ")
        count = int(next(lines))
        assert next(lines).startswith("ITEM: BOX BOUNDS")
        assert all(len(next(lines).split()) == 2 for _ in range(3))
        head = next(lines).split()
        assert head[:2] == ["ITEM:", rows]
        values = [[float(word) for word in next(lines).split()] for _ in range(count)]
        yield step, pd.DataFrame(values, columns=head[2:])


def test_spheres_and_bonds_of_every_output(run: Path) -> None:
    spheres, bridges = (
        list(dumped(path, rows)) for path, rows in zip(ovito.write(run), ("ATOMS", "ENTRIES"), strict=True)
    )
    assert [step for step, _ in spheres] == [step for step, _ in bridges] == list(synthetic.STEPS)
    for step, table in spheres:
        np.testing.assert_allclose(table[["x", "z"]], [[0.006 * (i - 1), synthetic.Z[step][i]] for i in range(3)])
        assert table[["id", "type", "radius", "vx"]].to_numpy().tolist() == [
            [1, 1, 4e-3, 0.1], [2, 2, 2e-3, 0.1], [3, 2, 2e-3, 0.1],
        ]  # fmt: skip
    # bridges at wires are not bonds
    assert [len(table) for _, table in bridges] == [0, 0, 1]
    bond = bridges[-1][1].iloc[0]
    assert (bond["id1"], bond["id2"], bond["volume"]) == (1, 3, pytest.approx(2 * UNIT, rel=1e-8))
    assert bond["age"] == pytest.approx(38 * synthetic.TIME_STEP, rel=1e-8)


@pytest.mark.parametrize(("unknown", "known"), [("capillary_force", "age"), ("age", "capillary_force")])
def test_what_is_not_known_is_nan(run: Path, unknown: str, known: str) -> None:
    """Of the force of a law in a user's file, and of the age of a bridge whose formation was logged by an earlier run."""
    scene, events = run / "scene.json", run / "history" / "events.parquet"
    if unknown == "age":
        pd.read_parquet(events).query("i != 1 or j != 3").to_parquet(events)
    else:
        scene.write_text(scene.read_text().replace('"rabinovich"', '"my_law.py:pull"'))
    _, bonds = stages.ovito(run)
    bond = list(dumped(bonds, "ENTRIES"))[-1][1].iloc[0]
    assert np.isnan(bond[unknown]) and bond[known] > 0.0 and bond["separation"] == 1e-4
    stages.vtk(run)


def test_a_dry_run_has_no_bonds(tmp_path: Path) -> None:
    assert [path.name for path in ovito.write(synthetic.make(tmp_path / "case01", moist=False))] == ["spheres.dump"]


def exchanged(*pairs: tuple[str, str]) -> Callable[[pd.DataFrame], pd.DataFrame]:
    return lambda table: table.assign(**{a: table[b] for one, two in pairs for a, b in ((one, two), (two, one))})


Change = Callable[[pd.DataFrame], pd.DataFrame]
FAULTS: dict[str, tuple[str, Change, str]] = {
    "force and gap exchanged": ("bridges", exchanged(("capillary_force", "separation")), "it is the capillary_force"),
    "ends one row on": ("bridges", lambda t: t.assign(id2=t["id2"] - 1), "bridges.dump shows other bonds"),
    "age in steps": ("bridges", lambda t: t.assign(age=t["age"] / synthetic.TIME_STEP), "it is 1000"),
    "y mirrored": ("spheres", lambda t: t.assign(y=-t["y"]), "the sign is turned"),
    "y and z exchanged": ("spheres", exchanged(("y", "z")), "it is the z"),
    "diameters": ("spheres", lambda t: t.assign(radius=2.0 * t["radius"]), "a diameter for a radius"),
    "places of the next sphere": ("spheres", lambda t: t.assign(x=np.roll(t["x"], 1)), "x in spheres.dump"),
    "speeds halved": ("spheres", lambda t: t.assign(vx=0.5 * t["vx"]), "half the value"),
    "liquid for film": ("spheres", lambda t: t.assign(film_thickness=t["liquid"]), "it is the liquid"),
    "a sphere left out": ("spheres", lambda t: t.iloc[1:], "spheres.dump shows other spheres"),
}  # fmt: skip


@pytest.fixture
def crooked(run: Path) -> Path:
    """The run with spheres at places that no exchange leaves alike."""
    table = pd.read_parquet(run / "trajectory.parquet")
    table.assign(y=1e-3 * table["id"] + 2e-4, vy=0.03 * table["id"], vz=-0.07).to_parquet(run / "trajectory.parquet")
    return run


def test_what_is_written_agrees_with_the_logs(crooked: Path) -> None:
    assert [path.name for path in stages.ovito(crooked)] == ["spheres.dump", "bridges.dump"]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_wrong_column_is_named(crooked: Path, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """By the reference, which reads the files back."""
    maker, change, words = FAULTS[fault]
    sound = getattr(ovito, maker)
    monkeypatch.setattr(ovito, maker, lambda run, step: change(sound(run, step)))
    with pytest.raises(PywetError) as found:
        stages.ovito(crooked)
    assert words in str(found.value)
