"""A log read in parts gives what it gives as a whole, to the last bit, however it is cut; and faults are found across a cut."""

from __future__ import annotations

import itertools
import json
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pyarrow import parquet

from reference_impl.diagnosis import chain, looked
from reference_impl.replay import bodies, compare, io, liquid_ledger, spans, transfer
from reference_impl.replay.lives import Lives, keys, none
from reference_impl.replay.replay import replay
from tests.reference_impl import injected_log

pytestmark = pytest.mark.engine
SIZES = (1, 7, 1000)
TIMES = ("wall_s", "cpu_s", "peak_memory_B", "events_per_s", "contacts_per_s")


def at_size(folder: Path, size: int, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Return the result of a replay in chunks of that many events, without its times; with the contributions of the effects."""
    monkeypatch.setattr(spans.go_through, "__defaults__", (size,))
    monkeypatch.setattr(spans, "PIECE", spans.PIECE if size == spans.SIZE else 2500)
    found = {k: v for k, v in replay(folder).items() if k not in TIMES}
    contributions = folder / "contributions.json"
    return found | {"contributed": json.loads(contributions.read_text()) if contributions.exists() else None}


@pytest.fixture(scope="module")
def whole(heap_dir: Path) -> dict[str, Any]:
    """The replay in one part."""
    with pytest.MonkeyPatch.context() as patch:
        return at_size(heap_dir, spans.SIZE, patch)


@pytest.mark.parametrize("size", SIZES)
def test_parts_give_the_whole(
    heap_dir: Path, whole: dict[str, Any], size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every deviation, median and worst record; parts of one event are steps of one event and more."""
    assert whole["ok"] and whole["events"] > 20
    assert at_size(heap_dir, size, monkeypatch) == whole


def test_groups_of_rows_do_not_matter(
    heap_dir: Path, tmp_path: Path, whole: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Logs compressed and cut into groups in another way, as those of earlier runs are."""
    shutil.copytree(heap_dir, tmp_path, dirs_exist_ok=True)
    for name in io.LOGS:
        path = tmp_path / "history" / f"{name}.parquet"
        parquet.write_table(parquet.read_table(path), path, row_group_size=1000 if name == "contacts" else 10)
    assert at_size(tmp_path, 7, monkeypatch) == whole


@pytest.mark.parametrize("name", ["a formation dropped", "an event doubled", "shares swapped"])
def test_faults_are_found_across_cuts(
    heap_dir: Path, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each event in a part of its own: the same findings as of the whole log."""
    injected = injected_log.plant(heap_dir, tmp_path, injected_log.FAULTS[name])
    assert at_size(injected, 1, monkeypatch) == at_size(injected, spans.SIZE, monkeypatch)


def test_a_late_fault_of_a_long_log_is_named(heap_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Looked for in the part from where the log disagrees, with those earlier events from which later ones follow."""

    def change(tables: injected_log.Tables) -> None:
        injected_log.one("events", "film_i_after", -3, 1.001)(tables)

    injected = injected_log.plant(heap_dir, tmp_path, injected_log.Injected(change, "film_after", ""))
    whole = at_size(injected, spans.SIZE, monkeypatch)["diagnosis"]
    monkeypatch.setattr(looked, "MOST", 12)
    part = at_size(injected, 6, monkeypatch)["diagnosis"]
    output_text = [[(f["quantities"], f["fault"], f["first"]["step"]) for f in d["findings"]] for d in (whole, part)]
    assert output_text[0] == output_text[1] and any("film_after" in names for names, _, _ in output_text[1])
    assert whole["looked_at"] == "" and "the fault was looked for in events of steps" in part["looked_at"]


def test_a_late_fault_of_the_contacts_is_named(heap_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From step 1500 on; what the bridges' formations say of their volumes is known from before."""
    monkeypatch.setattr(looked, "MOST", 100)

    def change(tables: injected_log.Tables) -> None:
        tables["contacts"].loc[tables["contacts"]["step"] >= 1500, "capillary"] *= 0.5

    injected = injected_log.plant(heap_dir, tmp_path, injected_log.Injected(change, "capillary", ""))
    found = at_size(injected, 6, monkeypatch)["diagnosis"]["findings"]
    assert [f["fault"] for f in found] == ["half of it counts"]


def test_a_late_fault_of_the_snapshots_is_named(
    heap_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the part from where they first disagree, not in all outputs."""

    def change(tables: injected_log.Tables) -> None:
        late = tables["bridges"]["step"] > tables["bridges"]["step"].median()
        tables["bridges"].loc[late, "separation"] *= 1.001

    injected = injected_log.plant(heap_dir, tmp_path, injected_log.Injected(change, "snapshot_separation", ""))
    whole = at_size(injected, spans.SIZE, monkeypatch)["diagnosis"]["findings"]
    monkeypatch.setattr(looked, "MOST", 12)
    part = at_size(injected, 6, monkeypatch)["diagnosis"]["findings"]
    assert [f["fault"] for f in part] == [f["fault"] for f in whole] == ["it is 1.001 times what it should be"]
    assert part[0]["records"] < whole[0]["records"]


def test_of_a_part_of_a_log_only_active_bridges_go_on() -> None:
    """Sphere 1's first bridge to part 0 formed on triangle 0 and ruptured on triangle 1; of it only the formation is left."""
    columns = ["step", "kind", "partner_kind", "i", "j", "triangle"]
    before, then = [1, 0, 1, 1, 0, 0], [[20, 0, 1, 1, 0, 1], [30, 1, 1, 1, 0, 1]]
    tables = {"events": pd.DataFrame([before, *then], columns=columns), "ledger": pd.DataFrame({"step": [30]}),
              "bridges": pd.DataFrame(columns=columns, dtype=np.int64)}  # fmt: skip

    def missing(active: bool) -> int:
        known = {"lives": np.array([active, True, True])}
        part = SimpleNamespace(table=tables.__getitem__, since=10, known=known)
        return sum(map(len, chain.broken_lives(part).values()))  # type: ignore[arg-type]

    assert (missing(active=False), missing(active=True)) == (0, 1)


def test_each_bridge_is_found_as_one_after_the_other_says() -> None:
    """Lives of many bridges, asked at every step, before its events and after them; sphere 9 has none."""
    random, stands, rows = np.random.default_rng(3), np.zeros(6, bool), []
    for step in range(40):
        for j in np.flatnonzero(random.random(6) < 0.3):
            rows.append([step, int(stands[j]), 0, 1, j + 2, 1e-3 * len(rows), 1.0, 0.1])
            stands[j] ^= True
    names = ["step", "kind", "partner_kind", "i", "j", "volume", "rupture_distance", "speed"]
    events = pd.DataFrame(rows, columns=names)
    first, then = events[events["step"] < 15], events[events["step"] >= 15]
    earlier = Lives(none(), first, 0, -1)
    lives = Lives(earlier.active(), then, len(first), 14)
    for step, j, strictly in itertools.product(range(15, 45), [*range(2, 8), 9], (True, False)):
        mine = events[(events["j"] == j) & (events["step"] < step + (not strictly))]
        want = mine["volume"].iloc[-1] if len(mine) and mine["kind"].iloc[-1] == 0 else np.nan
        asked = keys(pd.DataFrame({"partner_kind": [0], "i": [1], "j": [j]})), np.array([step]), strictly
        assert np.array_equal(lives.formed_with(*asked)[0], [want], equal_nan=True)
        assert np.array_equal(np.append(lives.all.volume, np.nan)[lives.at(*asked)], [want], equal_nan=True)


def test_a_log_out_of_order_is_refused(heap_dir: Path, tmp_path: Path) -> None:
    """Expect that a log out of order is refused, since chunks cannot be sorted afterwards."""

    def change(tables: injected_log.Tables) -> None:
        tables["events"] = tables["events"].iloc[::-1]

    injected = injected_log.plant(heap_dir, tmp_path, injected_log.Injected(change, "", ""))
    with pytest.raises(io.ReplayError, match="is not in the order of its steps"):
        replay(injected)


def test_compiled_and_plain_loop_are_one(heap_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Expect the same bits: the compiler neither reorders nor fuses operations."""
    run = io.read(heap_dir)
    events, fixed, tables = run.table("events"), bodies.bodies(run), transfer.Tables(run.table("transfer"))
    partners, outputs, results = bodies.pairs(events, fixed), np.array([0, 500, 1000]), []
    for _ in range(2):
        held, lives = fixed.liquid(), Lives(none(), events, 0, -1)
        columns, shots = liquid_ledger.book(events, partners, fixed, tables, lives, held, True, outputs)
        results.append([*columns, shots, held, lives.all.recomputed])
        for name in ("_book", "_ask", "_grant", "_ratio"):
            monkeypatch.setattr(liquid_ledger, name, getattr(getattr(liquid_ledger, name), "py_func", None))
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(*results, strict=True))


def test_median_of_many_is_good_to_a_thousandth() -> None:
    """Compare the median of the histogram that represents more deviations than are stored; it depends on the values alone."""
    values = np.random.default_rng(1).lognormal(-30.0, 5.0, 2 * compare.STORED)
    parts = [compare.Deviations(part) for part in np.array_split(values, 7)]
    together = compare.gathered(parts)
    one_by_one = parts[0]
    for part in parts[1:]:
        one_by_one = compare.gathered([one_by_one, part])
    assert together.count == one_by_one.count == len(values)
    assert together.median == one_by_one.median
    # classes of the histogram have ten binary digits of the mantissa
    assert abs(together.median / np.median(values) - 1.0) < 2.0**-10
