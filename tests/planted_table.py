"""Writes docs/planted_faults.md, one table of all injected faults, from the tests: `python -m tests.planted_table`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from tests.engines.liggghts import planted, planted_in_bin, planted_in_yard
from tests.reference_impl import (
    planted_files,
    planted_log,
    planted_yard,
    test_newton,
    test_report,
    test_scenes,
    test_vtk,
)

PAGE = Path(__file__).parents[1] / "docs" / "planted_faults.md"


class Place(NamedTuple):
    """Where some faults are planted, in a word and a sentence, the test that plants them, and name -> (shows in, named)."""

    word: str
    sentence: str
    test: str
    faults: Mapping[str, tuple[str, str]]


def shown(faults: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Of faults that carry their quantity and words."""
    return {name: (fault.quantity, fault.words) for name, fault in faults.items()}


def motion() -> dict[str, tuple[str, str]]:
    """Of numbers that engine and reference are told differently: those that are named, and those that are found alone."""
    found = {name: (quantity, "") for name, quantity in test_newton.SEEN_IN.items()}
    return found | {n: (found.get(n, ("newton_torque",))[0], words) for n, (_, words) in test_newton.NAMED.items()}


def of_report(faults: Mapping[str, tuple[Any, str]], where: str) -> dict[str, tuple[str, str]]:
    """What is read back has no quantities, each sentence begins with its place."""
    return {name: (where, words) for name, (_, words) in faults.items()}


