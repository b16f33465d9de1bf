"""Moist screening in LIGGGHTS and YADE: one row of numbers for each run of the smoke scale, and the table of the page.

    python -m studies.engines.moist run --cases 2 8 11 14 --seeds 4 --minutes 30
    python -m studies.engines.moist

The first makes the runs that are missing in results/smoke and results/smoke_yade, seed by seed, and stores the row of each in
docs/second_engine.csv as it ends: repeated, it resumes. No run begins after so many minutes. Both calls then add the runs that
`snakemake --config seeds=4` and `snakemake --config seeds=4 engine=yade` have left in those folders to that file, and write the
table between the marks of docs/second_engine.md. A run whose replay or ledger disagrees is not taken.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import t as student

from pywet import run_folder, stages
from pywet.compare.quantities import RunData, read_run
from pywet.compare.statistics import of_difference
from pywet.engines.pipeline import RunInfo
from pywet.errors import PywetError, border
from pywet.util.files import atomic_write, read_json

CONFIG, SCALE = Path("config"), "smoke"
MOIST = (2, 3, 5, 6, 8, 9, 11, 12, 14, 15, 17, 18)
ROOTS = {"LIGGGHTS": Path("results/smoke"), "YADE": Path("results/smoke_yade")}
PAGE = Path("docs/second_engine.md")
TABLE = PAGE.with_suffix(".csv")
HEAD = """
## Moist screening

Each cell gives a quantity at the end of a moist case at smoke scale: mean in LIGGGHTS; YADE minus LIGGGHTS with
its 95 % confidence interval (Student), bold if the interval excludes zero, as one in twenty does
by chance. Runs: [second_engine.csv](second_engine.csv).

"""
MARKS = ("<!-- moist screening: python -m studies.engines.moist -->\n", "<!-- end -->")
SHOWN = {
    "retained": "fraction retained", "on_spheres": "liquid on spheres", "in_bridges": "liquid in bridges",
    "on_walls": "liquid on walls", "bridges_per_sphere": "bridges per sphere",
}  # fmt: skip
"""Column -> its meaning at the end of a run; liquid relative to all of it."""
WALLS = ("wires", "side wall", "feed bin", "slide", "outlet", "impact plate", "collecting bin")


def row(run: RunData, engine: str) -> dict[str, float | int | str]:
    """Return the numbers of one run at its end."""
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
        "cpu_s": RunInfo(**read_json(run.path / "engine" / "run.json", "run the case again")).cpu_s or float("nan"),
    }


def simulate(case: int, engine: str, seed: int) -> Path:
    """Run a case with a seed unless its folder contains that run already; return the folder, named as in the workflow."""
    name = engine.lower()
    loaded = stages.resolved(CONFIG, engine=name, seed=seed)
    first = stages.resolved(CONFIG, engine=name).settings.seed
    folder = ROOTS[engine] / (loaded.case(case).name + ("" if seed == first else f"-{seed}"))
    with run_folder.hold(folder):
        if failed := stages.carry_out(loaded, case, SCALE, folder, name):
            raise PywetError(f"{folder}: stage {failed.failed_at} failed: {failed.reason}")
    return folder


def run(cases: Sequence[int], seeds: int, minutes: float) -> None:
    """Execute the runs without a row, all cases and both engines of a seed before the next; failed ones are reported."""
    started, first = time.monotonic(), stages.resolved(CONFIG).settings.seed
    for seed, case, engine in product(range(first, first + seeds), cases, ROOTS):
        there = stored()
        if ((there["case"] == case) & (there["engine"] == engine) & (there["seed"] == seed)).any():
            continue
        spent = (time.monotonic() - started) / 60.0
        if spent > minutes:
            print(f"{spent:.0f} minutes are over; repeated, the call resumes with case {case}, {engine}, seed {seed}")
            return
        try:
            found = row(read_run(simulate(case, engine, seed)), engine)
        except PywetError as error:
            print(error, file=sys.stderr, flush=True)
            continue
        store(pd.DataFrame([found]))
        print(" ".join(f"{key} {value}" for key, value in found.items()), flush=True)


def stored() -> pd.DataFrame:
    """Read the rows of all stored runs."""
    return pd.read_csv(TABLE) if TABLE.exists() else pd.DataFrame(columns=["case", "engine", "seed"])


def store(found: pd.DataFrame) -> pd.DataFrame:
    """Add rows to the stored table and return all rows."""
    table = merged(stored(), found)
    with atomic_write(TABLE) as temporary:
        table.to_csv(temporary, index=False, float_format="%.9g")
    return table


def gather(roots: dict[str, Path]) -> pd.DataFrame:
    """Return rows of all finished moist runs with the laws of the paper."""
    rows = []
    for engine, root in roots.items():
        for folder in sorted(p.parent for p in root.glob("case*/summary.json") if "exact" not in p.parent.name):
            run = read_run(folder)
            if run.scene.effects.bridges:
                rows.append(row(run, engine))
    return pd.DataFrame(rows)


def merged(there: pd.DataFrame, found: pd.DataFrame) -> pd.DataFrame:
    """Merge both tables; for a run in both the found row is used."""
    both = pd.concat([there, found]).drop_duplicates(["case", "engine", "seed"], keep="last")
    return both.sort_values(["case", "engine", "seed"], ignore_index=True)


def lines(table: pd.DataFrame) -> list[str]:
    """Return the table in Markdown: for each case and number the mean in LIGGGHTS and the difference with its interval."""
    heads = ["case", *SHOWN.values()]
    found = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for case, of in table.groupby("case"):
        one, two = (of[of["engine"] == engine] for engine in ROOTS)
        if one.empty or two.empty:
            continue
        cells = [compared(one[name].to_numpy(), two[name].to_numpy()) for name in SHOWN]
        found.append(f"| {case} | {' | '.join(cells)} |")
    all_cells = [over_cases(table, name) for name in SHOWN]
    return [*found, f"| all, mean difference | {' | '.join(all_cells)} |"] if len(found) > 2 else found


def over_cases(table: pd.DataFrame, name: str) -> str:
    """Return the mean of the cases' differences and its interval, from the scatter within cases with at least two seeds."""
    differences, variance, freedom = [], 0.0, 0
    for _, of in table.groupby("case"):
        one, two = (of.loc[of["engine"] == engine, name].to_numpy() for engine in ROOTS)
        if min(len(one), len(two)) > 1:
            half = of_difference(one, two)
            assert half is not None
            differences.append(two.mean() - one.mean())
            variance += (half / t_quantile(len(one) + len(two) - 2)) ** 2
            freedom += len(one) + len(two) - 2
    if not differences:
        return "–"
    return _signed(float(np.mean(differences)), t_quantile(freedom) * variance**0.5 / len(differences))


