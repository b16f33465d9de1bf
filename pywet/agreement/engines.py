"""Source `engines`: whole scenes in both engines, as far as `snakemake engines` has run them (results/crosscheck).

Two groups of seeds are compared by the statistics of `pywet compare`; a deviation is that of the means, and the hint says
whether it is beyond the seeds' spread.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.agreement.model import (
    EASO,
    EXACT,
    LIGGGHTS,
    REFERENCE,
    WASHINO,
    YADE,
    Cell,
    Source,
    impossible,
    not_run,
    truth,
)  # fmt: skip
from pywet.agreement.rows import NO_MIGRATION
from pywet.compare import verdict
from pywet.errors import PywetError

HOW = "run `snakemake --cores 2 engines`, then `snakemake --cores 2 agreement`"
EMPTY = {
    EXACT: "no exact solution of a bed of spheres is known",
    REFERENCE: "the reference replays what an engine logged; it does not simulate a bed",
}
DRY = "without liquid it is the same program and contact as LIGGGHTS"
BED = ("mean height at the end", "neighbours per sphere at the end")


def source(crosscheck: Path) -> Source:
    """Cells of the beds and of the dry screening; bands of the fraction retained for the picture."""
    dry = crosscheck / "dry"
    groups = {engine: sorted(p.parents[1] for p in dry.glob(f"{engine}/seed*/results/fraction_retained.parquet"))
              for engine in (LIGGGHTS, YADE)}  # fmt: skip
    cells: list[Cell] = []
    for row in ("retained_dry", "bed_dry", "bed_moist"):
        cells += [impossible(row, column, why) for column, why in EMPTY.items()]
        cells += [impossible(row, column, DRY) for column in (WASHINO, EASO) if row != "bed_moist"]
    curves: dict[str, Any] = {}
    if min(len(g) for g in groups.values()) < 2:
        cells += [not_run(row, column, HOW) for row in ("retained_dry", "bed_dry") for column in (LIGGGHTS, YADE)]
    else:
        cells += list(_retained(groups))
        curves["retained"] = {engine: _band(runs) for engine, runs in groups.items()}
    return Source("engines", [*cells, *_beds(crosscheck)], curves)


def _retained(groups: dict[str, list[Path]]) -> Iterator[Cell]:
    """Fraction retained over time, and where the spheres lie at the end, of both groups."""
    try:
        found = verdict.compare(groups[LIGGGHTS], groups[YADE], force=True)
    except PywetError as error:
        yield from (not_run(row, YADE, str(error)) for row in ("retained_dry", "bed_dry"))
        return
    seeds = f"{len(groups[LIGGGHTS])} and {len(groups[YADE])} seeds"
    by_name = {r.quantity: r for r in found.rows}
    link = "../crosscheck/dry/"
    for row, names in (
        ("retained_dry", tuple(n for n in by_name if n.startswith("fraction retained"))),
        ("bed_dry", BED),
    ):
        rows = [by_name[n] for n in names if n in by_name]
        if not rows:
            yield not_run(row, YADE, HOW)
            continue
        worst = max(rows, key=lambda r: r.deviation)
        beyond = [r.quantity for r in rows if r.different]
        said = f"beyond the spread of {seeds}: {', '.join(beyond)}" if beyond else f"within the spread of {seeds}"
        at = f"{worst.quantity}" + (f", t = {worst.time_s:.2f} s" if worst.time_s is not None else "")
        note = f"means of the seeds; {said}; spread of a run there {worst.spread or 0.0:.3f}"
        yield truth(
            row, LIGGGHTS, f"stock LIGGGHTS, mean of {len(groups[LIGGGHTS])} seeds", len(groups[LIGGGHTS]), link
        )
        yield Cell(row, YADE, "measured", worst.deviation, len(groups[YADE]), None, at, note, link)


def _band(runs: list[Path]) -> dict[str, Any]:
    """Mean, least and largest fraction retained over time."""
    tables = [pd.read_parquet(r / "results" / "fraction_retained.parquet") for r in runs]
    values = np.array([t["fraction_retained"].to_numpy(float) for t in tables])
    return {
        "time": tables[0]["time_since_opening_s"].tolist(),
        "mean": values.mean(axis=0).tolist(),
        "low": values.min(axis=0).tolist(),
        "high": values.max(axis=0).tolist(),
    }


def _beds(crosscheck: Path) -> Iterator[Cell]:
    """Moist beds that were settled in several programs: crosscheck/beds.json, rows of engine, quantity, deviation, note."""
    row, file = "bed_moist", crosscheck / "beds.json"
    if not file.exists():
        yield not_run(
            row, LIGGGHTS, "the moist bed is replayed contact by contact above; it has not been run in two engines"
        )
        yield impossible(
            row, YADE, f"{NO_MIGRATION}; a bridge has no force in overlap, so that a settled bed carries none"
        )
        for column in (WASHINO, EASO):
            yield impossible(row, column, "its liquid is a content per sphere, and its forces differ by the rows above")
        return
    for entry in json.loads(file.read_text()):
        yield Cell(row, entry["engine"], "measured", entry["deviation"], 1, None, entry["quantity"], entry["note"],
                   "../crosscheck/")  # fmt: skip
