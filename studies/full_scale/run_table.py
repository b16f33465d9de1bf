"""Tables of the full-scale page as CSV files next to it: runs, statements, and comparisons of groups of runs."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from pywet.config import Config
from pywet.util.files import atomic_write
from studies.full_scale.judging import MISSING, Answer, Statement
from studies.full_scale.spread import Runs
from studies.full_scale.stored_runs import StoredRun

RUN_COLUMNS = (
    "run", "scale", "stiffness_over_papers", "time_step_us", "engine_core_hours", "resumed", "formations",
    "contacts_replayed", "ledger_error", "replay_quantities_that_agree", "retained_5_s", "retained_10_s", "retained_20_s",
    "liquid_coarse", "liquid_fines", "liquid_walls", "engine_memory_GB", "replay_memory_GB", "disk_GB", "replay_cpu_s", "commit",
)  # fmt: skip
STATEMENT_COLUMNS = ("statement", "place", "says", "range", "values", "half_width", "verdict")


def write(path: Path, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; None becomes an empty cell."""
    with atomic_write(path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])


def run_row(config: Config, run: StoredRun) -> tuple[object, ...]:
    """Return one run's settings, cost, agreement with the replay and results, in the order of `RUN_COLUMNS`."""
    about = run.about
    stiffest = max(s.stiffness_sphere_sphere_N_per_m.value for s in config.materials.spheres.values())
    moist = bool(about["events"])
    liquid = (run.liquid("coarse_material"), run.liquid("fines"), run.walls) if moist else ()
    sizes = (about.get(key) for key in ("peak_memory_B", "replay_peak_memory_B", "disk_B"))
    return (
        run.folder.name,
        about["scale"],
        f"{about['normal_stiffness_N_per_m'] / stiffest:.2g}",
        f"{1e6 * about['time_step_s']:.3g}",
        None if about["cpu_s"] is None else f"{about['cpu_s'] / 3600:.2f}",
        "no" if about["resumed_at_step"] is None else "yes",
        about["events"]["formations"] if moist else None,
        about["contacts"],
        f"{about['ledger_error']:.0e}" if moist else None,
        len(about["replay"] or ()),
        *(f"{run.at(run.retained(), t):.3f}" if run.has(t) else None for t in (5.0, 10.0, 20.0)),
        *((f"{float(v[-1]):.3f}" for v in liquid) if moist else (None,) * 3),
        *(None if size is None else f"{1e-9 * size:.2f}" for size in sizes),
        None if about.get("replay_cpu_s") is None else f"{about['replay_cpu_s']:.0f}",
        about["commit"],
    )


def run_rows(config: Config, every: Mapping[str, Runs]) -> list[tuple[object, ...]]:
    """Return a row for every run, by the name of its settings and by case."""
    return [run_row(config, k) for group in every.values() for number in sorted(group) for k in group[number]]


def statement_rows(answers: Sequence[tuple[Statement, Answer]]) -> list[tuple[object, ...]]:
    """Return every range of every statement with its values by seed and half the 95 % interval of their mean."""
    rows: list[tuple[object, ...]] = []
    for statement, answer in answers:
        for k, part in enumerate(statement.parts):
            values = None if answer.verdict == MISSING else " ".join(f"{v:.3g}" for v in answer.values[k])
            half = f"{answer.uncertainty[k]:.2g}" if answer.uncertainty and answer.uncertainty[k] else None
            rows.append((statement.number, statement.place, statement.says, part.range, values, half, answer.verdict))
    return rows
