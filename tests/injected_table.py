"""Writes docs/injected_faults.md and .csv, all injected faults, from the tests: `python -m tests.injected_table`."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from reference_impl.replay import nothing
from tests.compare import test_intervals
from tests.cost import test_reference
from tests.engines import test_lammps
from tests.engines.liggghts import injected, injected_between, injected_in_bin, injected_in_fixture
from tests.reference_impl import (
    injected_files,
    injected_fixture,
    injected_log,
    test_configuration_files,
    test_described,
    test_newton,
    test_nothing_compared,
    test_plan,
    test_report,
    test_scenes,
    test_vtk,
)
from tests.report import test_ovito, test_vtkhdf

PAGE = Path(__file__).parents[1] / "docs" / "injected_faults.md"
LISTED = PAGE.with_suffix(".csv")


class Place(NamedTuple):
    """Position of some injected faults in a word and a sentence, their test, and name -> (quantity, words of the message)."""

    word: str
    sentence: str
    test: str
    faults: Mapping[str, tuple[str, str]]


def shown(faults: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return the rows of faults that carry their quantity and words."""
    return {name: (fault.quantity, fault.words) for name, fault in faults.items()}


def motion() -> dict[str, tuple[str, str]]:
    """Return the rows of numbers that differ between engine and reference: those named, and those found alone."""
    found = {name: (quantity, test_newton.NAMED_DRY.get(name, "")) for name, quantity in test_newton.SEEN_IN.items()}
    return found | {n: (found.get(n, ("newton_torque",))[0], words) for n, (_, words) in test_newton.NAMED.items()}


def of_report(faults: Mapping[str, tuple[Any, str]], where: str) -> dict[str, tuple[str, str]]:
    """Return the rows of faults in pages: they have no quantity, and each message begins with the position."""
    return {name: (where, words) for name, (_, words) in faults.items()}


def of_exports(faults: Mapping[str, tuple[str, Any, str]], where: str) -> dict[str, tuple[str, str]]:
    """Return the rows of faults in files for other programs: each message names the column or the quantity."""
    return {name: (where, words) for name, (_, _, words) in faults.items()}


