"""Source `engines`: whole scenes in both engines, if `snakemake engines` has run them (results/crosscheck).

Two groups of seeds are compared by the statistics of `pywet compare`; a deviation is that of the means, and the
tooltip states whether it exceeds the seeds' spread.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.compare import statistics, verdict
from pywet.compare.statistics import Sample
from pywet.errors import PywetError
from pywet.util.files import read_table
from studies.cross_code.model import Cell, Floats, Source, basis, empty, impossible, measured, not_run, truth
from studies.cross_code.rows import EASO, EXACT, LIGGGHTS, REFERENCE, SAME, WASHINO, YADE

HOW = "run `snakemake --cores 2 engines`, then `snakemake --cores 2 agreement`"
EMPTY = {
    EXACT: "no exact solution of a bed of spheres is known",
    REFERENCE: "the reference replays what an engine logged; it does not simulate a bed",
}
PROGRAMS = {LIGGGHTS: "LIGGGHTS+pywet", YADE: "YADE", WASHINO: "washino", EASO: "easo"}
MOIST = {"bed_moist_height": "mean_height_over_radius", "bed_moist_contacts": "contacts_per_sphere"}
DRY_PROGRAMS = {LIGGGHTS: "LIGGGHTS, dry", YADE: "YADE, dry"}
DRY_BED = {"bed_dry_height": "mean_height_over_radius", "bed_dry_contacts": "contacts_per_sphere"}
"""Row -> column of the beds' tables."""
CONTACTS = {"case_restitution": "restitution", "case_friction": "friction"}
"""Row -> beginning of the quantity's name in contacts/rows.parquet."""
BEDS = "../crosscheck/bed/"
ENDS = {"end_height": "mean height at the end", "end_neighbours": "neighbours per sphere at the end"}
"""Row -> quantity of `pywet compare`."""
LINK = "../crosscheck/dry/"


def source(crosscheck: Path) -> Source:
    """Return the cells of beds, contacts and dry screening, and the fraction retained of every run for the picture."""
    dry = crosscheck / "dry"
    groups = {engine: sorted(p.parents[1] for p in dry.glob(f"{engine}/seed*/results/fraction_retained.parquet"))
              for engine in (LIGGGHTS, YADE)}  # fmt: skip
    cells: list[Cell] = []
    for row in ("retained_dry", *ENDS, *MOIST, *DRY_BED):
        cells += empty(row, EMPTY if row in MOIST else EMPTY | dict.fromkeys((WASHINO, EASO), SAME))
    cells += [*_beds(crosscheck), *_contacts(crosscheck)]
    if min(len(g) for g in groups.values()) < 2:
        cells += [not_run(row, column, HOW) for row in ("retained_dry", *ENDS) for column in (LIGGGHTS, YADE)]
        return Source("engines", cells)
    return Source("engines", [*cells, *_retained(groups)], {"retained": _curves(groups)})


def _retained(groups: dict[str, list[Path]]) -> Iterator[Cell]:
    """Yield the fraction retained over time, and the bed at the end, of both groups."""
    try:
        comparison = verdict.compare(groups[LIGGGHTS], groups[YADE], force=True)
    except PywetError as error:
        yield from (not_run(row, YADE, str(error)) for row in ("retained_dry", *ENDS))
        return
    by_name = {r.quantity: r for r in comparison.rows}
    curves = [r for name, r in by_name.items() if name.startswith("fraction retained")]
    yield from _pair("retained_dry", curves, groups, lambda r: r.deviation)
    for row, name in ENDS.items():
        ends = [by_name[name]] if name in by_name else []
        yield from _pair(row, ends, groups, lambda r: abs(r.a - r.b) / (abs(r.a) or 1.0))


