"""Predicted time, memory and disk: derived twice, equal for cases of all kinds; faults in the program's prediction are found."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from pywet import config
from pywet.cases.screening import cases
from pywet.cost import choice, command, cost, counts, edit, needs
from pywet.geometry import build_apparatus
from pywet.util.files import read_json
from reference_impl.scene import cost as reference

CONFIG = config.load(Path(__file__).parents[2] / "config")
STUDY = read_json(choice.STORED)
MACHINE = read_json(needs.ELSEWHERE)
SEMI = {"config.yaml: time_step viscous_integration": "semi_implicit", "config.yaml: time_step bridges_every": 2}
EXACT = {"config.yaml: laws preset": "exact"}
ANALYTIC = {"scales.yaml: scales smoke wires": "analytic"}
OTHER = {"config.yaml: laws capillary": "willett"}
KINDS: dict[str, tuple[int, str, dict[str, Any]]] = {
    "dry, smoke": (1, "smoke", {}), "moist, smoke": (2, "smoke", {}), "moist, reduced": (9, "reduced", {}),
    "dry, full": (4, "full", {}), "moist, full": (18, "full", {}), "semi-implicit, every other step": (8, "full", SEMI),
    "exact": (11, "reduced", EXACT), "another law": (5, "smoke", OTHER), "dry, analytic wires": (10, "smoke", ANALYTIC),
    "moist, analytic wires": (3, "smoke", ANALYTIC), "whole bed": (2, "full", {"config.yaml: retire": False}),
}  # fmt: skip


def of_kind(kind: str) -> tuple[config.Config, int, str]:
    case, scale, changes = KINDS[kind]
    return edit.with_entries(CONFIG, changes), case, scale


def expected(kind: str, machine: Mapping[str, Any] = MACHINE) -> dict[str, float]:
    """Return the reference's numbers of a kind of case, by the scene that the program makes of it."""
    changed, case, scale = of_kind(kind)
    row, size = changed.case(case), changed.scale(scale)
    apparatus = build_apparatus(cases.apparatus_spec(changed, row, size))
    scene = cases.assemble(changed, row, size, cases.ingredients(changed, case, scale), apparatus)
    resolved, described = (
        json.loads(json.dumps(part)) for part in (changed.resolved(case, scale), scene.model_dump(mode="json"))
    )
    return reference.predicted(resolved, described, scale, machine, STUDY)


def wrong(kind: str, numbers: dict[str, float]) -> list[str]:
    """Return the names of the numbers that the program predicts otherwise."""
    need = needs.need(*of_kind(kind), machine=needs.stored_machine())
    given = {**dataclasses.asdict(need.load), **{k: v for k, v in vars(need).items() if k != "load"}}
    given["analytic_wires"] = float(given.pop("analytic_wires"))
    assert {*given} == {*numbers}
    return [held.name for held in reference.compared(given, numbers) if held.wrong]


@pytest.mark.parametrize("kind", KINDS)
def test_prediction_is_that_of_the_reference(kind: str) -> None:
    assert wrong(kind, expected(kind)) == []


Plant = Callable[[pytest.MonkeyPatch], None]


def number(module: Any, name: str, factor: float) -> Plant:
    return lambda patch: patch.setattr(module, name, factor * getattr(module, name))


def of(owner: Any, name: str, change: Callable[..., Any]) -> Plant:
    """A function in place of another, which it is given first."""
    sound = getattr(owner, name)
    return lambda patch: patch.setattr(owner, name, lambda *given, **named: change(sound, *given, **named))


def of_load(**changes: Callable[[counts.Load], float]) -> Plant:
    def change(sound: Any, *given: Any) -> counts.Load:
        load: counts.Load = sound(*given)
        return dataclasses.replace(load, **{name: by(load) for name, by in changes.items()})

    return of(cost, "load_of", change)


def linear(sound: Any, self: cost.Coefficients, spheres: float, name: str) -> float:
    part = min(max((spheres - self.few.spheres) / (self.many.spheres - self.few.spheres), 0.0), 1.0)
    return float((1.0 - part) * getattr(self.few, name) + part * getattr(self.many, name))


FAULTS: dict[str, tuple[str, Plant, str]] = {
    "bridges act every step in the prediction": (
        "semi-implicit, every other step", of_load(evaluations=lambda load: load.steps * load.bridges), "cost.evaluations"),
    "the cost of semi-implicit drag is left out": (
        "semi-implicit, every other step",
        of(needs, "habit", lambda sound, table: dataclasses.replace(sound(table), integrations={})), "cost.seconds"),
    "the exact bridge costs as much as the default law": (
        "exact", of(needs, "habit", lambda sound, table: dataclasses.replace(sound(table), laws={})), "cost.seconds"),
    "the costs of laws are those of dry screening": (
        "another law",
        of(needs, "habit", lambda sound, table: dataclasses.replace(sound(table), laws={"willett": 0.8})), "cost.seconds"),
    "a bridge's cost is linear in the number of spheres": (
        "moist, reduced", of(cost.Coefficients, "_each", linear), "cost.seconds"),
    "lists of moist runs cost as much as those of dry ones": (
        "moist, full", of(cost, "_program", lambda sound, load: "analytic"), "cost.seconds"),
    "retired spheres go on costing": (
        "moist, full",
        of(cost.cases, "ingredients", lambda sound, *given: dataclasses.replace(
            sound(*given), retirement=dataclasses.replace(sound(*given).retirement, on=False))), "cost.seconds"),
    "spheres leave whatever number of layers there is": (
        "moist, full", of(counts, "area", lambda sound, spec: 1e3 * sound(spec)), "cost.events"),
    "no delay until passed spheres rest": ("dry, full", number(counts, "SETTLING", 1e-9), "cost.touches"),
    "collisions on the screen count for both spheres": ("dry, smoke", number(counts, "COLLISIONS", 2.0), "cost.touches"),
    "lists as if the walls were the fastest": ("dry, full", number(counts, "HOP", 1.0 / 3.0), "cost.lists"),
    "wires are near within the skin only": (
        "dry, analytic wires",
        of(counts, "near_wires", lambda sound, scene, spec: sound(scene, dataclasses.replace(spec, wire_diameter_m=0.0))),
        "cost.near"),
    "half of the disk of events is forgotten": ("moist, smoke", number(needs, "EVENT_B", 0.5), "cost.disk_B"),
    "bridges of the recorded steps take the disk of those of outputs": (
        "moist, smoke", number(needs, "CONTACT_B", 50.0 / 240.0), "cost.disk_B"),
    "memory of the spheres is left out": ("dry, full", number(needs, "SPHERE_B", 0.0), "cost.memory_B"),
    "memory of the replay is that of the engine": ("moist, full", number(needs, "REPLAY_SPHERE_B", 1.0 / 3.0), "cost.replay_B"),
}  # fmt: skip
"""Fault -> kind of case, what is changed, the number that shows it."""


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_in_the_prediction_is_found(monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """Injected into the program alone: the reference's numbers do not change."""
    kind, plant, name = FAULTS[fault]
    numbers = expected(kind)
    plant(monkeypatch)
    assert name in wrong(kind, numbers)


def test_time_shown_is_that_of_the_reference() -> None:
    """Expect in `pywet plan` the reference's seconds with the costs of this machine, or of the one in machine.json, in words."""
    shown = needs.glance(CONFIG, 2, "smoke", cases.ingredients(CONFIG, 2, "smoke"))[0]
    seconds = expected("moist, smoke", dataclasses.asdict(needs._machine()))["seconds"]
    assert command.duration(seconds) in shown