BEFORE = (
    Place("scene", "input files of a screening run", "reference_impl/test_sections.py",
          shown(injected_files.SCENE)),
    Place("configuration", "the code that reads the configuration", "reference_impl/test_configuration_files.py",
          {name: ("scene_configuration", words[0]) for name, (_, *words) in test_configuration_files.FAULTS.items()}),
    Place("custom scene, built", "the code that builds a user-defined scene", "reference_impl/test_described.py",
          {name: ("scene_description", words) for name, (_, _, words) in test_described.FAULTS.items()}),
    Place("plan", "the code that plans effects", "reference_impl/test_plan.py",
          {name: ("scene_plan", f"plan.{effect}.number") for name, (_, effect) in test_plan.FAULTS.items()}),
)  # fmt: skip
ENGINE = (
    Place("plugin", "a modified build of the plugin, with spheres pulled off a floor, a plate and each other",
          "engines/liggghts/test_injected_faults.py", injected.NAMED | injected.MOTION),
    Place("plugin, screen",
          "the same, with a heap on a vibrating screen, a moving plate, pairs in flight, growing films",
          "engines/liggghts/test_injected_in_fixture.py",
          {**injected_in_fixture.IN_FIXTURE,
           **{k: v for faults in injected_in_fixture.SCENES.values() for k, v in faults.items()}}),
    Place("plugin, between",
          "the same screen, default sampling windows: forces between the sampled steps, work",
          "engines/liggghts/test_injected_between.py",
          {name: (quantity, words) for name, (_, quantity, words) in injected_between.FAULTS.items()}
          | injected_between.ON_RANKS),
    Place("plugin, bin", "the same, in a bed whose lowest layer is retired",
          "engines/liggghts/test_injected_faults.py",
          injected_in_bin.IN_PLUGIN),
    Place("log, bin", "tables of a sound run of the bed with a retired layer", "engines/liggghts/test_retirement.py",
          {name: (quantity, words) for name, (_, _, quantity, words) in injected_in_bin.FAULTS.items()}),
    Place("LAMMPS", "the script of a run in LAMMPS", "engines/test_lammps.py",
          {name: (quantity, words) for name, (_, quantity, words) in test_lammps.FAULTS.items()}),
    Place("log", "event and contact logs of a run with twelve spheres, including laws and constants",
          "reference_impl/test_diagnosis.py", shown(injected_log.FAULTS)),
    Place("tables", "other tables of the same run", "reference_impl/test_injected_fixture.py",
          shown(injected_fixture.FAULTS)),
    Place("motion", "masses, contacts and walls as the reference reads them", "reference_impl/test_newton.py",
          motion()),
)  # fmt: skip
AFTER = (
    Place("results", "result tables and summary of a screening run", "reference_impl/test_sections.py",
          shown(injected_files.RESULTS)),
    Place("custom scene", "results of the example drum", "cases/custom/test_examples.py", shown(injected_files.CUSTOM)),
    Place("VTK", "the code that writes VTK files", "reference_impl/test_vtk.py",
          {name: (f"vtk_{quantity}", words) for name, (_, _, quantity, words) in test_vtk.FAULTS.items()}),
    Place("OVITO", "the code that writes files for OVITO", "report/test_ovito.py", of_exports(test_ovito.FAULTS, "OVITO")),
    Place("VTKHDF", "the code that writes VTKHDF files", "report/test_vtkhdf.py", of_exports(test_vtkhdf.FAULTS, "VTKHDF")),
    Place("drawing", "the code that draws the report's figures", "reference_impl/test_report.py",
          of_report({**test_report.DRAWN, **test_report.BANDS, **test_report.LATE}, "figures")),
    Place("3-D scene", "data of the 3-D scene in the report", "reference_impl/test_scenes.py",
          of_report(test_scenes.FAULTS, "3-D scene")),
    Place("page", "numbers of the report, in report.json", "reference_impl/test_report.py", of_report(test_report.SHOWN, "page")),
)  # fmt: skip
FIXTURE_WORKS = {name: fault for name, fault in injected_fixture.FAULTS.items() if name.startswith("works: ")}
NO_RECORD = [f"{kind.quantity} without a record" for kind in nothing.KINDS] + [
    f"no dry contact {name}" for name in test_nothing_compared.LAW
]
KINDS: dict[str, tuple[str, Iterable[str], Iterable[str]]] = {
    "forces between the sampled steps": (
        "replay",
        injected_between.FORCES,
        (
            "pull of spheres halved unseen",
            "forces of walls halved unseen",
            "semi-implicit drag halved unseen",
            "drag halved for a while unseen",
        ),
    ),
    "work of one effect": ("replay", [*injected_between.WORKS, *FIXTURE_WORKS], ("work of drag twice",)),
    "analytic wires": (
        "replay",
        [*injected_between.OF_WIRES, *injected_between.ON_RANKS, "work of wires turned"],
        (
            "springs of wires stay on their rank",
            "forces of wires a tenth high",
            "wires at rest for friction",
            "work of wires turned",
        ),
    ),
    "drops": ("replay", injected_between.OF_DROPS, ("drops at half the force felt",)),
    "user-defined scenes": (
        "replay",
        test_described.FAULTS,
        (
            "angle of a wall replaced by the spheres'",
            "friction at walls times 0.8",
            "inserted spheres wait a hundredth too far",
        ),
    ),
    "reading of the configuration": (
        "replay",
        test_configuration_files.FAULTS,
        ("viscosity a tenth high where the liquid is looked up",),
    ),
    "drawn, not read back": (
        "replay",
        [
            *(f"VTK {n}" for n in test_vtk.FAULTS),
            *(f"OVITO {n}" for n in test_ovito.FAULTS),
            *(f"VTKHDF {n}" for n in test_vtkhdf.FAULTS),
            *(f"3-D {n}" for n in test_scenes.FAULTS),
        ],
        ("OVITO force and gap exchanged", "OVITO y mirrored"),
    ),
    "intervals, effect numbers, predicted cost": (
        "replay (numbers), tests (others)",
        [*test_plan.FAULTS, *test_intervals.FAULTS, *test_reference.FAULTS],
        ("root of n - 1", "variance of the response left out", "capillary number halved"),
    ),
    "nothing compared of a kind that the scene has": ("replay, as `in part`", NO_RECORD, ("no dry contact on mantle",)),
    "curves of the report": ("reading of the report", [*test_report.DRAWN, *test_report.BANDS, *test_report.LATE], ()),
}
"""Kind of fault that an earlier replay could not detect: what detects it now, its injected faults, and those of them that were
injected by others first."""
HEAD = """# Injected faults

Faults were injected into sound runs, one at a time. Each of these {count} faults is detected by the [replay](replay.md) and
described by a message; {nameless} are detected without a description. Of the faults, {before} are upstream of the engine,
{engine} in the engine or its logs, {after} downstream of it. The replay cannot detect {missed} further kinds of fault
([see below](#what-the-replay-cannot-detect)). The table [injected_faults.csv](injected_faults.csv) lists for each
the deviating quantity and a fragment of the message.

| injected into | faults |
|---|---|
"""
UNSEEN = (
    ("a formation that is missed between two outputs outside the sampling windows, but takes place before the second output",
     "missed formations are searched for at outputs and in windows"),
    ("errors of the exact bridge's tables below their stated limits",
     "only a sample of the records is solved again: force within 1e-3 of that at touch, rupture distance within 2e-4"),
    ("a custom law without a reference implementation",
     "the force of the law is taken from the log (`unchecked` in replay.json)"),
    ("contact forces of the dry model, without recorded motion",
     "they are checked by Newton's law only with `output.window_trajectories`"),
    ("a wrong reading of a paper that engine and reference share",
     "both use the same corrected equations ([shared assumptions](shared_readings.md))"),
    ("interchanged words in the report, such as two column headings or two labels of a legend",
     "the replay checks numbers by their keys in report.json; a test compares the words with `tests/data/report`"),
)  # fmt: skip
"""What the replay cannot see without a run to show it."""
WHY = {
    "forces that act": "the log contains the computed force; the force that acts is visible only in the motion",
    "forces outside the contact log": "forces are logged only in sampling windows; volumes, shares and films are checked in "
    "the whole run",
}
TAIL = """
If the records cannot distinguish several faults, all are reported (`alike` in `replay.json`).
`python -m tests.injected_table` makes this page and its CSV file from the tests.

## What the replay cannot detect

| fault | reason |
|---|---|
{unseen}

## Coverage

- **Late formations and ruptures** are searched for in every event; allowed is one step at a wall's edge, and for
  ruptures the speed of the fastest event, up to 0.2 m/s, lost in a step: much of a viscous bridge's limit.
- **Missed formations, bridges beyond their limits, wrong triangles, bridge ends or gaps** are searched for at every output
  and every step of the sampling windows; missed formations with drops at outputs.
- **Forces outside those windows** are recomputed for groups of spheres that get no new neighbours between two outputs, in up to
  2000 steps, but not at walls, in dry contacts, with semi-implicit drag or with `bridges_every`.
- **Predicted time, memory and disk space** are not part of a run; a test compares them with `reference_impl/scene/cost.py`
  and detects {predicted} further faults.
- **The energy budget** is checked as a sum at every output, and term by term in windows that contain two outputs.

## Limits

The faults were chosen by hand; of [random faults](faults_by_chance.md) a smaller share is detected.
"""


