"""The page on sphere collisions: numbers of Davis 2023 compared with ours, its figures, and the cost of accuracy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pywet.report import page
from pywet.util.files import write_csv
from studies.davis2023 import accuracy_cost, davis_numbers, engine, maps
from studies.davis2023 import davis_figures as figures
from studies.items import Item, sections

STARS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)
"""Instants t* of Fig. 5."""
PARTNERS = ("St$_n$ = 2", {"St_n": 2.0}, (0.0, 1.5, 2.59, 3.2, 4.0, 4.57, 5.2))
BELOW: dict[str, Any] = {"St_n": 2.0, "theta23_deg": -45.0, "h_min": 0.04}
TRANSFER = ("θ$_{23}$ = −45°", BELOW, (0.0, 0.3, 0.6, 0.7, 2.5, 4.5, 6.08, 7.0))
CAPILLARY: Any = (
    ("Ca → ∞", {}),
    *((f"Ca = {c:g}", {"Ca": c, "t_end": t}) for c, t in ((100.0, 250.0), (40.0, 60.0), (10.0, 60.0))),
)
THICK = ((0.005, 0.1, 2000.0), (0.01, 0.05, 1000.0), (0.02, 0.025, 500.0))
"""Film thickness, smallest gap and capillary number of the lines of Fig. 12a."""
GRID = 60
"""Number of angles and of Stokes numbers of the maps."""
ITEMS = {
    "figure_05": Item("Fig. 5: snapshots for St 2, 5, 10",
                      draw=lambda: figures.snapshots([(f"St$_n$ = {s:g}", {"St_n": s}, STARS) for s in (2.0, 5.0, 10.0)])),
    "figure_06": Item("Fig. 6: wet restitution over St", draw=figures.figure_6),
    "figure_07": Item("Fig. 7: gap 1-2 over time", draw=figures.figure_7),
    "figure_08": Item("Fig. 8: the same with capillary force", draw=figures.figure_8),
    "figure_09": Item("Fig. 9: wet restitution, capillary number", draw=lambda: figures.family("capillary number", CAPILLARY)),
    "figure_10a": Item("Fig. 10a: impact angle", draw=lambda: figures.family(
        "impact angle", [(f"{a:g}°", {"theta12_deg": a}) for a in (15.0, 22.5, 30.0, 37.5, 45.0, 60.0)])),
    "figure_10b": Item("Fig. 10b: contours", draw=lambda: figures.contour(
        maps.plane(np.linspace(1.0, 80.0, GRID), np.linspace(0.5, 20.0, GRID)))),
    "figure_11": Item("Fig. 11: gaps at 30°", draw=figures.figure_11),
    "figure_12a": Item("Fig. 12a: film thickness", draw=lambda: figures.family(
        "film thickness", [(f"ĥ$_a$ = {a:g}", {"h_a": a, "h_min": h, "Ca": c}) for a, h, c in THICK])),
    "figure_12b": Item("Fig. 12b: smallest gap", draw=lambda: figures.family(
        "smallest gap", [(f"ĥ$_m$ = {h:g}", {"h_min": h, "Ca": 1000.0}) for h in (0.02, 0.05, 0.1)])),
    "figure_13a": Item("Fig. 13a: friction", draw=lambda: figures.family(
        "friction", [(f"μ$_f$ = {m:g}", {"mu_f": m}) for m in (0.0, 0.1, 0.2)])),
    "figure_13b": Item("Fig. 13b: rotation rates and gaps", draw=figures.figure_13b),
    "figure_14": Item("Fig. 14: change of partner", draw=lambda: figures.snapshots([PARTNERS])),
    "figure_15": Item("Fig. 15: transfer", draw=lambda: figures.snapshots([TRANSFER])),
    "outcome_map": Item("Outcomes over impact angle and St (not in the paper)", draw=lambda: figures.outcome_map(
        maps.plane(np.linspace(0.5, 85.0, GRID), np.geomspace(0.5, 40.0, GRID)))),
    "accuracy_cost": Item("What accuracy costs", table=accuracy_cost.measured, draw=accuracy_cost.draw),
    "engine": Item("The same collision in the discrete element engine", table=engine.compare, draw=engine.draw),
}  # fmt: skip
LEAD = (
    "A few wet spheres in a plane through films, solid contacts and partings, after Davis (2023): the numbers printed in the "
    "paper with those of a converged solution of its equations, and its figures, drawn again."
)
NUMBERS_NOTE = (
    "What the paper prints and what its equations give; the last column but one is what halving the tolerance moves. "
    "See `docs/sphere_collisions.md` for those that differ."
)
NEAR_PERCENT = 0.4


def numbers(rtol: float = 1e-9) -> pd.DataFrame:
    """Tabulate the paper's numbers: position, quantity, printed and computed value, change with half the tolerance."""
    rows = []
    for n in (*davis_numbers.NUMBERS, *davis_numbers.APPROXIMATE, *davis_numbers.NOT_REPRODUCED):
        ours, finer = n.compute(rtol), n.compute(0.5 * rtol)
        difference = 100.0 * (ours / n.printed - 1.0)
        rows.append((n.where, n.what, n.printed, ours, difference, abs(finer / ours - 1.0), n.note))
    columns = ["where", "what", "printed", "ours", "difference_percent", "halved_moves", "note"]
    return pd.DataFrame(rows, columns=columns)


def write_page(folder: Path) -> Path:
    """Write the numbers, numbers.csv next to them, and all figures to `folder`/index.html."""
    table = numbers()
    write_csv(table, folder / "numbers.csv")
    body = page.paragraph(NUMBERS_NOTE) + page.table_of(table.itertuples(), {
        "where": lambda r: r.where,
        "what": lambda r: page.left(r.what),
        "paper": lambda r: f"{r.printed:g}",
        "ours": lambda r: f"{r.ours:.7g}",
        "difference": lambda r: page.Cell(f"{r.difference_percent:+.2f} %", _grade(r.difference_percent)),
        "moved by half the tolerance": lambda r: f"{r.halved_moves:.0e}",
        "note": lambda r: page.left(r.note),
    })  # fmt: skip
    made = [page.Section("The paper's numbers", body, "numbers"), *sections(folder, ITEMS)]
    met, missed = len(davis_numbers.NUMBERS), len(davis_numbers.NOT_REPRODUCED)
    near = (table["difference_percent"][:met].abs() <= NEAR_PERCENT).sum()
    cards = [
        page.Card(f"{near} of {met}", f"numbers of the paper met within {NEAR_PERCENT} %", "good"),
        page.Card(str(missed), "of its statements that its equations do not bear out", "bad"),
    ]
    return page.write(
        folder / "index.html", "Collisions of wet spheres", LEAD, made, cards, "snakemake sphere_collisions"
    )


def _grade(percent: float) -> page.Grade:
    size = abs(percent)
    return "good" if size <= NEAR_PERCENT else "fair" if size <= 1.0 else "bad"
