"""The page on sphere collisions: the paper's numbers beside ours, and its figures drawn anew."""

from __future__ import annotations

from pathlib import Path

from pywet.collisions.spheres import paper
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
NEAR_PERCENT = 0.4


def table(rtol: float = 1e-9) -> list[dict[str, str | float]]:
    """Where, what, printed, ours, difference in per cent, what halving the tolerance moves, note."""
    rows: list[dict[str, str | float]] = []
    for number in (*paper.NUMBERS, *paper.APPROXIMATE, *paper.NOT_REPRODUCED):
        ours, finer = number.compute(rtol), number.compute(0.5 * rtol)
        rows.append(
            {
                "where": number.where, "what": number.what, "printed": number.printed, "ours": ours,
                "difference_percent": 100.0 * (ours / number.printed - 1.0), "halved_moves": abs(finer / ours - 1.0),
                "note": number.note,
            }
        )  # fmt: skip
    return rows


def markdown(rows: list[dict[str, str | float]]) -> str:
    """The table as Markdown."""
    lines = ["| where | what | paper | ours | difference |", "|---|---|---|---|---|"]
    for r in rows:
        lines.append(
            f"| {r['where']} | {r['what']} | {r['printed']:g} | {r['ours']:.6g} | {r['difference_percent']:+.2f} % |"
        )
    return "\n".join(lines) + "\n"


def write(folder: Path) -> None:
    """`numbers.json`, `numbers.md` and `index.html` beside the figures."""
    rows = table()
    write_json(folder / "numbers.json", rows)
    with atomic_write(folder / "numbers.md") as temporary:
        temporary.write_text(markdown(rows))
    sections = [page.Section("The paper's numbers", page.paragraph(NUMBERS_SAID) + _numbers(rows), "numbers")]
    for name, title in FIGURES.items():
        if (folder / name).exists():
            sections.append(page.Section(title, page.picture_file(folder / name, ""), title.split(":")[0]))
    near = sum(abs(float(r["difference_percent"])) <= NEAR_PERCENT for r in rows[: len(paper.NUMBERS)])
    cards = [page.Card(f"{near} of {len(paper.NUMBERS)}", f"numbers of the paper met within {NEAR_PERCENT} %", "good")]
    if paper.NOT_REPRODUCED:
        cards.append(
            page.Card(str(len(paper.NOT_REPRODUCED)), "of its statements that its equations do not bear out", "bad")
        )
    page.write(folder / "index.html", "Collisions of wet spheres", LEAD, sections, cards, "snakemake sphere_collisions")


def _numbers(rows: list[dict[str, str | float]]) -> str:
    header = ["where", "what", "paper", "ours", "difference", "moved by half the tolerance", "note"]
    return page.table(
        header,
        [
            [
                page.Cell(str(r["where"])), page.Cell(str(r["what"]), left=True), f"{r['printed']:g}", f"{r['ours']:.7g}",
                page.Cell(f"{r['difference_percent']:+.2f} %", _grade(float(r["difference_percent"]))),
                f"{r['halved_moves']:.0e}", page.Cell(str(r["note"]), left=True),
            ]
            for r in rows
        ],
    )  # fmt: skip


def _grade(percent: float) -> page.Grade:
    size = abs(percent)
    return "good" if size <= NEAR_PERCENT else "fair" if size <= 1.0 else "bad"
