"""Print the output of `pywet sweep FILE` and `pywet sweep plot FILE X Y [HUE]`, step by step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd

from pywet.errors import FileError, PywetError
from pywet.report.pictures import plt
from pywet.sweep import adaptive, figures, plan, running, sweep_folder, sweep_page, table
from pywet.sweep.costs import Cost
from pywet.sweep.description import RESERVED
from pywet.sweep.plan import Plan
from pywet.sweep.table import FAILED
from pywet.util.files import atomic_write
from pywet.util.notices import bar

Say = Callable[[str], None]
Costs = list[tuple[plan.Run, Cost]]
SUFFIXES = (".svg", ".png", ".pdf")


def check(asked: Plan, cores: int, ranks: int | None, say: Say) -> Costs:
    """Check a whole sweep, print its cost, and return the missing runs with their predicted costs."""
    with bar("checking points") as move:
        costs = asked.cost(move)
    for line in plan.lines(asked, costs, cores, ranks):
        say(line)
    plan.refuse_too_much(asked, costs)
    return costs


def carry_out(asked: Plan, cores: int, ranks: int | None, more: int, say: Say) -> pd.DataFrame:
    """Check, execute missing runs, write table and page; `more`: number of points to add where the map is most uncertain."""
    missing = check(asked, cores, ranks, say)
    sweep_folder.claim(asked.folder, asked.file)
    made = _run(asked, missing, cores, ranks, say)
    if more:
        before = len(asked.points)
        asked = adaptive.extended(asked, made, more)
        if (added := len(asked.points) - before) < more:
            say(
                f"{added} of {more} points are added: others between the ends of the axes are points already or cannot be run"
            )
        missing = check(asked, cores, ranks, say)
        adaptive.write(asked)
        made = _run(asked, missing, cores, ranks, say)
    for line in finish(asked, made):
        say(line)
    return made


def _run(asked: Plan, missing: Costs, cores: int, ranks: int | None, say: Say) -> pd.DataFrame:
    with bar("runs of the sweep") as move:
        running.carry_out(asked, [run for run, _ in missing], cores, ranks, move)
    if (spent := plan.spent(asked, missing)) is not None:
        say(spent)
    return table.frame(asked)


def finish(asked: Plan, made: pd.DataFrame) -> list[str]:
    """Write table and page from the store, and return the lines to print."""
    table.write(asked, made)
    shown = sweep_page.write(asked, made)
    return [*sweep_page.sentences(asked, made), f"{asked.folder / table.NAME}, {shown}"]


def failures(made: pd.DataFrame) -> str | None:
    """Return one sentence on the runs without results, with the first reason."""
    failed = made[made["status"] == FAILED]
    if failed.empty:
        return None
    first = failed.iloc[0]
    again = "; the next call tries them again" if made.attrs["missing"] else ""
    return (
        f"{len(failed)} of {len(made)} runs have no results, first point {first['point']}, seed {first['seed']}: "
        f"{first['reason']}{again}"
    )


def plot(given: Path, names: list[str], out: Path | None) -> Path:
    """Draw columns of a finished sweep's table into a file; the sweep is given by its file or by its folder."""
    file = sweep_folder.owner(given) if given.is_dir() else given
    if file is None:
        raise FileError(
            f"{given} holds no sweep; expected the file of a sweep, or the folder of its table",
            path=given, code="sweep.none",
        )  # fmt: skip
    asked = plan.read_file(file, given if given.is_dir() else None)
    made = table.read(asked.folder)
    target = out or asked.folder / f"{'-'.join(names)}.svg"
    if target.suffix not in SUFFIXES:
        raise PywetError(
            f"--out is {target}; expected a file that ends in {', '.join(SUFFIXES)}",
            code="sweep.plot_suffix", key="--out", given=target.suffix, expected=SUFFIXES,
        )  # fmt: skip
    results = [c for c in made.columns if c not in (*asked.sweep.axes, *RESERVED)]
    figure = figures.drawn(asked.sweep, made, results, names[0], names[1], names[2] if len(names) > 2 else None)
    with atomic_write(target) as temporary:
        figure.savefig(temporary)
    plt.close(figure)
    return target