def t_quantile(freedom: int) -> float:
    """Return the half width of a 95 % interval in standard errors."""
    return float(student.ppf(0.975, freedom))


def _signed(difference: float, half: float | None) -> str:
    text = f"{difference:+.3f}" + ("" if half is None else f" ± {half:.3f}")
    return f"**{text}**" if half is not None and abs(difference) > half else text


def compared(a: np.ndarray, b: np.ndarray) -> str:
    """Return the mean in LIGGGHTS, the difference of YADE and its interval; bold if that excludes zero."""
    return f"{a.mean():.3f}; {_signed(float(b.mean() - a.mean()), of_difference(a, b))}"


def speed(table: pd.DataFrame) -> str:
    """Describe the processor time of the engine over all cases and seeds that both engines have run."""
    times = table.pivot_table("cpu_s", ["case", "seed"], "engine").reindex(columns=list(ROOTS)).dropna()
    if times.empty:
        return ""
    a, b = (float(times[engine].mean()) for engine in ROOTS)
    return (
        f"The mean processor time of the engine per run, over {len(times)} {'runs' if len(times) > 1 else 'run'} in each, is "
        f"{a:.0f} s in LIGGGHTS and {b:.0f} s in YADE "
        f"({b / a:.1f} times).\n\n"
    )


def write(table: pd.DataFrame, page: Path) -> None:
    """Insert the table between the markers of a page."""
    head, _, rest = page.read_text().partition(MARKS[0])
    tail = rest.partition(MARKS[1])[2]
    if not tail:
        raise PywetError(
            f"{page} lacks the marks {MARKS[0].strip()} and {MARKS[1]}; expected both, the table goes between"
        )
    text = HEAD + speed(table) + "\n".join(lines(table))
    with atomic_write(page) as temporary:
        temporary.write_text(f"{head}{MARKS[0]}{text}\n\n{MARKS[1]}{tail}")


def main(given: Sequence[str]) -> None:
    """Make runs on request, then the table of all."""
    parser = argparse.ArgumentParser(prog="python -m studies.engines.moist")
    parser.add_argument("what", nargs="?", choices=("run",))
    parser.add_argument("--cases", type=int, nargs="+", default=MOIST)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--minutes", type=float, default=float("inf"))
    asked = parser.parse_args(given)
    if asked.what:
        run(asked.cases, asked.seeds, asked.minutes)
    table = store(gather(ROOTS))
    write(table, PAGE)
    print(f"{len(table)} runs in {TABLE}")


if __name__ == "__main__":
    with border():
        main(sys.argv[1:])
