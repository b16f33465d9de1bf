"""Writes docs/faults_by_chance.md from the kept table of trials: `python -m tests.faults.page [faults.csv]` keeps that first."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from tests.faults.__main__ import COLUMNS, OPEN, read, write

DOCS = Path(__file__).parents[2] / "docs"
PAGE, KEPT = DOCS / "faults_by_chance.md", DOCS / "faults_by_chance.csv"
WHY = "why"
"""Further column of the kept table: why what nobody notices is no fault, or what it would take to see it."""
HEAD = """# Faults by chance

Made by `python -m tests.faults.page` from `faults_by_chance.csv`, the kept outcome of `python -m tests.faults`
(how it is done: [classes of faults](replay_classes.md#faults-by-chance)). {count} random changes, {distinct} of them distinct.

- **crash**: a traceback or a signal, which nobody needs a check for; not counted as found.
- **replay**, **program**, **tests**: who noticed first; the program stops with a sentence of its own, tests were asked last.
- **alike**: nobody noticed, and the reason stands below: what the change gives is equal, or equal for every input that the
  program accepts.
- **open**: nobody noticed, and it is a fault.
- *found*: of those that are neither crash nor alike.

Of plugin, laws and driver a few have been tried so far, and there and in the scene the tests were not asked about what is open.
What the trials of results and view showed is mended: a test of what breaks a check, one of a wall that turns, and the reference
objects to VTK files that are not there.

"""
NAMES = ("crash", "replay", "program", "tests", "alike", "open")
EQUAL = "equal: "
"""Begins the reason where a change makes no difference."""


def verdict(row: dict[str, str]) -> str:
    """The column that a fault counts in."""
    if row["by"] not in OPEN:
        return row["by"]
    return "alike" if row[WHY].startswith(EQUAL) else "open"


def page(rows: list[dict[str, str]]) -> str:
    """The whole page."""
    distinct = list({(r["file"], r["line"], r["what"]): r for r in rows}.values())
    lines = [f"| room | changes | {' | '.join(NAMES)} | found |", "|---|" + "---|" * (len(NAMES) + 2)]
    for room in [*dict.fromkeys(r["room"] for r in distinct), "all"]:
        of = Counter(verdict(r) for r in distinct if room in ("all", r["room"]))
        noticed = of["replay"] + of["program"] + of["tests"]
        counts = " | ".join(str(of[name]) for name in NAMES)
        lines.append(f"| {room} | {sum(of.values())} | {counts} | {noticed} of {noticed + of['open']} |")
    lines += ["", "## What nobody noticed", "", "| where | change | why |", "|---|---|---|"]
    for r in sorted((r for r in distinct if r["by"] in OPEN), key=lambda r: (verdict(r), r["file"], int(r["line"]))):
        what = r["what"].replace("|", "\\|")
        lines.append(f"| {r['file']}:{r['line']} | `{what}` | {r[WHY] or 'not looked into'} |")
    return HEAD.format(count=len(rows), distinct=len(distinct)) + "\n".join(lines) + "\n"


def keep(table: Path) -> None:
    """Take the rows of a table of trials over, with the reasons that are kept already."""
    known = {(r["file"], r["line"], r["what"]): r[WHY] for r in read(KEPT)}
    rows = [{**r, WHY: known.get((r["file"], r["line"], r["what"]), "")} for r in read(table)]
    write(KEPT, rows, (*COLUMNS, WHY))


if __name__ == "__main__":
    if sys.argv[1:]:
        keep(Path(sys.argv[1]))
    PAGE.write_text(page(read(KEPT)))
