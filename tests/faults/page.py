"""Writes docs/faults_by_chance.md from the stored trials: `python -m tests.faults.page [faults.csv]` stores that file first."""

from __future__ import annotations

import re
import sys
from collections import Counter
from pathlib import Path

from tests.faults.__main__ import ASKED, COLUMNS, OPEN, read, write

DOCS = Path(__file__).parents[2] / "docs"
PAGE, STORED, UNFOUND = DOCS / "faults_by_chance.md", DOCS / "faults_by_chance.csv", DOCS / "faults_open.csv"
WHY = "why"
"""Further column of the stored table: why a fault that no check reports has no effect, or what it would take to see it."""
BEFORE = "before"
"""Further column: who noticed when it was first tried, before checks and tests were added because of it."""
HEAD = """# Random faults

The program was changed at random, one change at a time. Of {faults} changes that are faults and do not crash the program,
**{found} are detected**;
{early} of them were detected before further checks were added for this study.

{table}

- **crash**: the program ends with a traceback or a signal, which is not counted as detected.
- **replay**, **program**, **tests**: the fault was first detected by the replay, by a message of the program, or by a test.
- **equivalent**: no difference for any accepted input.
- **open**: a fault that is not detected.
- **detected**: of the faults that do not crash the program.

In {messages} of the {of_engine} changes of plugin and laws that the replay detects, the message names a force or effect of a
contact; in {kinds} of these it also names the kind of contact.

## Method

`python -m tests.faults --new 300 --seed 1` changes an operator, a constant, an index, a sign, two arguments or a whole line
at random positions of the program. Each change is tried in the variants of case 2 (of three) that execute the changed line,
until it is detected, or in a scene that uses the changed law. Changes in planning, custom scenes and calibration are tried
without an engine: the inputs of a run are built and compared with the correct ones, then tests are run.
`faults_by_chance.csv` lists the {count} changes, {distinct} of them distinct, with their outcomes;
[faults_open.csv](faults_open.csv) lists the open faults with the reason why nothing detects them.
"""
NOTICED = ("replay", "program", "tests")
NAMES = ("crash", *NOTICED, "equivalent", "open")
ENGINE = ("engines/liggghts/plugin/", "laws/")
OF_NO_CONTACT = ("scene: ", "results: ", "energy ", "sum of the works", "count in the ledger", "work in a window")
"""Begins a message on what belongs to no contact."""
KIND = re.compile(r"between (unequal )?spheres|at (large )?walls|at wires|contacts at \w+")
EQUAL = "equal: "
"""Begins the reason where a change makes no difference."""


def verdict(row: dict[str, str]) -> str:
    """The column that a fault counts in."""
    if row["by"] not in OPEN:
        return row["by"]
    return "equivalent" if row[WHY].startswith(EQUAL) else "open"


def page(rows: list[dict[str, str]]) -> str:
    """The whole page."""
    distinct = list({key(r): r for r in rows}.values())
    table = [f"| part | changes | {' | '.join(NAMES)} | detected |", "|---|" + "---|" * (len(NAMES) + 2)]
    for module in [*dict.fromkeys(r["package"] for r in distinct), "all"]:
        tried = [r for r in distinct if module in ("all", r["package"])]
        of = Counter(verdict(r) for r in tried)
        noticed = sum(of[name] for name in NOTICED)
        early = sum(verdict(r) in NOTICED and r[BEFORE] not in OPEN for r in tried)
        counts = " | ".join(str(of[name]) for name in NAMES)
        all_faults = noticed + of["open"]
        table.append(f"| {module} | {len(tried)} | {counts} | {noticed} of {all_faults} |")
    engine = [r["message"] for r in distinct if r["by"] == "replay" and r["file"].startswith(ENGINE)]
    contact = [message for message in engine if not message.startswith(OF_NO_CONTACT)]
    return HEAD.format(
        messages=len(contact),
        of_engine=len(engine),
        kinds=sum(bool(KIND.search(message)) for message in contact),
        count=len(rows),
        distinct=len(distinct),
        faults=all_faults,
        found=noticed,
        early=early,
        table="\n".join(table),
    )


def key(row: dict[str, str]) -> tuple[str, str, str]:
    """Of a row: two with the same are one fault."""
    return row["file"], row["code"], row["what"]


def unfound(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Each open fault once, by its position in the program: where, change and why nothing detects it."""
    distinct = {key(r): r[WHY] or "not examined" for r in rows if verdict(r) == "open"}
    return [{"file": f, "code": code, "change": what, "why": why} for (f, code, what), why in sorted(distinct.items())]


def keep(table: Path) -> None:
    """Add the rows of a table of trials, or replace those known, whose reasons and first verdicts stay.

    What nothing noticed before the tests were asked waits.
    """
    stored = read(STORED)
    known = {key(r): r for r in stored}
    found = {}
    for r in read(table):
        if r["by"] not in OPEN or r["message"].startswith(ASKED):
            old = known.get(key(r), {})
            found[key(r)] = {**r, BEFORE: old.get(BEFORE, r["by"]), WHY: old.get(WHY, "")}
    others = [r for r in stored if key(r) not in found]
    write(STORED, [*others, *found.values()], (*COLUMNS, BEFORE, WHY))


if __name__ == "__main__":
    if sys.argv[1:]:
        keep(Path(sys.argv[1]))
    PAGE.write_text(page(read(STORED)))
    write(UNFOUND, unfound(read(STORED)), ("file", "code", "change", "why"))
