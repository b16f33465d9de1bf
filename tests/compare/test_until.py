"""Seeds of a scene with `until`, which end after different numbers of blocks, in `pywet compare` and `pywet digest`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet.compare import common_end, digest, quantities, verdict
from pywet.runs.rundir import RunDir
from pywet.schema import TABLES
from tests.error_codes import raises_code
from tests.products import made_up

BLOCK, LEAST = 200, 8


def run_of(folder: Path, seed: int, blocks: int, until: bool = True) -> Path:
    """A run of so many blocks of 0.2 s, at whose step k 10 k + seed bridges have formed and the energies are k + seed."""
    run = made_up.make(folder, steps=BLOCK * blocks)
    scene = json.loads((run / "scene.json").read_text()) | {"seed": seed, "blocks": blocks if until else None}
    (run / "scene.json").write_text(json.dumps(scene))
    description = {"name": "made up", "seed": seed}
    description |= {"until": {"partition_percent": 5.0, "least_blocks": LEAST}} if until else {}
    (run / "description.json").write_text(json.dumps(description))
    places = pd.read_parquet(run / "trajectory.parquet")
    places.assign(z=places["step"] * 1e-6 * seed).to_parquet(run / "trajectory.parquet")
    step = np.unique(places["step"])
    for name, count in (("ledger", 10 * step + seed), ("energy", step + seed)):
        rows = pd.DataFrame({column: count for column in TABLES[f"history/{name}"]})
        rows.assign(step=step, time=step * made_up.STEP).to_parquet(run / "history" / f"{name}.parquet")
    return run


@pytest.fixture(autouse=True)
def complete(monkeypatch: pytest.MonkeyPatch) -> None:
    """The made-up run has no liquid: whether it is complete and closes its ledger is left out."""
    monkeypatch.setattr(quantities, "_whole", lambda run: {"rows": {}, "outputs": 1, "steps": 1, "windows": []})
    monkeypatch.setattr(quantities, "_checks", lambda run: iter(()))


def test_they_are_compared_up_to_the_end_of_the_shortest(tmp_path: Path) -> None:
    """Of 8 to 10 blocks, against the same and against ten times the ruptures; all numbers are those after 8 blocks."""
    lengths = (8, 10, 9)
    a, b, c = ([run_of(tmp_path / name / str(k), k, n) for k, n in enumerate(lengths, 1)] for name in "abc")
    for run in c:
        ledger = pd.read_parquet(run / "history" / "ledger.parquet")
        ledger.assign(ruptures=10 * ledger["ruptures"]).to_parquet(run / "history" / "ledger.parquet")
    found = verdict.compare(a, b)
    rows, end = {row.quantity: row for row in found.rows}, BLOCK * LEAST
    assert not found.different and rows["formations"].a == rows["formations"].b == pytest.approx(10 * end + 2)
    assert rows["energy gravity"].a == pytest.approx(end + 2)
    assert rows["mean height at the end"].a == pytest.approx(2e-6 * end)
    longer = [str(run) for group in (a, b) for run in group[1:]]
    assert found.notes == [f"all but the screen: of the first 1.6 s, which all runs reach, in {', '.join(longer)}"]
    other = verdict.compare(a, c)
    assert [row.quantity for row in other.rows if row.different] == ["ruptures"]


def test_a_given_duration_is_another_scene(tmp_path: Path) -> None:
    """Allowed between groups by --across duration, and then compared up to the common end; not within a group."""
    run, given, shorter = (
        run_of(tmp_path / name, 1, blocks, until)
        for name, blocks, until in (("a", 9, True), ("b", 10, False), ("c", 8, False))
    )
    with raises_code("compare.scenes", given=("duration",)):
        verdict.compare([run], [given])
    rows = {row.quantity: row for row in verdict.compare([run], [given], across=["duration"]).rows}
    assert rows["formations"].a == rows["formations"].b == 10 * 9 * BLOCK + 1
    with raises_code("compare.scenes", given=("duration",)):
        verdict.compare([given, shorter], [given], across=["duration"])
    assert common_end.of_runs([given, shorter]) is None and common_end.of_scene(given) is None


def test_a_digest_has_the_numbers_that_every_seed_reaches(tmp_path: Path) -> None:
    """Those after 8 blocks, whatever the lengths of the runs; a seed of another length is as the digest says."""
    runs = [run_of(tmp_path / str(k), k, blocks) for k, blocks in ((1, 9), (2, 10), (3, 9))]
    stored = digest.load(digest.save(digest.of_runs("until", "command", runs), tmp_path / "until.json"))
    assert stored.runs == 3 and stored.numbers["formations"].mean == 10 * LEAST * BLOCK + 2
    assert all(row.ok for row in digest.check(stored, run_of(tmp_path / "4", 2, 8)))
    (runs[0] / "description.json").write_text("{}")
    assert common_end.of_scene(runs[0]) == pytest.approx(0.2)  # one block, which all runs have
    part = common_end.beginning(RunDir(runs[0]), 0.4)
    assert part.summary is None and part.table_if_there("history/ledger")["step"].max() == 400  # type: ignore[index]
