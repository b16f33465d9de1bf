"""What became of a batch: it is run and replayed, and every cell of it is one row."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.evidence.stability import judge, running
from pywet.evidence.stability.cells import Batch
from reference_impl.replay.replay import replay


def objected(batch: Batch, run_dir: Path) -> dict[str, str]:
    """What the independent replay objects to, by the cell of the worst record; key "" where a record names no sphere."""
    said: dict[str, list[str]] = {}
    for name, q in replay(run_dir)["quantities"].items():
        if not q["ok"]:
            cell = batch.owner()[int(q["worst"]["i"])] if q["worst"].get("i") else ""
            said.setdefault(cell, []).append(f"{name} off by {q['largest']:.1e} (limit {q['tolerance']:.0e})")
    return {cell: "; ".join(sentences) for cell, sentences in said.items()}


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
    replayed, books, verdicts = {}, {"identity": 0.0, "drag": 0.0}, {}
    if len(stopped) < len(batch.cells):
        verdicts = {v.cell: v for v in judge.verdicts(left, run_dir) if v.cell not in stopped}
        replayed, books = objected(left, run_dir), judge.budget(run_dir)
    made = {v.cell for v in verdicts.values() if v.state == "energy"}
    explained = by_the_law(left, made, run_dir.with_name(run_dir.name + "-passive"), allow_unstable)
    for cell in batch.cells:
        said = stopped.get(cell.name, "")
        v = verdicts.get(cell.name) or judge.Verdict(cell.name, False, 0.0, 0.0, 0.0, 0, said)
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
