"""Faults in the tables next to the logs, in ends of bridges, works, counts and rows of a rank are found, each by its name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from reference_impl.replay.replay import replay
from tests import injected_table
from tests.reference_impl import injected_fixture
from tests.reference_impl.test_stream import at_size

pytestmark = pytest.mark.engine
ROUNDS = injected_fixture.rounds()
PLANNED = {
    "mesh_motion": 243, "ledger_counts": 81, "ledger_held": 81, "trajectory_velocity": 495, "energy_windows": 503,
    "energy_budget": 81, "energy_capillary": 81,
}  # fmt: skip
"""Quantities of the sound run whose records follow from its outputs, windows and bodies alone, and how many there are."""
MET = {
    "formation_late": 65, "formation_missed": 5200, "event_triangle": 6, "event_separation": 12, "snapshot_triangle": 440,
    "snapshot_ends": 900, "flight_velocity": 330, "rupture_late": 65, "time": 800,
}  # fmt: skip
"""Those that follow from what spheres meet: two thirds of what they are, as other round-off may move an event out of a window."""


def test_the_sound_run_agrees(fixture_dir: Path) -> None:
    """No false alarm; and there is something of every kind to look at, flights of spheres with bridges among them."""
    result = replay(fixture_dir)
    assert result["ok"], {n: q["worst"] for n, q in result["quantities"].items() if not q["ok"]}
    counts = {name: q["count"] for name, q in result["quantities"].items()}
    assert {n: counts[n] for n in PLANNED} == PLANNED
    assert {n: counts[n] for n in MET if counts[n] < MET[n]} == {}
    touched = {n for n, count in result["newton"].items() if n.startswith("on ") and count}
    assert touched == {"on screen", "on drawer"}  # walls that move


def test_parts_of_the_log_give_the_same(fixture_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Budgets, flights and late formations go across the cuts."""
    whole = replay(fixture_dir)["quantities"]
    assert at_size(fixture_dir, 7, monkeypatch)["quantities"] == whole


@pytest.mark.parametrize(
    "names", [pytest.param(n, marks=[pytest.mark.slow] * (k % 3 > 0)) for k, n in enumerate(ROUNDS)], ids="; ".join
)
def test_fault_in_a_table_is_named(fixture_dir: Path, tmp_path: Path, names: list[str]) -> None:
    """Each in its quantity and by its words, also next to others."""
    faults = [injected_fixture.FAULTS[name] for name in names]
    result = replay(injected_fixture.plant(fixture_dir, tmp_path / "run", *faults))
    findings = result["diagnosis"]["findings"]
    for fault in faults:
        assert not result["quantities"][fault.quantity]["ok"]
        output_text = [
            s for f in findings if fault.quantity in f["quantities"] for s in (f["sentence"], *f["consequences"])
        ]
        assert any(fault.words in sentence for sentence in output_text), (fault, output_text)


def test_the_page_lists_every_fault() -> None:
    """All that tests plant, with quantity and words; README says how many."""
    page = injected_table.page()
    assert injected_table.PAGE.read_text() == page and injected_table.LISTED.read_text() == injected_table.table()
    assert injected_table.table().count("\n") == 1 + int(page.partition("Each of these ")[2].split()[0])
    counts = (
        re.search(words, page)
        for words in (r"Each of these (\d+)", r"(\d+) downstream", r"; (\d+) are detected without")
    )
    count, after, nameless = (found[1] for found in counts if found)
    output_text = (
        f"[{count} injected faults](docs/injected_faults.md), {after} of them downstream of the engine, are found"
    )
    assert nameless == "0"
    assert f"{output_text} and described" in (injected_table.PAGE.parents[1] / "README.md").read_text()


@pytest.mark.parametrize("kind", injected_table.KINDS)
def test_each_kind_has_faults_besides_those_of_others(kind: str) -> None:
    """Five at least that were not injected by others first; each of these is among all."""
    _, every, others = injected_table.KINDS[kind]
    assert {*others} <= {*every} and len({*every} - {*others}) >= 5
