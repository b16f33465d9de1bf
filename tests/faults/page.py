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
BEFORE = "before"
"""Further column: who noticed when it was first tried, before checks and tests were added because of it."""
HEAD = """# Faults by chance

Made by `python -m tests.faults.page` from `faults_by_chance.csv`, the kept outcome of `python -m tests.faults`.
{count} random changes, {distinct} of them distinct.

`python -m tests.faults --new 300 --seed 1` changes an operator, a constant, an index, a sign, two arguments or a whole line
at random places of the plugin, the laws, the driver, the scene, the results and the time series, and says of each who
notices. One process has everything imported; each trial is a copy of it that reads anew what the change touches, with the
engine in a copy of that one, and ends at the first who objects. Three scenes (case 2 on a sieve of 40 mm for 0.2 s; the same
with prisms, semi-implicit drag, weight and drops; the same with bridges in every second step) are known line by line, and a
fault runs in the first that comes to its line; a law that none of them uses runs in a scene with it. `--room plugin` (and
others) keeps to one; a call with the same `--out` goes on where the last one ended; `--tests` then asks the test files that
import the changed module about what is left.

- **crash**: a traceback or a signal, which nobody needs a check for; not counted as found.
- **replay**, **program**, **tests**: who noticed first; the program stops with a sentence of its own, tests were asked last.
- **alike**: nobody noticed, and the reason stands below: what the change gives is equal, or equal for every input that the
  program accepts.
- **open**: nobody noticed, and it is a fault.
- *found*: of those that are neither crash nor alike; *before*: the same when they were first tried, before checks and tests
  were added for what they showed.

Where the reason says that tests were not asked, an open change may still be one that they notice.

"""
NOTICED = ("replay", "program", "tests")
NAMES = ("crash", *NOTICED, "alike", "open")
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
    lines = [f"| room | changes | {' | '.join(NAMES)} | before | found |", "|---|" + "---|" * (len(NAMES) + 3)]
    for room in [*dict.fromkeys(r["room"] for r in distinct), "all"]:
        tried = [r for r in distinct if room in ("all", r["room"])]
        of = Counter(verdict(r) for r in tried)
        noticed = sum(of[name] for name in NOTICED)
        early = sum(verdict(r) in NOTICED and r[BEFORE] not in OPEN for r in tried)
        counts = " | ".join(str(of[name]) for name in NAMES)
        all_faults = noticed + of["open"]
        lines.append(f"| {room} | {len(tried)} | {counts} | {early} of {all_faults} | {noticed} of {all_faults} |")
    lines += ["", "## What nobody noticed", "", "| where | change | why |", "|---|---|---|"]
    for r in sorted((r for r in distinct if r["by"] in OPEN), key=lambda r: (verdict(r), r["file"], int(r["line"]))):
        what = r["what"].replace("|", "\\|")
        lines.append(f"| {r['file']}:{r['line']} | `{what}` | {r[WHY] or 'not looked into'} |")
    return HEAD.format(count=len(rows), distinct=len(distinct)) + "\n".join(lines) + "\n"


def keep(table: Path) -> None:
    """Take the rows of a table of trials over, with the reasons and first verdicts that are kept already."""
    known = {(r["file"], r["line"], r["what"]): r for r in read(KEPT)}
    rows = []
    for r in read(table):
        old = known.get((r["file"], r["line"], r["what"]), {})
        rows.append({**r, BEFORE: old.get(BEFORE, r["by"]), WHY: old.get(WHY, "")})
    write(KEPT, rows, (*COLUMNS, BEFORE, WHY))


if __name__ == "__main__":
    if sys.argv[1:]:
        keep(Path(sys.argv[1]))
    PAGE.write_text(page(read(KEPT)))
