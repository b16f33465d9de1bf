"""The campaign from first to last: a table for each batch, so that a killed study goes on, then one of all cases."""

from __future__ import annotations

import shutil
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.errors import PywetError
from pywet.evidence.stability import campaign, judge, running
from pywet.evidence.stability.cells import Batch
from pywet.files import read_csv, write_csv


def batches(cases: int) -> int:
    """Number of engine runs for that many cases."""
    return -(-cases // campaign.PER_BATCH)


def objected(batch: Batch, run_dir: Path) -> dict[str, str]:
    """What the independent replay objects to, by the cell of the worst record; key "" where a record names no sphere."""
    found: dict[str, str] = {}
    for name, (largest, limit, worst) in judge.replayed(run_dir).items():
        cell = batch.owner()[int(worst["i"])] if worst.get("i") else ""
        found[cell] = "; ".join(filter(None, [found.get(cell, ""), f"{name} off by {largest:.1e} (limit {limit:.0e})"]))
    return found


PASSIVE = "lian"
"""A tangential law with one coefficient for sliding and spin: it can only take energy. With two, as in Elskamp (28), (29), and a
torque that is the force times its arm, a sphere that slides at first ends with more energy than it had."""


def by_the_law(batch: Batch, names: set[str], run_dir: Path, allow_unstable: bool) -> set[str]:
    """Cells among `names` that make no energy with a passive tangential law: it was the law's, not the time stepping's."""
    if batch.effects.viscous_tangential in (None, PASSIVE) or not names:
        return set()
    passive = replace(
        batch,
        effects=batch.effects.model_copy(update={"viscous_tangential": PASSIVE}),
        cells=tuple(c for c in batch.cells if c.name in names),
    )
    left, stopped = running.run_cells(passive, run_dir, allow_unstable)
    if len(stopped) == len(passive.cells):
        return set()
    return {v.cell for v in judge.verdicts(left, run_dir) if v.state == "stable" and v.cell not in stopped}


def judged(batch: Batch, run_dir: Path, allow_unstable: bool = False) -> pd.DataFrame:
    """Run a batch and judge every cell of it: one row a cell."""
    left, stopped = running.run_cells(batch, run_dir, allow_unstable)
    rows: list[dict[str, Any]] = []
    replayed, books, found = {}, {"identity": 0.0, "drag": 0.0}, {}
    if len(stopped) < len(batch.cells):
        found = {v.cell: v for v in judge.verdicts(left, run_dir) if v.cell not in stopped}
        replayed, books = objected(left, run_dir), judge.budget(run_dir)
    made = {v.cell for v in found.values() if v.state == "energy"}
    explained = by_the_law(left, made, run_dir.with_name(run_dir.name + "-passive"), allow_unstable)
    for cell in batch.cells:
        said = stopped.get(cell.name, "")
        v = found.get(cell.name) or judge.Verdict(cell.name, False, 0.0, 0.0, 0.0, 0, said)
        objection = "; ".join(filter(None, [replayed.get(cell.name, ""), replayed.get("", "")]))
        state = v.state if v.state != "stable" or not objection else "replay"
        if state == "stable" and (books["identity"] > 1e-12 or books["drag"] > 1e-12):
            state = "energy"
        if state == "energy" and cell.name in explained and not objection:
            state = "law"
        rows.append({
            "case": cell.name, "state": state, "said": v.said, "ledger": v.ledger, "made": v.made, "allowed": v.allowed,
            "events": v.events, "replay": "" if v.said else objection or "agrees", "identity": books["identity"],
            **cell.says,
        })  # fmt: skip
    return pd.DataFrame(rows)


def batch_of_cases(seed: int, number: int, folder: Path, count: int = campaign.PER_BATCH) -> Path:
    """One batch of the campaign: writes FOLDER/batches/NNN.csv unless it is there; keeps the run of a batch with an objection."""
    run_dir = folder / "runs" / f"{seed}-{number:03d}"

    def make() -> pd.DataFrame:
        started = time.monotonic()
        table = judged(campaign.draw_batch(seed, number, count), run_dir)
        table["wall_s"] = (time.monotonic() - started) / len(table)
        shutil.rmtree(run_dir.with_name(run_dir.name + "-passive"), ignore_errors=True)
        if table["state"].isin(["stable", "law"]).all():
            shutil.rmtree(run_dir, ignore_errors=True)
        return table

    return running.once(folder / "batches" / f"{seed}-{number:03d}.csv", make)


def collect(paths: list[Path], out: Path) -> pd.DataFrame:
    """All cases in one table."""
    if not paths:
        raise PywetError(f"there are no batches to collect into {out}; expected at least one: ask for one case or more")
    table = pd.concat([read_csv(p, keep_default_na=False) for p in paths], ignore_index=True)
    write_csv(table, out)
    return table


def summary(table: pd.DataFrame) -> dict[str, Any]:
    """Counts of the states, and the extremes of what was measured."""
    return {
        "cases": len(table),
        "states": {str(k): int(v) for k, v in table["state"].value_counts().items()},
        "events": int(table["events"].sum()),
        "ledger": float(table["ledger"].max()),
        "identity": float(table["identity"].max()),
        "wall_s": float(table["wall_s"].sum()),
    }
