"""Moist screening in LIGGGHTS and YADE: one row of numbers for each run of the two workflows, and the table of the page.

`python -m studies.engines.moist` takes what `snakemake --config seeds=4` and `snakemake --config seeds=4 engine=yade` have left
in results/smoke and results/smoke_yade into docs/second_engine.csv, in addition to what is there, and writes the table between
the marks of docs/second_engine.md. A run whose replay or ledger disagrees is not taken.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.compare.quantities import RunData, read_run
from pywet.compare.statistics import of_difference
from pywet.errors import PywetError, border
from pywet.util.files import atomic_write

ROOTS = {"LIGGGHTS": Path("results/smoke"), "YADE": Path("results/smoke_yade")}
PAGE = Path("docs/second_engine.md")
TABLE = PAGE.with_suffix(".csv")
HEAD = """
## Moist screening

The moist cases at smoke scale at their end: mean in LIGGGHTS, in YADE; difference and its 95 % confidence interval (Student), in
bold where that excludes zero. Runs: [second_engine.csv](second_engine.csv).

"""
MARKS = ("<!-- moist screening: python -m studies.engines.moist -->\n", "<!-- end -->")
SHOWN = {
    "retained": "fraction retained", "on_spheres": "liquid on spheres", "in_bridges": "liquid in bridges",
    "on_walls": "liquid on walls", "bridges_per_sphere": "bridges per sphere",
}  # fmt: skip
"""Column -> what it is at the end of a run; liquid over all of it."""
WALLS = ("wires", "side wall", "feed bin", "slide", "outlet", "impact plate", "collecting bin")


def row(run: RunData, engine: str) -> dict[str, float | int | str]:
    """The numbers of one run at its end."""
    if failed := [name for name, (is_right, _) in run.checks.items() if not is_right]:
        raise PywetError(f"{run.path}: {', '.join(failed)} failed; expected a run that is sound: see its report.html")
    end = {name: float(q.values[-1]) for name, q in run.quantities.items()}
    count = next(name for name, q in run.quantities.items() if q.unit == "bridges")
    return {
        "case": int(re.findall(r"\d+", run.scene.name)[0]),
        "engine": engine,
        "seed": run.scene.seed,
        "retained": end["fraction retained"],
        "on_spheres": end["liquid coarse material"] + end["liquid fines"],
        "in_bridges": end[f"liquid {count}"],
        "on_walls": sum(end.get(f"liquid {name}", 0.0) for name in WALLS),
        "bridges_per_sphere": 2.0 * end[count] / sum(c.count for c in run.scene.classes),
    }


def gather(roots: dict[str, Path]) -> pd.DataFrame:
    """Rows of all finished moist runs with the laws of the paper."""
    rows = []
    for engine, root in roots.items():
        for folder in sorted(p.parent for p in root.glob("case*/summary.json") if "exact" not in p.parent.name):
            run = read_run(folder)
            if run.scene.effects.bridges:
                rows.append(row(run, engine))
    return pd.DataFrame(rows)


def merged(there: pd.DataFrame, found: pd.DataFrame) -> pd.DataFrame:
    """Both, a run that is in both as it was found."""
    both = pd.concat([there, found]).drop_duplicates(["case", "engine", "seed"], keep="last")
    return both.sort_values(["case", "engine", "seed"], ignore_index=True)


def lines(table: pd.DataFrame) -> list[str]:
    """The table in Markdown: for each case seeds, and of each number both means and the difference with its 95 % interval."""
    heads = ["case", "seeds", *SHOWN.values()]
    found = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for case, of in table.groupby("case"):
        one, two = (of[of["engine"] == engine] for engine in ROOTS)
        if one.empty or two.empty:
            continue
        cells = [compared(one[name].to_numpy(), two[name].to_numpy()) for name in SHOWN]
        found.append(f"| {case} | {len(one)}, {len(two)} | {' | '.join(cells)} |")
    return found


def compared(a: np.ndarray, b: np.ndarray) -> str:
    """Mean in LIGGGHTS, in YADE, the difference and its interval; bold where that leaves out zero."""
    half = of_difference(a, b)
    difference = float(b.mean() - a.mean())
    text = f"{difference:+.3f}" + ("" if half is None else f" ± {half:.3f}")
    bold = "**" if half is not None and abs(difference) > half else ""
    return f"{a.mean():.3f}, {b.mean():.3f}; {bold}{text}{bold}"


def write(table: pd.DataFrame, page: Path) -> None:
    """Put the table between the marks of a page."""
    head, _, rest = page.read_text().partition(MARKS[0])
    tail = rest.partition(MARKS[1])[2]
    if not tail:
        raise PywetError(
            f"{page} lacks the marks {MARKS[0].strip()} and {MARKS[1]}; expected both, the table goes between"
        )
    text = HEAD + "\n".join(lines(table))
    with atomic_write(page) as temporary:
        temporary.write_text(f"{head}{MARKS[0]}{text}\n\n{MARKS[1]}{tail}")


def main(given: Sequence[str]) -> None:
    """Optional: the folders of the runs in LIGGGHTS and in YADE."""
    found = gather(dict(zip(ROOTS, map(Path, given), strict=True)) if given else ROOTS)
    there = pd.read_csv(TABLE) if TABLE.exists() else found.iloc[:0]
    table = merged(there, found)
    with atomic_write(TABLE) as temporary:
        table.to_csv(temporary, index=False, float_format="%.9g")
    write(table, PAGE)
    print(f"{len(table)} runs in {TABLE}")


if __name__ == "__main__":
    with border():
        main(sys.argv[1:])
