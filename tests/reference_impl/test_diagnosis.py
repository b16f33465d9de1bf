"""The diagnosis names what was changed in the log of a real run, where and since when, and costs nothing where all agrees."""

from __future__ import annotations

import json
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reference_impl.diagnosis import diagnosis, faults, residual
from reference_impl.diagnosis.diagnosis import Link, Suspect
from reference_impl.diagnosis.suspects import CHANGES, PIECES, exchanged
from reference_impl.replay import command, laws
from reference_impl.replay.compare import compare
from reference_impl.replay.replay import replay, table
from tests.reference_impl import injected_log

LENGTH = 200


@pytest.mark.engine
def test_a_sound_run_is_not_diagnosed(heap_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Expect that the diagnosis is not even called if everything agrees."""
    monkeypatch.setattr(faults, "find", lambda *_: pytest.fail("diagnosed without need"))
    result = replay(heap_dir)
    assert result["ok"] and result["diagnosis"] is None


@pytest.mark.engine
@pytest.mark.parametrize("name", injected_log.FAULTS)
def test_fault_in_the_log_is_named(heap_dir: Path, tmp_path: Path, name: str) -> None:
    """Named first, in its own equation; what only follows from it is not called a fault of its own."""
    fault = injected_log.FAULTS[name]
    result = replay(injected_log.plant(heap_dir, tmp_path, fault))
    assert not result["ok"]
    found = result["diagnosis"]["findings"]
    assert fault.words in found[0]["sentence"] and fault.quantity in found[0]["quantities"], found
    assert found[0]["share"] == 1.0
    assert len(found) == 1  # consequences in motion, energy terms and counts are listed with this cause
    assert found[0]["sentence"] in table(result)
    assert json.loads((tmp_path / "replay.json").read_text())["diagnosis"] == result["diagnosis"]


@pytest.mark.engine
def test_first_record_and_share_are_named(heap_dir: Path, tmp_path: Path) -> None:
    """A fault from some step on at the floor only: where, since when and how many."""

    def change(tables: injected_log.Tables) -> None:
        rows = (tables["contacts"]["step"] >= 1500) & (tables["contacts"]["partner_kind"] == laws.LARGE_WALL)
        tables["contacts"].loc[rows, "capillary"] *= 0.7

    injected = injected_log.Injected(change, "capillary", "it is 0.7 times")
    found = replay(injected_log.plant(heap_dir, tmp_path, injected))["diagnosis"]["findings"]
    log = pd.read_parquet(heap_dir / "history" / "contacts.parquet")
    changed = log[(log["step"] >= 1500) & (log["partner_kind"] == laws.LARGE_WALL)]
    assert len(found) == 1
    assert (found[0]["where"], found[0]["since"]) == ("at walls", f"in every record since step {changed['step'].min()}")
    assert found[0]["explained"] == found[0]["disagree"] == len(changed)
    assert found[0]["number"] == pytest.approx(0.7, rel=1e-9)  # written with nine digits
    assert found[0]["known"] == (
        f"capillary force (at walls, in every record since step {changed['step'].min()}): it is 0.7 times what is expected"
    )


@pytest.mark.engine
def test_what_nothing_explains_is_reported_so(heap_dir: Path, tmp_path: Path) -> None:
    """Noise is no fault with a name."""

    def change(tables: injected_log.Tables) -> None:
        noise = np.random.default_rng(1).normal(1.0, 0.1, len(tables["contacts"]))
        tables["contacts"]["capillary"] *= noise

    injected = injected_log.Injected(change, "capillary", "")
    found = replay(injected_log.plant(heap_dir, tmp_path, injected))["diagnosis"]["findings"]
    assert [f["fault"] for f in found] == [None]
    assert "cause not among the" in found[0]["sentence"] and found[0]["explained"] == 0


@pytest.mark.engine
@pytest.mark.parametrize(
    ("log", "columns", "quantity"),
    [
        ("bridges", ["separation"], "snapshot_separation"),
        ("films", ["film"], "snapshot_films"),
        ("impulses", ["impulse_x"], "between_momentum"),
    ],
)
def test_what_has_no_name_is_reported_next_to_what_has_one(
    heap_dir: Path, tmp_path: Path, log: str, columns: list[str], quantity: str
) -> None:
    """Noise in another log than the named fault's is described, as a finding or beneath the one that it may follow from."""
    run = injected_log.plant(heap_dir, tmp_path, injected_log.FAULTS["torque on j left out"])
    path = run / "history" / f"{log}.parquet"
    noisy = pd.read_parquet(path)
    noisy[columns] *= np.random.default_rng(1).normal(1.0, 0.1, (len(noisy), len(columns)))
    noisy.to_parquet(path, index=False)
    result = replay(run)
    found = result["diagnosis"]["findings"]
    assert "it is left out" in [f["fault"] for f in found] and quantity not in result["diagnosis"]["follow"]
    described = [s for f in found for s in (f["sentence"], *f["consequences"]) if quantity in f["quantities"]]
    assert any("cause not among the" in sentence for sentence in described), result["diagnosis"]


@pytest.mark.engine
def test_exit_status_of_the_command(heap_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0, 1 with the table and one sentence, 2; JSON holds what replay.json holds."""
    wrong = injected_log.plant(heap_dir, tmp_path / "wrong", injected_log.FAULTS["torque on j left out"])
    assert command.run([heap_dir]) == 0
    output_text = capsys.readouterr()
    assert "contacts at" in output_text.out and output_text.err == ""
    assert command.run([wrong]) == 1
    output_text = capsys.readouterr()
    assert "fault: torque on j (between spheres, in every record): it is 0 times what is expected" in output_text.out
    assert "suspect: torque on j: it is left out" in output_text.out
    assert output_text.err.strip() == "the replay disagrees on torque_j; its worst records are in replay.json"
    assert command.run([heap_dir, wrong], as_json=True) == 1
    both = json.loads(capsys.readouterr().out)
    assert [found["status"] for found in both] == ["in part", "disagrees"]  # without recorded motion
    assert both[1]["quantities"] == json.loads((wrong / "replay.json").read_text())["quantities"]
    (wrong / "history" / "events.parquet").write_bytes(b"PAR1 and no more")
    assert command.run([wrong]) == 2
    assert "is not a readable Parquet table" in capsys.readouterr().err
    pd.read_parquet(heap_dir / "history" / "events.parquet").drop(columns="speed").to_parquet(
        wrong / "history" / "events.parquet"
    )
    assert command.run([heap_dir, wrong]) == 2
    assert "lacks speed; expected the columns" in capsys.readouterr().out


def link(logged: np.ndarray, expected: np.ndarray, suspects: list[Suspect], **more: object) -> Link:
    """A link of its own, for the rules of judgement."""
    steps = pd.DataFrame({"step": np.arange(len(logged)), "i": 1, "j": 2})
    return Link("x", "thing", steps, logged, expected, np.abs(expected), lambda _: iter(suspects), **more)  # type: ignore[arg-type]


GAPS = np.linspace(0.0, 1.0, LENGTH)
SIDE = np.random.default_rng(3).normal(0.0, 1.0, (LENGTH, 3))
RESIDUALS: dict[str, tuple[np.ndarray, np.ndarray, str]] = {
    "factor": (0.7 * (1.0 + GAPS), 1.0 + GAPS, "it is 0.7 times what is expected"),
    "factor near one": (1.001 * (1.0 + GAPS), 1.0 + GAPS, "it is 1.001 times what is expected"),
    "sign": (-1.0 - GAPS, 1.0 + GAPS, "it is -1 times what is expected"),
    "amount": (GAPS + 0.25, GAPS, "it is off by +0.25 in every record"),
    "of the gap": (
        (1.0 + GAPS) * (2.0 - GAPS), 1.0 + GAPS,
        "it is 1.5 times what is expected (middle half of the records 1.25 to 1.75); the factor falls with the gap"),
    "too small": ((1.0 + GAPS) * (0.99 - 0.02 * GAPS), 1.0 + GAPS, "it is too small by 0.02 of its value; the factor falls"),
    "noise": (
        (1.0 + GAPS) * np.random.default_rng(2).normal(1.0, 0.01, LENGTH), 1.0 + GAPS, "it is off to both sides by 0.0"),
    "nothing expected": (1.0 + 0.0 * GAPS, 0.0 * GAPS, "it is 1 where zero is expected"),
    "components": (SIDE[:, [0, 2, 1]], SIDE, "components y, z are exchanged or turned"),
    "sign of one": (SIDE * [1.0, 1.0, -1.0], SIDE * [0.1, 0.1, 1.0] + [0.0, 0.0, 0.0], "its direction is not"),
    "turned": (SIDE * [1.0, -1.0, -1.0], SIDE, "component y has the other sign and component z has the other sign"),
    "one component": (SIDE * [1.0, 1.0, 1.1], SIDE, "in component z alone"),
    "direction": (SIDE[::-1], SIDE, "its direction is not the expected one"),
}  # fmt: skip


@pytest.mark.parametrize("name", RESIDUALS)
def test_residuals_say_by_which_factor_or_amount(name: str) -> None:
    logged, expected, words = RESIDUALS[name]
    assert words in residual.described(logged, expected, pd.DataFrame({"separation": GAPS}))


def test_residuals_say_which_part_and_at_which_kind_of_contact() -> None:
    """Half of one of two parts; a factor of its own at each kind; a vector part by its size."""
    one, two, wall = 1.0 + GAPS, np.sin(20.0 * GAPS), np.arange(LENGTH) % 2 == 0
    assert "; the wave would be 0.5 times what is expected (100 % of the residual)" in residual.described(
        one + 0.5 * two, one + two, None, {"the trend": one, "the wave": two}
    )
    assert residual.described(
        np.where(wall, 0.5, 3.0) * one, one, None, None, {"between spheres": ~wall, "at walls": wall}
    ) == "it is 3 times what is expected between spheres and it is 0.5 times what is expected at walls"  # fmt: skip
    table = pd.DataFrame({"step": np.arange(LENGTH), "partner_kind": np.where(wall, 2, 0)})
    (found,) = diagnosis.judge(Link("x", "thing", table, 2.0 * one, one, one, lambda _: iter(())))
    assert found.known == "thing (between spheres and at wires, in every record): it is 2 times what is expected"
    (found,) = diagnosis.judge(Link("x", "thing", table, np.where(wall, 2.0, 1.0) * one, one, one, lambda _: iter(())))
    assert found.known.startswith("thing (at wires, in 100 of 200 records, the first at step 0 ()")


def test_what_no_equation_contains_is_described_by_its_worst_record() -> None:
    """Of several quantities those that are beyond their limits first; the others follow."""
    steps = pd.DataFrame({"step": [10, 20], "i": [1, 2], "partner_kind": [0, 1]})
    one = np.ones(2)
    found = {"findings": [], "follow": [], "not_explained": ["late", "first"]}
    quantities = [
        compare(n, "itself", np.array([1.0 + (at == 0), 2.0]), one, one, steps)
        for at, n in enumerate(("first", "late"))
    ]
    named = diagnosis.with_unexplained(found, quantities[::-1])
    assert named is not None and named["follow"] == ["late"]
    assert [f["sentence"] for f in named["findings"]] == [
        "first (between spheres, since step 10): it is 2. where 1. is expected (worst of 2 records: step 10, i 1)"
    ]


def test_two_faults_in_one_equation() -> None:
    """Each named with the records that are its own."""
    expected = np.linspace(1.0, 2.0, LENGTH)
    logged = np.where(np.arange(LENGTH) < 120, 2.0 * expected, expected**2 + 5.0)
    first, second = diagnosis.judge(
        link(logged, expected, [Suspect("square", expected**2 + 5.0), Suspect("double", 2.0 * expected)])
    )
    assert (first.fault, first.explained, first.broken) == ("double", 120, 200)
    assert (second.fault, second.explained, second.broken) == ("square", 80, 80)
    assert first.next_best == ("square", 80 / 200)


def test_equal_suspects_are_reported_to_be_equal() -> None:
    """Expect that all suspects are reported that explain all records; a general one never replaces a cause."""
    expected = np.ones(LENGTH)
    names, some = ("cause", "other cause", "third"), np.where(np.arange(LENGTH) < 150, 2.0, 1.0)
    alike = [
        Suspect("seen", 2.0 * expected, general=True),
        *(Suspect(name, 2.0 * expected) for name in names),
        Suspect("part", some),
    ]
    (found,) = diagnosis.judge(link(2.0 * expected, expected, alike))
    assert found.fault == "cause"
    assert "cannot be distinguished from: other cause, or third)" in found.sentence
    assert found.as_dict()["alike"] == ["other cause", "third"]


def test_no_quantity_is_a_consequence_of_itself() -> None:
    """Not in several steps either: two findings would each be listed beneath the other one, and neither reported."""
    assert tuple(TopologicalSorter(diagnosis.SHOW_AGAIN).static_order())


def test_what_follows_is_excused() -> None:
    """A record that is right by the other link's value is not broken."""
    expected, logged = np.ones(LENGTH), np.full(LENGTH, 3.0)
    assert diagnosis.judge(link(logged, expected, [], excuses=(logged,))) == []


def test_exchanged_pieces_are_put_back() -> None:
    """After each trial the reference's laws are what they were."""
    before = [(module, name, getattr(module, name)) for pieces in PIECES.values() for module, name, _ in pieces]
    for pieces in PIECES.values():
        with exchanged(pieces):
            assert all(getattr(module, name) is other for module, name, other in pieces)
    assert all(getattr(module, name) is was for module, name, was in before)
    assert len(CHANGES) + len(PIECES) >= 25
