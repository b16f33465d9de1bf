"""The page on sphere collisions: the paper's numbers beside ours, and its figures drawn anew."""

from __future__ import annotations

import html
from pathlib import Path

from pywet.collisions.nspheres import paper
from pywet.files import atomic_write, write_json

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
    cells = "".join(
        f"<tr><td>{html.escape(str(r['where']))}<td>{html.escape(str(r['what']))}<td>{r['printed']:g}<td>{r['ours']:.7g}"
        f"<td>{r['difference_percent']:+.2f} %<td>{r['halved_moves']:.0e}"
        for r in rows
    )
    pictures = "".join(
        f"<figure><img src='{name}' alt='{html.escape(title)}'><figcaption>{html.escape(title)}</figcaption></figure>"
        for name, title in FIGURES.items()
        if (folder / name).exists()
    )
    with atomic_write(folder / "index.html") as temporary:
        temporary.write_text(
            "<!doctype html><meta charset='utf-8'><title>Collisions of wet spheres</title><style>body{font:15px sans-serif;"
            "max-width:70em;margin:2em auto}td,th{padding:.15em .7em;text-align:left}figure{display:inline-block;margin:1em}"
            "img{max-width:100%}</style><h1>Collisions of wet spheres (Davis 2023)</h1><p>Numbers printed in the paper's text "
            "and those of a converged solution of the same equations; see docs/sphere_collisions.md.</p><table><tr>"
            f"<th>where<th>what<th>paper<th>ours<th>difference<th>moved by half the tolerance{cells}</table>{pictures}\n"
        )