def _pair(
    row: str, rows: list[verdict.Row], groups: dict[str, list[Path]], size: Callable[[verdict.Row], float]
) -> Iterator[Cell]:  # fmt: skip
    """Yield the cells that compare YADE with LIGGGHTS as the basis, by the quantity with the largest deviation."""
    if not rows:
        yield not_run(row, YADE, HOW)
        return
    n, m = len(groups[LIGGGHTS]), len(groups[YADE])
    worst = max(rows, key=size)
    beyond = [r.quantity for r in rows if r.different]
    message = (
        f"beyond the spread of {n} and {m} seeds: {', '.join(beyond)}"
        if beyond
        else f"within the spread of {n} and {m} seeds"
    )
    at = worst.quantity + (f", t = {worst.time_s:.2f} s" if worst.time_s is not None else "")
    note = f"means {worst.a:.4g} and {worst.b:.4g}; {message} (least p {min(r.p or 0.0 for r in rows):.2g})"
    yield basis(row, LIGGGHTS, f"stock LIGGGHTS, mean of {n} seeds", n, LINK)
    yield Cell(row, YADE, "measured", size(worst), m, None, at, note, LINK, not beyond)


def _curves(groups: dict[str, list[Path]]) -> dict[str, Any]:
    """Return the fraction retained of every run of both groups, at the times of the first."""
    tables = {engine: [read_table(r / "results" / "fraction_retained.parquet") for r in runs]
              for engine, runs in groups.items()}  # fmt: skip
    time = tables[LIGGGHTS][0]["time_since_opening_s"]
    at_times = {engine: [np.interp(time, t["time_since_opening_s"], t["fraction_retained"]).tolist() for t in of]
                for engine, of in tables.items()}  # fmt: skip
    return {"time": time.tolist(), **at_times}


def _beds(crosscheck: Path) -> Iterator[Cell]:
    """Yield cells of beds settled in all programs from the same positions, one row of bed.parquet per program and seed."""
    files = sorted(crosscheck.glob("bed/seed*/bed.parquet"))
    table = pd.concat([read_table(f) for f in files]) if files else pd.DataFrame({"engine": []})
    for rows, programs in ((MOIST, PROGRAMS), (DRY_BED, DRY_PROGRAMS)):
        for row, column in rows.items():
            values = {c: table.loc[table["engine"] == name, column].to_numpy(float) if files else np.array([])
                      for c, name in programs.items()}  # fmt: skip
            ours = values.pop(LIGGGHTS)
            if len(ours) < 2:
                yield from (not_run(row, name, HOW) for name in programs)
                continue
            yield basis(row, LIGGGHTS, f"mean {ours.mean():.4g} of {len(ours)} seeds", len(ours), BEDS)
            yield from (_set_against(row, name, ours, other, BEDS) for name, other in values.items())


def _contacts(crosscheck: Path) -> Iterator[Cell]:
    """Yield restitution and friction of a screening case's contacts at its own time step, compared with the configured ones."""
    file = crosscheck / "contacts" / "rows.parquet"
    table = read_table(file) if file.exists() else pd.DataFrame({"quantity": [], "engine": []})
    for row, start in CONTACTS.items():
        yield truth(row, EXACT, "the coefficient that is configured")
        yield impossible(row, REFERENCE, "a dry run on the stock program logs no contacts")
        yield from empty(row, dict.fromkeys((WASHINO, EASO), SAME))
        for column, engine in ((LIGGGHTS, "LIGGGHTS"), (YADE, "YADE")):
            part = table[table["quantity"].str.startswith(start) & (table["engine"] == engine)] if len(table) else table
            if part.empty:
                yield not_run(row, column, HOW)
                continue
            names = part["quantity"].to_list()
            value, wanted = part["value"].to_numpy(float), part["reference_value"].to_numpy(float)
            note = "mean over instants of touch within a step, at the case's own time step"
            yield measured(row, column, value, wanted, at=names, note=note, link="../crosscheck/contacts/")


def _set_against(row: str, column: str, ours: Floats, other: Floats, link: str) -> Cell:
    """Return the means of the seeds, and whether the difference exceeds their spread."""
    if len(other) < 2 or len(ours) < 2:
        return not_run(row, column, HOW)
    scale = abs(float(ours.mean()))
    _, (finding,) = statistics.test([Sample(ours[:, None] / scale, other[:, None] / scale)])
    message = "beyond" if finding.p <= statistics.LEVEL else "within"
    off = abs(float(other.mean() - ours.mean())) / scale
    note = f"mean {other.mean():.4g} of {len(other)} seeds, {message} their spread (p = {finding.p:.2g})"
    return Cell(row, column, "measured", off, len(other), None, "", note, link, finding.p > statistics.LEVEL)
