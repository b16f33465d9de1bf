"""A replay that compared nothing of a kind that the scene has does not say that it agrees."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pywet
from reference_impl.diagnosis.held import Held, Section
from reference_impl.motion import dynamics
from reference_impl.replay import command, nothing, replay, spans
from reference_impl.replay.compare import Quantity, compare
from tests.test_sound_runs import SCENES

DRUM = {
    "effects": {"bridges": True, "shedding": "tate"}, "output": {"energy": True}, "classes": [{"count": 60}], "retire": True,
    "viscous_integration": "semi_implicit",
    "walls": [{"name": "mantle", "motion": "turns"}, {"name": "cloth", "motion": "fixed"}],
}  # fmt: skip
"""A scene that has one of everything."""
COUNTED = tuple(dict.fromkeys(kind.quantity for kind in nothing.KINDS))
LAW = {"between_spheres": 7, "at_walls": 5, "on mantle": 4, "on cloth": 3}
"""Of walls those that move or are of analytic wires (see test_injected_fixture.py)."""


def unchecked(law: dict[str, int], *left_out: str) -> list[str]:
    """Sentences of a drum's replay in which nothing of `left_out` was compared."""
    quantities = [Quantity(name, "itself", 0 if name in left_out else 9, 0.0, 1e-9) for name in COUNTED]
    return nothing.compared(DRUM, quantities, {"newton": law}, [])


@pytest.mark.parametrize("name", LAW)
def test_contacts_of_a_kind(name: str) -> None:
    """Moving walls too: their motion enters nothing but the forces of what is in contact with them."""
    assert unchecked(LAW) == []
    words = {
        "between_spheres": "between spheres", "at_walls": "with walls", "on mantle": "wall mantle", "on cloth": "wall cloth",
    }[name]  # fmt: skip
    (sentence,) = unchecked({**LAW, name: 0})
    assert words in sentence


@pytest.mark.parametrize("kind", nothing.KINDS, ids=lambda kind: kind.quantity)
def test_every_kind_without_a_record_is_listed(kind: nothing.Kind) -> None:
    """One sentence where the scene has the kind; none where it has not."""
    assert unchecked(LAW, kind.quantity) == [kind.sentence]
    dry = {
        "effects": {"bridges": False}, "output": {}, "classes": [{"count": 60}],
        "walls": [{"name": "floor", "motion": "fixed"}],
    }  # fmt: skip
    law = {"newton": LAW}
    assert nothing.compared(dry, [Quantity("newton_force", "itself", 9, 0.0, 1e-9)], law, []) == []


def test_without_recorded_motion() -> None:
    """Of a moist scene Newton's law, dry contacts, powers and what semi-implicit drag starts from; the rest is compared."""
    quantities = [Quantity(k.quantity, "itself", 0 if k.recorded else 9, 0.0, 1e-9) for k in nothing.KINDS]
    found = nothing.compared(DRUM, quantities, {"newton": None}, [])
    assert [sentence.split(":")[0] for sentence in found] == [
        "power of each effect", "semi-implicit drag", "Newton's law", "dry contacts between spheres", "dry contacts with walls",
    ]  # fmt: skip
    assert all(sentence.endswith(": the run recorded no motion in windows") for sentence in found)


def test_contacts_by_the_law_of_another_engine() -> None:
    """They are in the windows; only their law is not recomputed."""
    assert unchecked({"foreign": 345}) == [
        f"dry contacts {where}: they follow the engine's own law" for where in ("between spheres", "with walls")
    ]


def test_bridges_missing_from_a_run_without_events() -> None:
    """Films that touch at the outputs of a run in which no bridge forms disagree; only what has no record is left out."""
    found, one = spans.Found(), np.ones(2)
    found.add("snapshots", [compare("formation_missed", "one", one, 0.0 * one, one, {}, 0.0)])
    found.add("snapshots", [Quantity("event_triangle", "radius", 0, 0.0, 1e-9)])
    run: Any = SimpleNamespace(shed=[])
    assert [(q.name, q.ok) for q in replay._with_rows(run, found)] == [("formation_missed", False)]


def test_quantities_without_a_record_are_listed() -> None:
    """Expect that no quantity without a record passes as compared."""
    both = [Quantity("volume", "itself", 9, 0.0, 1e-9), Quantity("event_part", "itself", 0, 0.0, 1e-9)]
    assert nothing.without_record(both) == ["no record of: event_part"]
    assert nothing.without_record(both[:1]) == []


def test_shares_of_the_run_that_were_seen_are_reported() -> None:
    """4 of 100 steps of a dry run; of a moist run the sentence has all four shares, of one seen step by step there is none."""
    assert dynamics.seen(None, {"windows": [(0, 2), (5, 7)], "steps": 99}) == {"steps": 0.04}
    shares = {"steps": 0.04, "bridges": 0.5, "impulse_in_windows": 0.06, "impulse_by_bounds": 0.9}
    (sentence,) = dynamics.beyond(shares)
    assert re.findall(r"[\d.]+ %", sentence) == ["4 %", "50 %", "6 %", "90 %"]
    assert dynamics.beyond({**shares, "steps": 1.0}) == dynamics.beyond({"steps": 0.04}) == []


def test_a_section_without_a_value() -> None:
    """It is not checked, whatever it says of its quantities; one value is enough for a verdict."""
    section = Section("results")
    section.add("results_checks", "1", [], "values of the checks")
    assert section.sentence == "results: not checked" and section.as_dict()["ok"] is None
    both = [Quantity(name, "itself", 1, 0.0, 1.0) for name in (*COUNTED[:2], "newton_force")]
    bare = {**DRUM, "output": {}, "effects": {"bridges": False}, "retire": False, "walls": []}
    assert nothing.compared(bare, both, {"newton": LAW}, [section]) == ["section results: no value"]
    section.add("results_checks", "1", [Held("a", 1.0, 1.0, "logs")], "values of the checks")
    assert section.as_dict()["ok"] is True


@pytest.mark.engine
def test_a_run_without_any_contact_agrees_in_part(tmp_path: Path) -> None:
    """Two beads that fall side by side: the liquid on them and their flight agree, of contacts and bridges nothing is known."""
    pywet.run(pywet.Scene(name="beads", **SCENES["no bridge forms"]), tmp_path)
    found = command.outcome(tmp_path)
    assert found["ok"] and (found["status"], command.STATUS[found["status"]]) == ("in part", 0)
    assert len(found["nothing_compared"]) == 5
