"""The table of a sweep in tidy form: one row for each run, units in the metadata of its columns."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import FileError
from pywet.products.partition import WITHIN
from pywet.products.screening_report import cut_position, stored, unsteady
from pywet.schema import unit_of
from pywet.sweep.base_kind import Numbers
from pywet.sweep.description import Function
from pywet.sweep.gathering import gathered
from pywet.sweep.plan import Plan, Run
from pywet.sweep.run_numbers import AT_END, CUT_SIZE, SCREEN, WALL_TIME
from pywet.util.files import atomic_write, read_table, write_csv

NAME = "sweep.parquet"
DONE, FAILED = "done", "failed"
ABOUT = {
    "point": "number of the point", "seed": "counted from the base's", "status": f"{DONE} or {FAILED}",
    "reason": f"of a failure; of a result that could not be measured; of a {CUT_SIZE} that is absent or at an end of the sizes; "
    "of a screen that is not steady",
}  # fmt: skip
PURE = ("e_n", "e_t", "e_omega", *AT_END)
"""Results that are dimensionless, with the unit `1`."""


def units(plan: Plan) -> dict[str, str]:
    """Return the unit of every axis and result: 1 if dimensionless, empty if unknown."""
    found = {key: unit_of(key) for key in plan.sweep.axes}
    for name in plan.gather:
        if isinstance(name, Function):
            found[name.name] = name.unit or unit_of(name.name)
        else:
            found[name] = unit_of(name) or ("1" if name in PURE or "share" in name or "fraction" in name else "")
    return found


def frame(plan: Plan) -> pd.DataFrame:
    """Return the table: point, axes, seed, results, status, reason, folder of the run relative to the table's.

    `attrs["missing"]`: number of runs that the next call tries again.
    """
    rows = [_row(plan, run) for run in plan.runs]
    made = pd.DataFrame(rows)
    for name in plan.results:
        made[name] = made[name].astype(float)
    made.attrs |= {"units": units(plan), "missing": len(plan.missing)}
    return made


def _row(plan: Plan, run: Run) -> dict[str, Any]:
    place = plan.store.place(run.built.name)
    measured = gathered(plan, run)
    found, why = measured or (dict.fromkeys(plan.results), [plan.store.reason(run.built.name)])
    status = FAILED if why and all(value is None for value in found.values()) else DONE
    reason = "; ".join(why if measured is None else [*why, *_notes(plan, place, found)])
    link = os.path.relpath(place, plan.folder)
    return {
        "point": run.point.number, **run.point.values, "seed": run.seed, **found, "status": status, "reason": reason, "run": link,
    }  # fmt: skip


def _notes(plan: Plan, place: Path, found: Numbers) -> list[str]:
    """Say why a run has no cut size or one at an end of the sizes, that its screen is not steady, why it has no wall time."""
    notes = []
    if SCREEN.keys() & {*plan.results} and (numbers := stored(place)):
        if CUT_SIZE in plan.results and (where := cut_position(numbers)) != WITHIN:
            notes.append(f"{CUT_SIZE}: {where}")
        if warning := unsteady(numbers):
            notes.append(f"screen {warning}")
    if found.get(WALL_TIME, 0.0) is None:
        notes.append(f"{WALL_TIME}: unknown, as the run was resumed from a checkpoint")
    return notes


def write(plan: Plan, made: pd.DataFrame) -> Path:
    """Write `sweep.parquet`, with the unit of a column under `unit` in the metadata of its field, and `sweep.csv`."""
    import pyarrow as pa
    from pyarrow import parquet

    rows = pa.Table.from_pandas(made, preserve_index=False)
    of = units(plan)
    fields = [
        f.with_metadata({k: v for k, v in (("unit", of.get(f.name, "")), ("about", ABOUT.get(f.name, ""))) if v})
        for f in rows.schema
    ]
    path = plan.folder / NAME
    with atomic_write(path) as temporary:
        schema = pa.schema(fields, metadata={"sweep": plan.sweep.name})
        parquet.write_table(rows.cast(schema), temporary, write_page_checksum=True)
    write_csv(made, path.with_suffix(".csv"))
    return path


def read(folder: Path) -> pd.DataFrame:
    """Read the table of a finished sweep; `attrs["units"]`: unit of its columns."""
    from pyarrow import parquet

    path = folder / NAME
    if not path.exists():
        raise FileError(
            f"there is no {path}; expected the table of a sweep: run `pywet sweep FILE` first",
            path=path, code="sweep.no_table",
        )  # fmt: skip
    made = read_table(path, "run `pywet sweep FILE` again")
    schema = parquet.read_schema(path)
    made.attrs["units"] = {f.name: (f.metadata or {}).get(b"unit", b"").decode() for f in schema}
    return made