def rows(places: tuple[Place, ...]) -> Iterator[tuple[str, ...]]:
    """Fault, place, quantity, words."""
    for place in places:
        for name, (quantity, words) in place.faults.items():
            yield name, place.word, quantity, words or "–"


COLUMNS = ("fault", "injected_into", "detected_by", "identified_by")


def table() -> str:
    """Every fault as a row of the CSV file."""
    file = io.StringIO()
    csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows((*BEFORE, *ENGINE, *AFTER))])
    return file.getvalue()


def page() -> str:
    """The whole page."""
    places = (*BEFORE, *ENGINE, *AFTER)
    faults = [*rows(places)]
    nameless = sum(row[3] == "–" for row in faults)
    counts = {"before": len([*rows(BEFORE)]), "engine": len([*rows(ENGINE)]), "after": len([*rows(AFTER)])}
    missed = len(injected.UNSEEN) + len(UNSEEN)
    lines = []
    for p in places:
        lines.append(line((f"**{p.word}**: {p.sentence}", str(len(p.faults)))))
    seen = [line((f"{what}: {words}", WHY[what])) for what, (_, _, words) in injected.UNSEEN.items()] + [
        *map(line, UNSEEN)
    ]
    head = HEAD.format(count=len(faults), nameless=nameless, missed=missed, **counts)
    return head + "\n".join(lines) + "\n" + TAIL.format(unseen="\n".join(seen), predicted=len(test_reference.FAULTS))


def line(columns: tuple[str, ...]) -> str:
    """One line of a table; a browser must not take what is in it for its own."""
    plain = (c.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ") for c in columns)
    return "| " + " | ".join(plain) + " |"


if __name__ == "__main__":
    PAGE.write_text(page())
    LISTED.write_text(table())