BEFORE = (
    Place("scene", "files of a sound screening run, before the engine", "reference_impl/test_sections.py",
          shown(planted_files.SCENE)),
)  # fmt: skip
ENGINE = (
    Place("plugin", "a copy of the plugin's sources, built and run: spheres drawn off a floor, a plate and each other",
          "engines/liggghts/test_planted_faults.py", planted.NAMED | planted.MOTION),
    Place("plugin, yard", "the same; a heap on a shaken screen, a drawn plate, a floor, pairs in flight; films that grow",
          "engines/liggghts/test_planted_in_yard.py",
          {**planted_in_yard.IN_YARD, **{k: v for faults in planted_in_yard.SCENES.values() for k, v in faults.items()}}),
    Place("plugin, bin", "the same; a bed of which the lowest layer is retired", "engines/liggghts/test_planted_faults.py",
          planted_in_bin.IN_PLUGIN),
    Place("log, bin", "tables of a sound run of that bed", "engines/liggghts/test_retirement.py",
          {name: (quantity, words) for name, (_, _, quantity, words) in planted_in_bin.FAULTS.items()}),
    Place("log", "the history of a sound run of twelve spheres, or the laws and constants that it claims",
          "reference_impl/test_diagnosis.py", shown(planted_log.FAULTS)),
    Place("tables", "tables next to the logs of that sound run", "reference_impl/test_planted_yard.py",
          shown(planted_yard.FAULTS)),
    Place("motion", "what the reference reads of a sound run's bodies and contacts", "reference_impl/test_newton.py",
          motion()),
)  # fmt: skip
AFTER = (
    Place("results", "tables and summary of a sound screening run", "reference_impl/test_sections.py",
          shown(planted_files.RESULTS)),
    Place("own scene", "results of the shipped drum", "own_scene/test_examples.py", shown(planted_files.OWN)),
    Place("VTK", "the code that writes VTK files", "reference_impl/test_vtk.py",
          {name: (f"vtk_{quantity}", words) for name, (_, _, quantity, words) in test_vtk.FAULTS.items()}),
    Place("drawing", "the code that draws the report's figures", "reference_impl/test_report.py",
          of_report(test_report.DRAWN, "figures")),
    Place("3-D scene", "what a page holds for its 3-D scene", "reference_impl/test_scenes.py",
          of_report(test_scenes.FAULTS, "3-D scene")),
    Place("page", "the report's page", "reference_impl/test_report.py", of_report(test_report.SHOWN, "page")),
)  # fmt: skip
HEAD = """# Injected faults

Each of these {count} faults is injected alone into a sound run (those in the tables of the yard together with faults in other
tables), must show in the quantity of the [replay](replay.md) in its row, and must be named by the words in its row: {before}
before the engine, {engine} in it or its logs, {after} downstream of it; {nameless} are found without a name.
`python -m tests.planted_table` makes this page from the tests; long rounds run with `pytest -m slow`.

"""
UNSEEN = (
    ("a bridge that is missed between two outputs outside the detailed-logging intervals, and formed before the next", "",
     "missed formations are searched for at outputs and in those intervals; a late one shows in its event"),
    ("errors of the exact bridge's tables below their stated limits", "",
     "a sample of the records is solved again: force within 1e-3 of that at touch, rupture distance within 2e-4"),
    ("a custom law", "", "its term is taken as logged (`unchecked` in replay.json)"),
    ("contact forces of the dry model, without recorded motion", "",
     "with `output.window_trajectories` Newton's law shows them"),
    ("a wrong reading of a paper that engine and reference share", "",
     "both use the same corrected equations; the law comparison and the exact bridge judge the laws"),
)  # fmt: skip
"""What the replay cannot see without a run to show it."""
WHY = {
    "forces that act": "the log says what was computed; what acts shows in the motion only",
    "forces outside the contact log": "forces are logged in windows; volumes, shares and films are checked in the whole run",
}
TAIL = """
If the records cannot distinguish faults, all candidates are reported (`alike` in replay.json). What motion, energy budget and
counts show of the same fault is reported as its consequence, so that a fault in the log gives one finding. A fault injected into
`scene.json` also contradicts the deck; that finding is further down in the replay's list.

## Coverage

- Late formation or rupture: every event. A film a few per cent too thin shows where a sphere approaches slowly (in the yard: 5 %
  of 30 µm at 15 mm/s and 2e-5 s). Near an edge a formation that seems late is accepted if the sphere may have been at another
  triangle one step before.
- Missed formation, triangle, end, gap: every output, and every step of the intervals that record motion.
- Forces outside those intervals: groups of spheres without new neighbours between outputs, up to 2000 steps in all; without
  walls, dry contacts, semi-implicit drag and `bridges_every`.
- Energy budget: its sum at every output; shared among the effects where an interval holds two outputs.

## What the replay cannot detect

| what | injected and run | why |
|---|---|---|
{unseen}

## Limits

The list is of faults that somebody thought of. [Random faults](faults_by_chance.md) are the fairer test and find less. A wrong
reading that both sides share is found by no replay ([shared readings](shared_readings.md)).
"""


def rows(places: tuple[Place, ...]) -> Iterator[tuple[str, ...]]:
    """Fault, place, quantity, words."""
    for place in places:
        for name, (quantity, words) in place.faults.items():
            yield name, place.word, quantity, words or "–"


def page() -> str:
    """The whole page."""
    table = [*rows(BEFORE), *rows(ENGINE), *rows(AFTER)]
    counts = {"before": len([*rows(BEFORE)]), "engine": len([*rows(ENGINE)]), "after": len([*rows(AFTER)])}
    head = HEAD.format(count=len(table), nameless=sum(row[3] == "–" for row in table), **counts)
    places = [f"- **{p.word}**: {p.sentence} (`tests/{p.test}`, {len(p.faults)})" for p in (*BEFORE, *ENGINE, *AFTER)]
    lines = ["", "| fault | injected into | shows in | named |", "|---|---|---|---|", *map(line, table)]
    seen = [line((what, words, WHY[what])) for what, (_, _, words) in planted.UNSEEN.items()] + [*map(line, UNSEEN)]
    return head + "\n".join([*places, *lines]) + "\n" + TAIL.format(unseen="\n".join(seen))


def line(columns: tuple[str, ...]) -> str:
    """One line of a table; a browser must not take what stands in it for its own."""
    plain = (c.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ") for c in columns)
    return "| " + " | ".join(plain) + " |"


if __name__ == "__main__":
    PAGE.write_text(page())
