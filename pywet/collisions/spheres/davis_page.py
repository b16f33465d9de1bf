"""The page on sphere collisions: the paper's numbers beside ours, and its figures drawn anew."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pywet.collisions.spheres import davis_numbers
from pywet.files import atomic_write, write_json
from pywet.report import page

FIGURES = {
    "figure_05.png": "Fig. 5: snapshots for St 2, 5, 10",
    "figure_06.png": "Fig. 6: wet restitution over St",
    "figure_07.png": "Fig. 7: gap 1-2 over time",
    "figure_08.png": "Fig. 8: the same with capillary force",
    "figure_09.png": "Fig. 9: wet restitution, capillary number",
    "figure_10a.png": "Fig. 10a: impact angle",
    "figure_10b.png": "Fig. 10b: contours",
    "figure_11.png": "Fig. 11: gaps at 30°",
    "figure_12a.png": "Fig. 12a: film thickness",
    "figure_12b.png": "Fig. 12b: smallest gap",
    "figure_13a.png": "Fig. 13a: friction",
    "figure_13b.png": "Fig. 13b: rotation rates and gaps",
    "figure_14.png": "Fig. 14: change of partner",
    "figure_15.png": "Fig. 15: transfer",
    "outcome_map.png": "Outcomes over impact angle and St (not in the paper)",
    "accuracy_cost.png": "What accuracy costs",
    "engine.png": "The same collision in the discrete element engine",
}
LEAD = (
    "A few wet spheres in a plane through films, solid contacts and partings, after Davis (2023): the numbers printed in the "
    "paper beside those of a converged solution of its equations, and its figures drawn anew."
)
NUMBERS_SAID = (
    "What the paper prints and what its equations give; the last column but one is what halving the tolerance moves. "
    "See `docs/sphere_collisions.md` for those that differ."
)
HEADER = ("where", "what", "paper", "ours", "difference", "moved by half the tolerance", "note")
NEAR_PERCENT = 0.4


def numbers(rtol: float = 1e-9) -> pd.DataFrame:
    """Where, what, printed, ours, difference in per cent, what halving the tolerance moves, note."""
    rows = []
    for n in (*davis_numbers.NUMBERS, *davis_numbers.APPROXIMATE, *davis_numbers.NOT_REPRODUCED):
        ours, finer = n.compute(rtol), n.compute(0.5 * rtol)
        difference = 100.0 * (ours / n.printed - 1.0)
        rows.append((n.where, n.what, n.printed, ours, difference, abs(finer / ours - 1.0), n.note))
    columns = ["where", "what", "printed", "ours", "difference_percent", "halved_moves", "note"]
    return pd.DataFrame(rows, columns=columns)


def markdown(table: pd.DataFrame) -> str:
    """The table as Markdown."""
    lines = ["| where | what | paper | ours | difference |", "|---|---|---|---|---|"]
    for r in table.to_dict(orient="records"):
        difference = f"{r['difference_percent']:+.2f} %"
        lines.append(f"| {r['where']} | {r['what']} | {r['printed']:g} | {r['ours']:.6g} | {difference} |")
    return "\n".join(lines) + "\n"


def write_page(folder: Path) -> None:
    """`numbers.json`, `numbers.md` and `index.html` beside the figures."""
    table = numbers()
    rows = table.to_dict(orient="records")
    write_json(folder / "numbers.json", rows)
    with atomic_write(folder / "numbers.md") as temporary:
        temporary.write_text(markdown(table))
    cells = [
        [
            r["where"], page.Cell(r["what"], left=True), f"{r['printed']:g}", f"{r['ours']:.7g}",
            page.Cell(f"{r['difference_percent']:+.2f} %", _grade(r["difference_percent"])), f"{r['halved_moves']:.0e}",
            page.Cell(r["note"], left=True),
        ]
        for r in rows
    ]  # fmt: skip
    body = page.paragraph(NUMBERS_SAID) + page.table(HEADER, cells)
    sections = [page.Section("The paper's numbers", body, "numbers")]
    for name, title in FIGURES.items():
        if (folder / name).exists():
            sections.append(page.Section(title, page.picture_file(folder / name, ""), title.split(":")[0]))
    met, missed = len(davis_numbers.NUMBERS), len(davis_numbers.NOT_REPRODUCED)
    near = (table["difference_percent"][:met].abs() <= NEAR_PERCENT).sum()
    cards = [page.Card(f"{near} of {met}", f"numbers of the paper met within {NEAR_PERCENT} %", "good")]
    if missed:
        cards.append(page.Card(str(missed), "of its statements that its equations do not bear out", "bad"))
    page.write(folder / "index.html", "Collisions of wet spheres", LEAD, sections, cards, "snakemake sphere_collisions")


def _grade(percent: float) -> page.Grade:
    size = abs(percent)
    return "good" if size <= NEAR_PERCENT else "fair" if size <= 1.0 else "bad"
