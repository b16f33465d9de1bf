"""The export for OVITO, read by a reader of LAMMPS' text dumps written here after their description."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

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
    # of two bridges the one at the wire is no bond
    assert [len(table) for _, table in bridges] == [0, 0, 1]
    bond = bridges[-1][1].iloc[0]
    assert (bond["id1"], bond["id2"], bond["volume"]) == (1, 3, pytest.approx(2 * UNIT, rel=1e-8))
    assert bond["age"] == pytest.approx(38 * synthetic.TIME_STEP, rel=1e-8)


def test_a_dry_run_has_no_bonds(tmp_path: Path) -> None:
    assert [path.name for path in ovito.write(synthetic.make(tmp_path / "case01", moist=False))] == ["spheres.dump"]
